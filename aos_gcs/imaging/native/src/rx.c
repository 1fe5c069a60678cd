/* Moments of an image's bands, and the Mahalanobis distance of each pixel, in one pass each. */

#include "kernels.h"

#include <math.h>

/* Pixels worked on at a time: their planes stay in the innermost cache, and single precision sums keep their digits. */
#define CHUNK 512
#define MOST_BANDS 8

/* Lays four bands out: four pixels are turned at a time. */
INLINE void split_four(const float *p, long n, const float *shift, float planes[MOST_BANDS][CHUNK]) {
    v4 own_shift;
    memcpy(&own_shift, shift, sizeof own_shift);
    long k = 0;
    for (; k + 4 <= n; k += 4) {
        v4 a, b, c, d;
        memcpy(&a, p + 4 * k, sizeof a);
        memcpy(&b, p + 4 * k + 4, sizeof b);
        memcpy(&c, p + 4 * k + 8, sizeof c);
        memcpy(&d, p + 4 * k + 12, sizeof d);
        a -= own_shift, b -= own_shift, c -= own_shift, d -= own_shift;
        const v4 ac_low = __builtin_shufflevector(a, c, 0, 4, 1, 5), ac_high = __builtin_shufflevector(a, c, 2, 6, 3, 7);
        const v4 bd_low = __builtin_shufflevector(b, d, 0, 4, 1, 5), bd_high = __builtin_shufflevector(b, d, 2, 6, 3, 7);
        const v4 turned[4] = {
            __builtin_shufflevector(ac_low, bd_low, 0, 4, 1, 5), __builtin_shufflevector(ac_low, bd_low, 2, 6, 3, 7),
            __builtin_shufflevector(ac_high, bd_high, 0, 4, 1, 5), __builtin_shufflevector(ac_high, bd_high, 2, 6, 3, 7)};
        for (int band = 0; band < 4; band++) memcpy(planes[band] + k, &turned[band], sizeof turned[band]);
    }
    for (; k < n; k++)
        for (int band = 0; band < 4; band++) planes[band][k] = p[4 * k + band] - shift[band];
}

/* The same for bytes: a pixel is one number, of which each band is shifted down. */
INLINE void split_four_bytes(const uint8_t *p, long n, const float *shift, float planes[MOST_BANDS][CHUNK]) {
    uint32_t pixels[CHUNK];
    memcpy(pixels, p, (size_t)n * sizeof *pixels);
    for (int band = 0; band < 4; band++) {
        const int bits = 8 * (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? band : 3 - band);
        for (long k = 0; k < n; k++) planes[band][k] = (float)(int32_t)(pixels[k] >> bits & 255u) - shift[band];
    }
}

/* Lays the bands of n pixels out in planes without a shift, and returns how many are finite; others become 0. */
INLINE long split(const void *image, int kind, long first, long n, const int bands, const float *shift,
                  float planes[MOST_BANDS][CHUNK], float *known) {
    if (bands == 4 && kind == PIXEL_F32) split_four((const float *)image + first * 4, n, shift, planes);
    else if (bands == 4 && kind == PIXEL_U8) split_four_bytes((const uint8_t *)image + first * 4, n, shift, planes);
    else
        for (int band = 0; band < bands; band++) {
            const long from = first * bands + band;
            for (long k = 0; k < n; k++)
                planes[band][k] = (kind == PIXEL_U8    ? (float)((const uint8_t *)image)[from + k * bands]
                                   : kind == PIXEL_U16 ? (float)((const uint16_t *)image)[from + k * bands]
                                                       : ((const float *)image)[from + k * bands]) -
                                  shift[band];
        }
    for (int band = 0; band < bands; band++)
        for (long k = n; k < CHUNK; k++) planes[band][k] = 0.0f;
    if (kind != PIXEL_F32) return n;
    /* Of finite numbers the product with 0 is 0; of all others it is no number, and no sum of it is one. */
    for (long k = 0; k < CHUNK; k++) known[k] = 0.0f;
    for (int band = 0; band < bands; band++)
        for (long k = 0; k < CHUNK; k++) known[k] += planes[band][k] * 0.0f;
    long finite = 0;
    for (long k = 0; k < n; k++) finite += known[k] == 0.0f;
    if (finite < n)
        for (int band = 0; band < bands; band++)
            for (long k = 0; k < n; k++) planes[band][k] = known[k] == 0.0f ? planes[band][k] : 0.0f;
    return finite;
}

INLINE double sum_of(v8 lanes) {
    double total = 0.0;
    for (int lane = 0; lane < 8; lane++) total += lanes[lane];
    return total;
}

INLINE void moments(const void *image, int kind, long pixels, const int bands, const float *shift, double *sums,
                    double *products, int64_t *known) {
    float planes[MOST_BANDS][CHUNK], finite[CHUNK];
    for (long first = 0; first < pixels; first += CHUNK) {
        *known += split(image, kind, first, SMALLER(pixels - first, CHUNK), bands, shift, planes, finite);
        /* All side by side: each sum alone would wait for itself. */
        v8 sum[MOST_BANDS] = {{0}}, product[MOST_BANDS][MOST_BANDS] = {{{0}}};
        for (long k = 0; k < CHUNK; k += 8)
            for (int i = 0; i < bands; i++) {
                const v8 own = load8(planes[i] + k);
                sum[i] += own;
                for (int j = 0; j <= i; j++) product[i][j] += own * load8(planes[j] + k);
            }
        for (int i = 0; i < bands; i++) {
            sums[i] += sum_of(sum[i]);
            for (int j = 0; j <= i; j++) products[i * bands + j] += sum_of(product[i][j]);
        }
    }
}

INLINE void distances(const void *image, int kind, long pixels, const int bands, const float *mean,
                      const float *whitening, float *scores) {
    float planes[MOST_BANDS][CHUNK], finite[CHUNK], own_scores[CHUNK];
    for (long first = 0; first < pixels; first += CHUNK) {
        const long n = SMALLER(pixels - first, CHUNK);
        const int gaps = split(image, kind, first, n, bands, mean, planes, finite) < n;
        float *own = scores + first;
        for (long k = 0; k < CHUNK; k += 8) {
            v8 score = {0};
            for (int i = 0; i < bands; i++) {
                v8 whitened = whitening[i * bands] * load8(planes[0] + k);
                for (int j = 1; j <= i; j++) whitened += whitening[i * bands + j] * load8(planes[j] + k);
                score += whitened * whitened;
            }
            memcpy(own_scores + k, &score, sizeof score);
        }
        memcpy(own, own_scores, (size_t)n * sizeof *own);
        if (gaps)
            for (long k = 0; k < n; k++) own[k] = finite[k] == 0.0f ? own[k] : NAN;
    }
}

#define WITH_KIND(function, bands, ...)                                                                                \
    (kind == PIXEL_U8 ? function(image, PIXEL_U8, pixels, bands, __VA_ARGS__)                                          \
     : kind == PIXEL_U16 ? function(image, PIXEL_U16, pixels, bands, __VA_ARGS__)                                      \
                         : function(image, PIXEL_F32, pixels, bands, __VA_ARGS__))
#define WITH_BANDS(function, ...)                                                                                      \
    (bands == 4 ? WITH_KIND(function, 4, __VA_ARGS__) : bands == 1 ? WITH_KIND(function, 1, __VA_ARGS__)               \
                                                                   : WITH_KIND(function, bands, __VA_ARGS__))

/* Adds the sums of an image's bands without a shift, those of their products (lower triangle, row by row), and the
   number of pixels without a band that is not finite, which alone take part. At most MOST_BANDS bands. */
void aos_moments(const void *image, int kind, long pixels, int bands, const float *shift, double *sums,
                 double *products, int64_t *known) {
    WITH_BANDS(moments, shift, sums, products, known);
}

/* Writes the squared length of whitening (pixel - mean) for each pixel; whitening is a lower triangle, row by row. NaN
   where a band is not finite. At most MOST_BANDS bands. */
void aos_distances(const void *image, int kind, long pixels, int bands, const float *mean, const float *whitening,
                   float *scores) {
    WITH_BANDS(distances, mean, whitening, scores);
}
