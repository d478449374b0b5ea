/* The start of a Cortex-M in qemu, without its maker's files: it runs `run`, and ends with its result as qemu's exit code. */

#include <stdint.h>

extern uint32_t stack_end, data_load, data_begin, data_end, bss_begin, bss_end;
int run(void);

/* Semihosting's SYS_EXIT_EXTENDED, for the reason that an application has ended. */
static void end(uint32_t code)
{
    static uint32_t block[2];
    register uint32_t call __asm__("r0") = 0x20u;
    register uint32_t *argument __asm__("r1") = block;
    block[0] = 0x20026u;
    block[1] = code;
    __asm__ volatile("bkpt 0xab" : "+r"(call) : "r"(argument) : "memory");
    for (;;) {
    }
}

static void start(void)
{
    uint32_t *from = &data_load;
    uint32_t *to;
#ifdef __ARM_FP
    /* Turns the unit for floats on. */
    *(volatile uint32_t *)0xe000ed88u |= 0xfu << 20;
    __asm__ volatile("dsb\n isb");
#endif
    for (to = &data_begin; to < &data_end; to++) {
        *to = *from++;
    }
    for (to = &bss_begin; to < &bss_end; to++) {
        *to = 0;
    }
    end((uint32_t)run());
}

static void fault(void)
{
    end(99u);
}

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    &stack_end, (void *)start, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault, 0, 0, 0, 0,
    (void *)fault, (void *)fault, 0, (void *)fault, (void *)fault,
};
