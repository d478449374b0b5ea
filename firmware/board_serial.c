/* A robot at the other end of a serial line, USART1 on the pins PA9 and PA10, 115200 baud. Each cycle is a line of readings; the answer has
   the two outputs and the two speeds. Numbers are the bits of floats, as eight hexadecimal digits. */

#include <stdint.h>
#include <string.h>

#include "board.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define RCC_AHB1ENR REGISTER(0x40023830u)
#define RCC_APB2ENR REGISTER(0x40023844u)
#define GPIOA_MODER REGISTER(0x40020000u)
#define GPIOA_AFRH REGISTER(0x40020024u)
#define USART1_SR REGISTER(0x40011000u)
#define USART1_DR REGISTER(0x40011004u)
#define USART1_BRR REGISTER(0x40011008u)
#define USART1_CR1 REGISTER(0x4001100cu)

enum { RECEIVED = 1 << 5, CAN_SEND = 1 << 7 };

void board_begin(void)
{
    RCC_AHB1ENR |= 1u;
    RCC_APB2ENR |= 1u << 4;
    /* Both pins have their alternate function 7. */
    GPIOA_MODER = (GPIOA_MODER & ~(0xfu << 18)) | 0xau << 18;
    GPIOA_AFRH = (GPIOA_AFRH & ~(0xffu << 4)) | 0x77u << 4;
    /* Of the 16 MHz that the processor starts with. */
    USART1_BRR = 16000000u / 115200u;
    USART1_CR1 = 1u << 13 | 1u << 3 | 1u << 2;
}

static void put(char c)
{
    while (!(USART1_SR & CAN_SEND)) {
    }
    USART1_DR = (uint8_t)c;
}

static char get(void)
{
    while (!(USART1_SR & RECEIVED)) {
    }
    return (char)USART1_DR;
}

static void put_text(const char *text)
{
    while (*text) {
        put(*text++);
    }
}

static void put_float(float number)
{
    uint32_t bits;
    int digit;
    memcpy(&bits, &number, sizeof bits);
    for (digit = 28; digit >= 0; digit -= 4) {
        put("0123456789abcdef"[bits >> digit & 15u]);
    }
}

void board_checked(int differing)
{
    put_text(differing == 0 ? "check 0\n" : "check failed: this processor has other bits\n");
}

int board_read(float *inputs, int count)
{
    uint32_t bits = 0;
    int digits = 0, read = 0, is_wrong = 0;
    for (;;) {
        const char c = get();
        const int value = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
        if (value >= 0) {
            bits = bits << 4 | (uint32_t)value;
            digits++;
        } else if (c == ' ' || c == '\n') {
            if (digits == 8 && read < count) {
                memcpy(&inputs[read++], &bits, sizeof bits);
            } else if (digits != 0) {
                is_wrong = 1;
            }
            digits = 0;
            if (c == '\n') {
                return read == count && !is_wrong;
            }
        } else if (c != '\r') {
            is_wrong = 1;
        }
    }
}

void board_drive(const float *outputs, const float *speeds)
{
    int i;
    for (i = 0; i < 4; i++) {
        put_float(i < 2 ? outputs[i] : speeds[i - 2]);
        put(i < 3 ? ' ' : '\n');
    }
}
