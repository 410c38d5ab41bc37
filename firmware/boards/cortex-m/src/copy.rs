//! Memory copied and cleared, as compilers ask for it by name.
//!
//! What comes with the compiler copies what is not known to be aligned byte by byte, or by shifting words together:
//! three instructions a byte. A Cortex-M with Thumb-2 loads and stores words wherever they lie, and eight at once where
//! they are aligned. Not for the memory of devices, nor with `UNALIGN_TRP` set, which it is not after a reset.
//!
//! `mrroc-qemu-memory` of `firmware/boards/qemu-mps2-an386` compares them with loops over bytes.

use core::arch::global_asm;

// r0 is kept: memcpy returns it. Of r2, bytes left less 16 where words of 16 are done: its lower bits tell the rest.
global_asm!(
    "
    .section .text.memcpy, \"ax\", %progbits
    .p2align 2
    .global memcpy, __aeabi_memcpy, __aeabi_memcpy4, __aeabi_memcpy8
    .type memcpy, %function
    .type __aeabi_memcpy, %function
    .type __aeabi_memcpy4, %function
    .type __aeabi_memcpy8, %function
    .thumb_func
memcpy:
    .thumb_func
__aeabi_memcpy:
    .thumb_func
__aeabi_memcpy4:
    .thumb_func
__aeabi_memcpy8:
    mov     r12, r0
    subs    r2, #16
    blo     4f
    orr     r3, r0, r1
    lsls    r3, r3, #30
    bne     3f
    subs    r2, #16
    blo     2f
    push    {{r4-r10}}
1:  ldmia   r1!, {{r3-r10}}
    stmia   r12!, {{r3-r10}}
    subs    r2, #32
    bhs     1b
    pop     {{r4-r10}}
2:  adds    r2, #16
    blo     4f
3:  ldr     r3, [r1], #4
    str     r3, [r12], #4
    ldr     r3, [r1], #4
    str     r3, [r12], #4
    ldr     r3, [r1], #4
    str     r3, [r12], #4
    ldr     r3, [r1], #4
    str     r3, [r12], #4
    subs    r2, #16
    bhs     3b
4:  lsls    r3, r2, #29
    itttt   cs
    ldrcs   r3, [r1], #4
    strcs   r3, [r12], #4
    ldrcs   r3, [r1], #4
    strcs   r3, [r12], #4
    itt     mi
    ldrmi   r3, [r1], #4
    strmi   r3, [r12], #4
    lsls    r3, r2, #31
    itt     cs
    ldrhcs  r3, [r1], #2
    strhcs  r3, [r12], #2
    itt     mi
    ldrbmi  r3, [r1]
    strbmi  r3, [r12]
    bx      lr
    .size memcpy, . - memcpy

    .section .text.__aeabi_memclr, \"ax\", %progbits
    .p2align 2
    .global __aeabi_memclr, __aeabi_memclr4, __aeabi_memclr8
    .type __aeabi_memclr, %function
    .type __aeabi_memclr4, %function
    .type __aeabi_memclr8, %function
    .thumb_func
__aeabi_memclr:
    .thumb_func
__aeabi_memclr4:
    .thumb_func
__aeabi_memclr8:
    lsls    r3, r0, #30
    mov     r2, #0
    mov     r3, #0
    bne     3f
    subs    r1, #16
    blo     2f
1:  strd    r2, r3, [r0], #8
    strd    r2, r3, [r0], #8
    subs    r1, #16
    bhs     1b
2:  lsls    r3, r1, #29
    itt     cs
    strcs   r2, [r0], #4
    strcs   r2, [r0], #4
    it      mi
    strmi   r2, [r0], #4
    lsls    r3, r1, #31
    it      cs
    strhcs  r2, [r0], #2
    it      mi
    strbmi  r2, [r0]
    bx      lr
3:  subs    r1, #16
    blo     2b
4:  str     r2, [r0], #4
    str     r2, [r0], #4
    str     r2, [r0], #4
    str     r2, [r0], #4
    subs    r1, #16
    bhs     4b
    b       2b
    .size __aeabi_memclr, . - __aeabi_memclr
"
);
