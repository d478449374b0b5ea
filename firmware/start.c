/* The start of an STM32F4: memory, the unit for floats, then `main`. */

#include <stdint.h>

extern uint32_t stack_end, data_load, data_begin, data_end, bss_begin, bss_end;
int main(void);

void start(void);

void start(void)
{
    uint32_t *from = &data_load;
    uint32_t *to;
    *(volatile uint32_t *)0xe000ed88u |= 0xfu << 20;
    __asm__ volatile("dsb\n isb");
    for (to = &data_begin; to < &data_end; to++) {
        *to = *from++;
    }
    for (to = &bss_begin; to < &bss_end; to++) {
        *to = 0;
    }
    main();
}

/* Whatever goes wrong, the watchdog of a robot should find it here. */
static void stop(void)
{
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    &stack_end, (void *)start, (void *)stop, (void *)stop, (void *)stop, (void *)stop, (void *)stop, 0, 0, 0, 0,
    (void *)stop, (void *)stop, 0, (void *)stop, (void *)stop,
};
