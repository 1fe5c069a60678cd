/* Images on rasters whose cells have one point each, as those of terrain have, added to their sums in one pass. */

#include "samples.h"

/* Edge of the blocks of cells of which an image tells whether it may see them. */
#define BLOCK 32
/* Smallest depth of a point in front of a camera, in metres. */
#define MIN_DEPTH 1e-6f

typedef struct {
    /* x, y and z of each cell, relative to their origin. */
    const float *xyz;
    /* 1 where a cell has a point, else 0. */
    const uint8_t *known;
    int64_t columns;
} cell_points;

typedef struct {
    const void *pixels;
    /* 1 where the image may see a block of cells, else 0. */
    const uint8_t *seen_blocks;
    /* Projection of points (x, y, z, 1) to homogeneous pixels of the ideal camera, row by row. */
    double P[12];
    int64_t height, width;
    lens_map lens;
} pointed_image;

INLINE void project(const pointed_image *image, cell_points points, long first, long n, cell_pixels *cells) {
    float P[12];
    for (int i = 0; i < 12; i++) P[i] = (float)image->P[i];
    const float *xyz = points.xyz + 3 * first;
    const uint8_t *known = points.known + first;
    for (long k = 0; k < n; k++) {
        const float x = xyz[3 * k], y = xyz[3 * k + 1], z = xyz[3 * k + 2];
        const float depth = P[8] * x + P[9] * y + P[10] * z + P[11], per_depth = 1.0f / depth;
        cells->u[k] = (P[0] * x + P[1] * y + P[2] * z + P[3]) * per_depth;
        cells->v[k] = (P[4] * x + P[5] * y + P[6] * z + P[7]) * per_depth;
        cells->is_seen[k] = known[k] & (depth > MIN_DEPTH);
    }
}

/* Adds an image to a part of a row, and returns whether it covers any of it.

   first: number of the first cell
   total, count: sums and number of images of that cell */
INLINE int add_cells(const pointed_image *image, const int kind, const int bands, cell_points points, long first, long n,
                     float *total, uint16_t *count) {
    cell_pixels cells;
    project(image, points, first, n, &cells);
    if (image->lens.u) through_lens(image->lens, n, &cells);
    const image_size size = size_of(image->height, image->width, bands);
    return add_seen(image->pixels, kind, size, bands, n, &cells, total, count);
}

INLINE int add_rows(cell_points points, const pointed_image *images, long number, const int kind, const int bands,
                    long first_row, long end_row, float *total, uint16_t *count, uint8_t *covers) {
    const long columns = points.columns, blocks = (columns + BLOCK - 1) / BLOCK;
    memset(covers, 0, (size_t)number);
    for (long row = first_row; row < end_row; row++, total += columns * bands, count += columns)
        for (long block = 0; block < blocks; block++) {
            const long left = block * BLOCK, n = SMALLER(columns - left, (long)BLOCK);
            for (long i = 0; i < number; i++)
                if (images[i].seen_blocks[row / BLOCK * blocks + block])
                    covers[i] |= (uint8_t)add_cells(images + i, kind, bands, points, row * columns + left, n,
                                                    total + left * bands, count + left);
        }
    const long rows = end_row - first_row;
    return kind == PIXEL_F32 && has_gaps(total - rows * columns * bands, rows, columns * bands, columns * bands);
}

#define ADD(kind, bands) add_rows(points, images, number, kind, bands, first_row, end_row, total, count, covers)
#define ADD_BANDS(kind) (bands == 4 ? ADD(kind, 4) : bands == 1 ? ADD(kind, 1) : ADD(kind, bands))

/* Adds images to some rows of a raster, and returns whether any of the sums is no finite number then.

   xyz, known, columns: points of the whole raster, its columns
   images, number: the images, each at least 2 x 2 and of at most 2^31 - 1 values, row by row
   kind, bands: type of their pixels, and values of each
   first_row, end_row: rows to be added to
   total, count: sums and numbers of images, which begin with the first row
   covers: becomes 1 for each image that covers anything of the rows, else 0 */
int aos_add_points(const float *xyz, const uint8_t *known, long columns, const pointed_image *images, long number,
                   int kind, int bands, long first_row, long end_row, float *total, uint16_t *count, uint8_t *covers) {
    const cell_points points = {xyz, known, columns};
    return kind == PIXEL_U8 ? ADD_BANDS(PIXEL_U8) : kind == PIXEL_U16 ? ADD_BANDS(PIXEL_U16) : ADD_BANDS(PIXEL_F32);
}
