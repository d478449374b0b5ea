/* Functions that compilers call by themselves, for programs without a library. */

#include <stddef.h>

void *memcpy(void *to, const void *from, size_t count);
void *memset(void *to, int byte, size_t count);

void *memcpy(void *to, const void *from, size_t count)
{
    volatile char *there = to;
    const char *here = from;
    while (count-- > 0) {
        *there++ = *here++;
    }
    return to;
}

void *memset(void *to, int byte, size_t count)
{
    volatile char *there = to;
    while (count-- > 0) {
        *there++ = (char)byte;
    }
    return to;
}
