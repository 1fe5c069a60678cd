/* Bilinear samples of images, added to sums, for all types of pixels. */

#ifndef AOS_SAMPLES_H
#define AOS_SAMPLES_H

#include "kernels.h"

/* Places between four pixels of an image. */
typedef struct {
    /* Number of the value at the upper left pixel's first band. */
    int32_t *offset;
    /* Shares of the right and of the lower pixels. */
    float *share_u, *share_v;
} sample_places;

/* What the places in an image depend on. */
typedef struct {
    float u_max, v_max;
    int32_t column_max, row_max, row_step, bands;
} image_size;

INLINE image_size size_of(int64_t height, int64_t width, int bands) {
    return (image_size){(float)(width - 1),   (float)(height - 1),      (int32_t)(width - 2),
                        (int32_t)(height - 2), (int32_t)(width * bands), bands};
}

/* Notes the place of the pixel (u, v), clamped at the border, as the k-th; what is no number becomes 0. */
INLINE void note_place(image_size size, float u, float v, long k, sample_places places) {
    u = u > 0.0f ? u : 0.0f;
    v = v > 0.0f ? v : 0.0f;
    u = u < size.u_max ? u : size.u_max;
    v = v < size.v_max ? v : size.v_max;
    int32_t column = (int32_t)u, row = (int32_t)v;
    column = SMALLER(column, size.column_max);
    row = SMALLER(row, size.row_max);
    places.share_u[k] = u - (float)column;
    places.share_v[k] = v - (float)row;
    places.offset[k] = row * size.row_step + column * size.bands;
}

INLINE v8 load8_u16(const uint16_t *p) {
#ifdef __AVX2__
    return (v8)_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128((const __m128i *)p)));
#else
    return (v8){p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]};
#endif
}

INLINE v8 load8_u8(const uint8_t *p) {
#ifdef __AVX2__
    return (v8)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)p)));
#else
    return (v8){p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]};
#endif
}

#define PIXEL float
#define LOAD8 load8
#define NAME(name) name##_f32
#include "samples_of_type.h"
#undef PIXEL
#undef LOAD8
#undef NAME

#define PIXEL uint16_t
#define LOAD8 load8_u16
#define NAME(name) name##_u16
#include "samples_of_type.h"
#undef PIXEL
#undef LOAD8
#undef NAME

#define PIXEL uint8_t
#define LOAD8 load8_u8
#define NAME(name) name##_u8
#include "samples_of_type.h"
#undef PIXEL
#undef LOAD8
#undef NAME

/* Adds the samples at n places, from the first one on, to sums. */
INLINE void add_samples(const void *image, const int kind, image_size size, const int bands, sample_places places,
                        long first, long n, float *total) {
    const int32_t *offset = places.offset + first;
    const float *share_u = places.share_u + first, *share_v = places.share_v + first;
    if (kind == PIXEL_U8) add_samples_u8(image, size.row_step, bands, offset, share_u, share_v, n, total);
    else if (kind == PIXEL_U16) add_samples_u16(image, size.row_step, bands, offset, share_u, share_v, n, total);
    else add_samples_f32(image, size.row_step, bands, offset, share_u, share_v, n, total);
}

/* Cells of a row at most whose pixels are computed at a time. */
#define CELLS 64

/* Pixels of some cells of a row, and which of these an image sees. */
typedef struct {
    float u[CELLS], v[CELLS];
    uint8_t is_seen[CELLS];
} cell_pixels;

/* Map through a lens: its own pixel u and v for each pixel of the ideal camera and of a rim around them. */
typedef struct {
    /* NULL: there is no lens. */
    const float *u, *v;
    int64_t height, width, rim;
} lens_map;

/* Takes n pixels of the ideal camera to those of the lens. */
INLINE void through_lens(lens_map lens, long n, cell_pixels *cells) {
    const image_size size = size_of(lens.height, lens.width, 1);
    int32_t offset[CELLS];
    float share_u[CELLS], share_v[CELLS], u[CELLS] = {0}, v[CELLS] = {0};
    const sample_places places = {offset, share_u, share_v};
    const float rim = (float)lens.rim;
    for (long k = 0; k < n; k++) note_place(size, cells->u[k] + rim, cells->v[k] + rim, k, places);
    add_samples(lens.u, PIXEL_F32, size, 1, places, 0, n, u);
    add_samples(lens.v, PIXEL_F32, size, 1, places, 0, n, v);
    memcpy(cells->u, u, sizeof u);
    memcpy(cells->v, v, sizeof v);
}

/* Adds what an image shows at the pixels of n cells to their sums, and returns whether it sees any of them. */
INLINE int add_seen(const void *image, const int kind, image_size size, const int bands, long n, cell_pixels *cells,
                    float *total, uint16_t *count) {
    const float u_end = size.u_max + 0.5f, v_end = size.v_max + 0.5f;
    int32_t offset[CELLS];
    float share_u[CELLS], share_v[CELLS];
    const sample_places places = {offset, share_u, share_v};
    int is_any_seen = 0;
    for (long k = 0; k < n; k++) {
        const float u = cells->u[k], v = cells->v[k];
        cells->is_seen[k] &= (u >= -0.5f) & (u <= u_end) & (v >= -0.5f) & (v <= v_end);
        count[k] += cells->is_seen[k];
        is_any_seen |= cells->is_seen[k];
        note_place(size, u, v, k, places);
    }
    for (long k = 0, end = 0; k < n; k = ++end) {
        while (end < n && cells->is_seen[end]) end++;
        add_samples(image, kind, size, bands, places, k, end - k, total + k * bands);
    }
    return is_any_seen;
}

/* Returns whether any of the sums of a tile is no finite number. */
INLINE int has_gaps(const float *total, long rows, long step, long n) {
    float zero[8] = {0};
    for (long row = 0; row < rows; row++, total += step) {
        long k = 0;
        for (; k + 8 <= n; k += 8)
            for (int lane = 0; lane < 8; lane++) zero[lane] += total[k + lane] * 0.0f;
        for (; k < n; k++) zero[0] += total[k] * 0.0f;
    }
    int gaps = 0;
    for (int lane = 0; lane < 8; lane++) gaps |= !(zero[lane] == 0.0f);
    return gaps;
}

#endif
