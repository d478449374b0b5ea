/* An ATmega in simavr: it runs `run`, writes its result as a line to the serial port, and sleeps for good, which ends simavr. */

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

int run(void);

static void put(char c)
{
    while (!(UCSR0A & (1 << UDRE0))) {
    }
    UDR0 = (uint8_t)c;
}

int main(void)
{
    char digits[6];
    int count = 0;
    int result = run();
    UCSR0B = 1 << TXEN0;
    do {
        digits[count++] = (char)('0' + result % 10);
        result /= 10;
    } while (result > 0);
    while (count > 0) {
        put(digits[--count]);
    }
    put('\n');
    while (!(UCSR0A & (1 << TXC0))) {
    }
    cli();
    sleep_enable();
    sleep_cpu();
    return 0;
}
