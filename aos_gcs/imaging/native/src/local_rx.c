/* Mahalanobis distance of each pixel to its surroundings: an outer window without an inner one. */

#include "kernels.h"

#include <math.h>
#include <stdlib.h>

#define MOST_BANDS 8
#define LANES 8

typedef double v4d __attribute__((vector_size(32)));

/* Sums of the columns of both windows of one quantity, as rows come in and leave.

   They stand between zeros, so that windows which reach beyond the image need no case of their own. */
typedef struct {
    double *outer, *inner;
} window_columns;

/* Rows of a plane that come into a window and leave it; zeros beyond the image. */
typedef struct {
    const float *in, *out;
} moved_rows;

INLINE moved_rows rows_moved(const float *plane, long row, long half, long height, long width, const float *zeros) {
    const long in = row + half, out = row - half - 1;
    return (moved_rows){in < 0 || in >= height ? zeros : plane + in * width,
                        out < 0 || out >= height ? zeros : plane + out * width};
}

/* Moves the sums of the columns on by one row: of a band, or of the product of two where there is another. */
INLINE void move_on(moved_rows one, moved_rows other, const int is_product, long width, double *restrict columns) {
    if (is_product)
        for (long x = 0; x < width; x++)
            columns[x] += (double)(one.in[x] * other.in[x]) - (double)(one.out[x] * other.out[x]);
    else
        for (long x = 0; x < width; x++) columns[x] += (double)one.in[x] - (double)one.out[x];
}

/* Writes the sums of the outer windows around the pixels of a row, less those of the inner ones. The places behind the
   width up to the next multiple of LANES are written, too. */
INLINE void sum_windows(window_columns columns, long width, long outer_half, long inner_half, float *restrict sums) {
    /* The window before the first pixel's: from there on columns come in and leave. */
    double before = 0.0;
    for (long x = 0; x < outer_half; x++) before += columns.outer[x];
    for (long x = 0; x < inner_half; x++) before -= columns.inner[x];
    const double *outer_in = columns.outer + outer_half, *outer_out = columns.outer - outer_half - 1;
    const double *inner_in = columns.inner + inner_half, *inner_out = columns.inner - inner_half - 1;
    const v4d none = {0};
    v4d carried = {before, before, before, before};
    for (long x = 0; x < width; x += 4) {
        v4d a, b, c, d;
        memcpy(&a, outer_in + x, sizeof a);
        memcpy(&b, outer_out + x, sizeof b);
        memcpy(&c, inner_in + x, sizeof c);
        memcpy(&d, inner_out + x, sizeof d);
        v4d change = (a - b) - (c - d);
        /* Sums of changes: of two neighbours, then of pairs. */
        change += __builtin_shufflevector(change, none, 4, 0, 1, 2);
        change += __builtin_shufflevector(change, none, 4, 5, 0, 1);
        const v4 own = __builtin_convertvector(carried + change, v4);
        memcpy(sums + x, &own, sizeof own);
        carried += __builtin_shufflevector(change, change, 3, 3, 3, 3);
    }
}

INLINE v8 larger(v8 one, float other) {
    for (int k = 0; k < LANES; k++) one[k] = one[k] > other ? one[k] : other;
    return one;
}

/* Writes the scores of a row by the sums over the surroundings, with the factors L D L' of the covariance.

   rows: the row's own pixels, band by band, LANES more than the width are read
   sums: as the bands and their products come, `step` apart */
INLINE void score_row(const float *rows, long step, const int bands, const float *sums, const float *counts, long width,
                      float loading, float *scores) {
    for (long first = 0; first < width; first += LANES) {
        const v8 count = larger(load8(counts + first), 2.0f), per_count = 1.0f / count, per_degree = 1.0f / (count - 1.0f);
        v8 mean[MOST_BANDS], solution[MOST_BANDS], per_pivot[MOST_BANDS], score = {0};
        /* L, and L D. */
        v8 factor[MOST_BANDS][MOST_BANDS], scaled[MOST_BANDS][MOST_BANDS];
        const float *sum = sums + first;
        for (int i = 0; i < bands; i++, sum += step) {
            mean[i] = load8(sum) * per_count;
            v8 residual = load8(rows + i * step + first) - mean[i];
            for (int j = 0; j <= i; j++) {
                sum += step;
                v8 entry = (load8(sum) - count * mean[i] * mean[j]) * per_degree;
                for (int m = 0; m < j; m++) entry -= scaled[i][m] * factor[j][m];
                if (j == i) {
                    per_pivot[i] = 1.0f / (larger(entry, 0.0f) + loading);
                } else {
                    scaled[i][j] = entry;
                    factor[i][j] = entry * per_pivot[j];
                    residual -= factor[i][j] * solution[j];
                }
            }
            solution[i] = residual;
            score += residual * residual * per_pivot[i];
        }
        memcpy(scores + first, &score, sizeof score);
    }
}

/* Returns how many rows or columns of an image a window around one of them holds. */
INLINE long held(long place, long half, long number) {
    const long first = place - half, last = place + half;
    return (last < number ? last : number - 1) - (first > 0 ? first : 0) + 1;
}

/* Writes the numbers of pixels in the surroundings of a row's pixels where all are known. */
INLINE void count_all(long row, long height, long width, long outer_half, long inner_half, float *counts) {
    const long outer_rows = held(row, outer_half, height), inner_rows = held(row, inner_half, height);
    for (long x = 0; x < width; x++)
        counts[x] = (float)(outer_rows * held(x, outer_half, width) - inner_rows * held(x, inner_half, width));
}

INLINE int local_scores(const float *planes, const float *known, long height, long width, const int bands, long guard,
                        long background, float loading, long least, float *scores) {
    /* Bands, their products, and known pixels. */
    const int all = bands + bands * (bands + 1) / 2 + 1;
    const long outer_half = background / 2, inner_half = guard / 2;
    const long step = (width + LANES - 1) / LANES * LANES, margin = outer_half + LANES, columns_step = step + 2 * margin;
    double *columns = calloc((size_t)(2 * all * columns_step), sizeof *columns);
    float *sums = calloc((size_t)((all + bands + 2) * step), sizeof *sums);
    if (!columns || !sums) {
        free(columns);
        free(sums);
        return 1;
    }
    float *counts = sums + (all - 1) * step, *own = sums + all * step, *own_scores = own + bands * step;
    const float *zeros = own_scores + step;
    for (long row = -outer_half; row < height; row++) {
        moved_rows outer[MOST_BANDS + 1], inner[MOST_BANDS + 1];
        for (int i = 0; i <= bands; i++) {
            const float *plane = i < bands ? planes + i * height * width : known;
            if (!plane) continue;
            outer[i] = rows_moved(plane, row, outer_half, height, width, zeros);
            inner[i] = rows_moved(plane, row, inner_half, height, width, zeros);
        }
        double *next = columns + margin;
        float *next_sums = sums;
        for (int i = 0; i <= bands; i++)
            for (int j = -1; j <= (i < bands ? i : -1); j++, next += 2 * columns_step, next_sums += step) {
                if (i == bands && !known) continue;
                const window_columns own_columns = {next, next + columns_step};
                const int other = j < 0 ? 0 : j;
                move_on(outer[i], outer[other], j >= 0, width, own_columns.outer);
                if (row >= -inner_half) move_on(inner[i], inner[other], j >= 0, width, own_columns.inner);
                if (row >= 0) sum_windows(own_columns, width, outer_half, inner_half, next_sums);
            }
        if (row < 0) continue;
        if (!known) count_all(row, height, width, outer_half, inner_half, counts);
        for (int i = 0; i < bands; i++)
            memcpy(own + i * step, planes + (i * height + row) * width, (size_t)width * sizeof *own);
        score_row(own, step, bands, sums, counts, width, loading, own_scores);
        for (long x = 0; x < width; x++) {
            const int enough = counts[x] >= (float)least && (!known || known[row * width + x] > 0.0f);
            scores[row * width + x] = enough ? own_scores[x] : NAN;
        }
    }
    free(columns);
    free(sums);
    return 0;
}

#define SCORES(bands)                                                                                                  \
    local_scores(planes, known, height, width, bands, guard, background, loading, least, scores)

/* Writes the scores of all pixels; returns 1 where memory is short, else 0.

   planes: bands of the image, one after the other, 0 where it is not known; at most MOST_BANDS
   known: 1 where the image is known, else 0; NULL: known everywhere
   guard, background: edges of the inner and the outer window, odd
   loading: added to the variances
   least: known pixels that surroundings need; with fewer the score is NaN, as where the pixel is not known */
int aos_local_scores(const float *planes, const float *known, long height, long width, int bands, long guard,
                     long background, float loading, long least, float *scores) {
    return bands == 4 ? SCORES(4) : bands == 1 ? SCORES(1) : SCORES(bands);
}
