/* Start of a program on a Cortex-M4, which reads its stack and its first instruction from the vectors. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t _stack[];
extern int main(void);
extern void initialise_monitor_handles(void);
void _begin(void);
void _init(void);
void _fini(void);

void _begin(void) {
    /* Coprocessors 10 and 11 are the floating-point unit (Armv7-M, CPACR). */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    initialise_monitor_handles();
    exit(main());
}

/* The C library calls these two; nothing is to be done in them. */
void _init(void) {}
void _fini(void) {}

static void fault(void) {
    _Exit(99);
}

static const struct {
    uint32_t *stack;
    void (*handlers[6])(void);
} vectors __attribute__((section(".vectors"), used)) = {_stack, {_begin, fault, fault, fault, fault, fault}};
