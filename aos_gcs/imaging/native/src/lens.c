/* Images of distorting lenses warped onto a plane and added to its sums in one pass.

   Apart from warp.c, whose loops are slower with this case in them. */

#include "samples.h"

typedef struct {
    const void *pixels;
    /* First column that the ideal camera covers and the one behind the last, for all rows of the raster. */
    const int32_t *spans;
    /* Homography from cells (column, row, 1) of the raster to pixels of the ideal camera, row by row. */
    double H[9];
    int64_t height, width;
    lens_map lens;
} lens_image;

/* Adds an image to the columns of a row, and returns whether it shows any of them. */
INLINE int add_columns(const lens_image *own, const int kind, const int bands, long row, long first, long n, float *total,
                       uint16_t *count) {
    const double *H = own->H;
    /* Double precision at the first column, single precision from there on. */
    const float u = (float)(H[0] * first + H[1] * row + H[2]), du = (float)H[0];
    const float v = (float)(H[3] * first + H[4] * row + H[5]), dv = (float)H[3];
    const float w = (float)(H[6] * first + H[7] * row + H[8]), dw = (float)H[6];
    cell_pixels cells;
    for (long k = 0; k < n; k++) {
        const float step = (float)k, per_depth = 1.0f / (w + dw * step);
        cells.u[k] = (u + du * step) * per_depth;
        cells.v[k] = (v + dv * step) * per_depth;
        cells.is_seen[k] = 1;
    }
    if (own->lens.u) through_lens(own->lens, n, &cells);
    const image_size size = size_of(own->height, own->width, bands);
    return add_seen(own->pixels, kind, size, bands, n, &cells, total + first * bands, count + first);
}

INLINE int add_rows(const lens_image *images, long number, const int kind, const int bands, long first_row, long end_row,
                    long columns, float *total, uint16_t *count, uint8_t *covers) {
    memset(covers, 0, (size_t)number);
    int gaps = 0;
    for (long row = first_row; row < end_row; row++, total += columns * bands, count += columns) {
        for (long i = 0; i < number; i++) {
            const long first = images[i].spans[2 * row], end = images[i].spans[2 * row + 1];
            for (long start = first; start < end; start += CELLS)
                covers[i] |= (uint8_t)add_columns(images + i, kind, bands, row, start, SMALLER(end - start, CELLS), total,
                                                  count);
        }
        if (kind == PIXEL_F32) gaps |= has_gaps(total, 1, 0, columns * bands);
    }
    return gaps;
}

#define ADD(kind, bands) add_rows(images, number, kind, bands, first_row, end_row, columns, total, count, covers)
#define ADD_BANDS(kind) (bands == 4 ? ADD(kind, 4) : bands == 1 ? ADD(kind, 1) : ADD(kind, bands))

/* Does what aos_add_warped does for images of which any has a lens. */
int aos_add_through_lenses(const lens_image *images, long number, int kind, int bands, long first_row, long end_row,
                           long columns, float *total, uint16_t *count, uint8_t *covers) {
    return kind == PIXEL_U8 ? ADD_BANDS(PIXEL_U8) : kind == PIXEL_U16 ? ADD_BANDS(PIXEL_U16) : ADD_BANDS(PIXEL_F32);
}
