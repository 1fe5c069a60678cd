/* Images warped onto a plane and added to its sums in one pass. */

#include "samples.h"

#include <math.h>

/* Cells of a row whose pixels are computed at a time. */
#define BLOCK 64
/* Cells whose sums take up all images at a time: long rows, as the processor then fetches ahead what images show. */
#define TILE_COLUMNS 512
#define TILE_ROWS 1

typedef struct {
    const void *pixels;
    /* First column that the image covers and the one behind the last, for all rows of the raster. */
    const int32_t *spans;
    /* Homography from cells (column, row, 1) of the raster to pixels, row by row. */
    double H[9];
    int64_t height, width;
} warped_image;

/* Adds the columns of a row to its sums. */
INLINE void add_row(const warped_image *own, const int kind, const int bands, long row, long first, long end,
                    float *total) {
    const image_size size = size_of(own->height, own->width, bands);
    const double *H = own->H;
    const float du = (float)H[0], dv = (float)H[3], dw = (float)H[6];
    int32_t offset[BLOCK];
    float share_u[BLOCK], share_v[BLOCK];
    const sample_places places = {offset, share_u, share_v};
    for (long start = first; start < end; start += BLOCK) {
        /* Double precision at the start of a block, single precision within it. */
        const float u0 = (float)(H[0] * start + H[1] * row + H[2]);
        const float v0 = (float)(H[3] * start + H[4] * row + H[5]);
        const float w0 = (float)(H[6] * start + H[7] * row + H[8]);
        /* Beyond the span nothing is read. */
        for (int k = 0; k < BLOCK; k++) {
            const float step = (float)k, per_depth = 1.0f / (w0 + dw * step);
            note_place(size, (u0 + du * step) * per_depth, (v0 + dv * step) * per_depth, k, places);
        }
        add_samples(own->pixels, kind, size, bands, places, 0, SMALLER(end - start, BLOCK), total + start * bands);
    }
}

INLINE void add_tile(const warped_image *image, const int kind, const int bands, long first_row, long end_row, long left,
                     long right, long columns, float *total, uint16_t *count) {
    for (long row = first_row; row < end_row; row++, total += columns * bands, count += columns) {
        long first = image->spans[2 * row], end = image->spans[2 * row + 1];
        first = first > left ? first : left;
        end = SMALLER(end, right);
        if (first >= end) continue;
        for (long x = first; x < end; x++) count[x]++;
        add_row(image, kind, bands, row, first, end, total);
    }
}

INLINE void divide(const float *total, const uint16_t *count, long cells, const int bands, float *mean) {
    for (long i = 0; i < cells; i++) {
        const float number = count[i] ? (float)count[i] : NAN;
        for (int band = 0; band < bands; band++) mean[i * bands + band] = total[i * bands + band] / number;
    }
}

INLINE int add_rows(const warped_image *images, long number, const int kind, const int bands, long first_row,
                     long end_row, long columns, const int is_mean, float *total, uint16_t *count, uint8_t *covers) {
    for (long i = 0; i < number; i++) {
        covers[i] = 0;
        for (long row = first_row; row < end_row; row++)
            covers[i] |= images[i].spans[2 * row] < images[i].spans[2 * row + 1];
    }
    int gaps = 0;
    /* Tile by tile, so that the sums, and what images turned against the raster show of a tile, stay in the cache. */
    for (long row = first_row; row < end_row; row += TILE_ROWS) {
        const long tile_rows = SMALLER(end_row - row, (long)TILE_ROWS);
        float *tile_total = total + (row - first_row) * columns * bands;
        uint16_t *tile_count = count + (row - first_row) * columns;
        for (long column = 0; column < columns; column += TILE_COLUMNS) {
            const long width = SMALLER(columns - column, (long)TILE_COLUMNS);
            float *own_total = tile_total + column * bands;
            uint16_t *own_count = tile_count + column;
            if (is_mean)
                for (long i = 0; i < tile_rows; i++) {
                    memset(own_total + i * columns * bands, 0, (size_t)(width * bands) * sizeof *own_total);
                    memset(own_count + i * columns, 0, (size_t)width * sizeof *own_count);
                }
            for (long i = 0; i < number; i++)
                add_tile(images + i, kind, bands, row, row + tile_rows, column, column + width, columns, tile_total,
                         tile_count);
            if (kind == PIXEL_F32) gaps |= has_gaps(own_total, tile_rows, columns * bands, width * bands);
            if (is_mean)
                for (long i = 0; i < tile_rows; i++) {
                    float *mean = own_total + i * columns * bands;
                    divide(mean, own_count + i * columns, width, bands, mean);
                }
        }
    }
    return gaps;
}

#define ADD(kind, bands, is_mean)                                                                                      \
    add_rows(images, number, kind, bands, first_row, end_row, columns, is_mean, total, count, covers)
#define ADD_BANDS(kind, is_mean)                                                                                       \
    (bands == 4 ? ADD(kind, 4, is_mean) : bands == 1 ? ADD(kind, 1, is_mean) : ADD(kind, bands, is_mean))
#define ADD_KINDS(is_mean)                                                                                             \
    (kind == PIXEL_U8    ? ADD_BANDS(PIXEL_U8, is_mean)                                                                \
     : kind == PIXEL_U16 ? ADD_BANDS(PIXEL_U16, is_mean)                                                               \
                         : ADD_BANDS(PIXEL_F32, is_mean))

/* Adds images to some rows of a raster, and returns whether any of the sums is no finite number then.

   images, number: the images, each at least 2 x 2 and of at most 2^31 - 1 values, row by row
   kind, bands: type of their pixels, and values of each
   first_row, end_row, columns: rows to be added to, and columns of the raster
   total, count: sums and numbers of images, which begin with the first row
   covers: becomes 1 for each image that covers anything of the rows, else 0 */
int aos_add_warped(const warped_image *images, long number, int kind, int bands, long first_row, long end_row,
                  long columns, float *total, uint16_t *count, uint8_t *covers) {
    return ADD_KINDS(0);
}

/* The same for rows that hold nothing yet, with any content: total becomes the mean of the images, NaN where nothing
   covers. */
int aos_mean_of_warped(const warped_image *images, long number, int kind, int bands, long first_row, long end_row,
                       long columns, float *total, uint16_t *count, uint8_t *covers) {
    return ADD_KINDS(1);
}

/* Divides the sums of cells by their numbers of images, NaN where that is 0; both may be the same memory. */
void aos_divide(const float *total, const uint16_t *count, long cells, int bands, float *mean) {
    bands == 4 ? divide(total, count, cells, 4, mean) : divide(total, count, cells, bands, mean);
}

/* Writes the first column inside all half-planes, and the one behind the last, of each row; an empty span has
   last <= first.

   half_planes, number: a cell (column, row) lies inside where a column + b row + d >= 0, for all a, b, d */
void aos_covered_spans(const double *half_planes, long number, long rows, long columns, int32_t *spans) {
    for (long row = 0; row < rows; row++) {
        double lower = 0.0, upper = (double)columns - 1.0;
        int is_outside = 0;
        for (long i = 0; i < number; i++) {
            const double slope = half_planes[3 * i], level = half_planes[3 * i + 1] * (double)row + half_planes[3 * i + 2];
            const double crossing = -level / slope;
            if (slope > 0.0) lower = crossing > lower ? crossing : lower;
            else if (slope < 0.0) upper = crossing < upper ? crossing : upper;
            else is_outside |= level < 0.0;
        }
        const double first = is_outside ? (double)columns : ceil(SMALLER(lower, (double)columns));
        const double end = floor(upper > -1.0 ? upper : -1.0) + 1.0;
        spans[2 * row] = (int32_t)first;
        spans[2 * row + 1] = (int32_t)(end > first ? end : first);
    }
}

/* Adds 1 to the cells of all spans: of each layer first columns and those behind the last, row by row. */
void aos_add_spans(const int32_t *const *spans, long number, long rows, long columns, uint16_t *count) {
    for (long row = 0; row < rows; row++, count += columns)
        for (long i = 0; i < number; i++)
            for (long x = spans[i][2 * row]; x < spans[i][2 * row + 1]; x++) count[x]++;
}
