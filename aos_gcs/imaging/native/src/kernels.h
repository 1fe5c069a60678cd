/* Common parts of the kernels: vectors and types of pixels.

   On x86 the library is compiled twice, for processors with AVX2 and for all others. Products and sums are never fused,
   so that both give the same digits. */

#ifndef AOS_KERNELS_H
#define AOS_KERNELS_H

#include <stdint.h>
#include <string.h>
#ifdef __AVX2__
#include <immintrin.h>
#endif

typedef float v4 __attribute__((vector_size(16)));
typedef float v8 __attribute__((vector_size(32)));

/* Types of pixels, as the callers number them. */
enum { PIXEL_U8 = 0, PIXEL_U16 = 1, PIXEL_F32 = 2 };

#define INLINE static inline __attribute__((always_inline))
#define SMALLER(a, b) ((a) < (b) ? (a) : (b))

INLINE v8 load8(const float *p) {
    v8 values;
    memcpy(&values, p, sizeof values);
    return values;
}

#endif
