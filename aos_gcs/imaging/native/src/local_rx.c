/* Mahalanobis distance of each pixel to its surroundings: an outer window without an inner one. */

#include "kernels.h"

#include <math.h>
#include <stdlib.h>

#define MOST_BANDS 8

/* Returns a row of a band, or zeros beyond the image. */
INLINE const float *row_of(const float *plane, long row, long height, long width, const float *zeros) {
    return row < 0 || row >= height ? zeros : plane + row * width;
}

/* Moves the windows of the columns on by one row: one comes in, another leaves. */
INLINE void move_on(const float *planes, long in, long out, long height, long width, const int bands, double *columns,
                    const float *zeros) {
    for (int i = 0; i < bands; i++) {
        const float *one_in = row_of(planes + i * height * width, in, height, width, zeros);
        const float *one_out = row_of(planes + i * height * width, out, height, width, zeros);
        for (long x = 0; x < width; x++) columns[x] += (double)one_in[x] - (double)one_out[x];
        columns += width;
        for (int j = 0; j <= i; j++) {
            const float *other_in = row_of(planes + j * height * width, in, height, width, zeros);
            const float *other_out = row_of(planes + j * height * width, out, height, width, zeros);
            for (long x = 0; x < width; x++)
                columns[x] += (double)(one_in[x] * other_in[x]) - (double)(one_out[x] * other_out[x]);
            columns += width;
        }
    }
}

/* Sums of columns before each, of two quantities in both windows: four chains of sums hide each other's latency. */
INLINE void sum_before(const double *outer, const double *inner, long width, double *before) {
    double *outer_one = before, *outer_other = before + (width + 1);
    double *inner_one = before + 2 * (width + 1), *inner_other = before + 3 * (width + 1);
    double sums[4] = {0.0, 0.0, 0.0, 0.0};
    outer_one[0] = outer_other[0] = inner_one[0] = inner_other[0] = 0.0;
    for (long x = 0; x < width; x++) {
        outer_one[x + 1] = sums[0] += outer[x];
        outer_other[x + 1] = sums[1] += outer[width + x];
        inner_one[x + 1] = sums[2] += inner[x];
        inner_other[x + 1] = sums[3] += inner[width + x];
    }
}

/* Moves the counts of known pixels of the columns on by one row. */
INLINE void count_on(const float *known, long in, long out, long height, long width, double *columns,
                     const float *zeros) {
    if (known) {
        const float *known_in = row_of(known, in, height, width, zeros);
        const float *known_out = row_of(known, out, height, width, zeros);
        for (long x = 0; x < width; x++) columns[x] += (double)known_in[x] - (double)known_out[x];
        return;
    }
    const double step = (double)(in >= 0 && in < height) - (double)(out >= 0 && out < height);
    for (long x = 0; x < width; x++) columns[x] += step;
}

INLINE long within(long x, long width) { return x < 0 ? 0 : x > width ? width : x; }

/* Writes the sums of the outer windows around the pixels of a row, less those of the inner ones. */
INLINE void differences(const double *outer, const double *inner, long width, long outer_half, long inner_half,
                        float *sums) {
    /* In the middle neither window is cut off by the border. */
    const long middle = SMALLER(outer_half, width), middle_end = width - outer_half > middle ? width - outer_half : middle;
    for (long x = 0; x < middle; x++)
        sums[x] = (float)((outer[within(x + outer_half + 1, width)] - outer[within(x - outer_half, width)]) -
                          (inner[within(x + inner_half + 1, width)] - inner[within(x - inner_half, width)]));
    for (long x = middle; x < middle_end; x++)
        sums[x] = (float)((outer[x + outer_half + 1] - outer[x - outer_half]) -
                          (inner[x + inner_half + 1] - inner[x - inner_half]));
    for (long x = middle_end; x < width; x++)
        sums[x] = (float)((outer[within(x + outer_half + 1, width)] - outer[within(x - outer_half, width)]) -
                          (inner[within(x + inner_half + 1, width)] - inner[within(x - inner_half, width)]));
}

/* Writes the scores of a row by the sums over the surroundings, with Cholesky's factor of the covariance. */
INLINE void score_row(const float *planes, long row, long height, long width, const int bands, const float *sums,
                      const float *counts, float loading, float *scores) {
    enum { LANES = 16 };
    for (long first = 0; first < width; first += LANES) {
        const long n = SMALLER(width - first, (long)LANES);
        float factor[MOST_BANDS][MOST_BANDS][LANES], solution[MOST_BANDS][LANES], mean[MOST_BANDS][LANES];
        float count[LANES], score[LANES] = {0};
        for (int k = 0; k < LANES; k++) count[k] = k < n && counts[first + k] > 2.0f ? counts[first + k] : 2.0f;
        int sum = 0;
        for (int i = 0; i < bands; i++) {
            float residual[LANES], entry[LANES], own[LANES] = {0};
            memcpy(own, sums + sum++ * width + first, (size_t)n * sizeof *own);
            for (int k = 0; k < LANES; k++) mean[i][k] = own[k] / count[k];
            memcpy(own, planes + (i * height + row) * width + first, (size_t)n * sizeof *own);
            for (int k = 0; k < LANES; k++) residual[k] = own[k] - mean[i][k];
            for (int j = 0; j <= i; j++) {
                memcpy(own, sums + sum++ * width + first, (size_t)n * sizeof *own);
                for (int k = 0; k < LANES; k++)
                    entry[k] = (own[k] - count[k] * mean[i][k] * mean[j][k]) / (count[k] - 1.0f);
                for (int m = 0; m < j; m++)
                    for (int k = 0; k < LANES; k++) entry[k] -= factor[i][m][k] * factor[j][m][k];
                if (j < i)
                    for (int k = 0; k < LANES; k++) {
                        factor[i][j][k] = entry[k] / factor[j][j][k];
                        residual[k] -= factor[i][j][k] * solution[j][k];
                    }
                else
                    for (int k = 0; k < LANES; k++)
                        factor[i][i][k] = sqrtf((entry[k] > 0.0f ? entry[k] : 0.0f) + loading);
            }
            for (int k = 0; k < LANES; k++) {
                solution[i][k] = residual[k] / factor[i][i][k];
                score[k] += solution[i][k] * solution[i][k];
            }
        }
        memcpy(scores + row * width + first, score, (size_t)n * sizeof *score);
    }
}

INLINE int local_scores(const float *planes, const float *known, long height, long width, const int bands, long guard,
                        long background, float loading, long least, float *scores) {
    /* Bands, their products, and the number of known pixels; one more where these are odd. */
    const int all = bands + bands * (bands + 1) / 2, held = (all + 2) & ~1;
    const long outer_half = background / 2, inner_half = guard / 2;
    double *memory = calloc((size_t)(2 * held * width + 4 * (width + 1)), sizeof *memory);
    float *sums = calloc((size_t)((held + 1) * width), sizeof *sums);
    if (!memory || !sums) {
        free(memory);
        free(sums);
        return 1;
    }
    double *outer = memory, *inner = outer + held * width, *before = inner + held * width;
    const float *zeros = sums + held * width, *counts = sums + all * width;
    for (long row = -outer_half; row < height; row++) {
        move_on(planes, row + outer_half, row - outer_half - 1, height, width, bands, outer, zeros);
        count_on(known, row + outer_half, row - outer_half - 1, height, width, outer + all * width, zeros);
        if (row < -inner_half) continue;
        move_on(planes, row + inner_half, row - inner_half - 1, height, width, bands, inner, zeros);
        count_on(known, row + inner_half, row - inner_half - 1, height, width, inner + all * width, zeros);
        if (row < 0) continue;
        for (int sum = 0; sum < held; sum += 2) {
            sum_before(outer + sum * width, inner + sum * width, width, before);
            for (int own = 0; own < 2; own++)
                differences(before + own * (width + 1), before + (own + 2) * (width + 1), width, outer_half, inner_half,
                            sums + (sum + own) * width);
        }
        score_row(planes, row, height, width, bands, sums, counts, loading, scores);
        float *own = scores + row * width;
        for (long x = 0; x < width; x++) {
            const int enough = counts[x] >= (float)least && (!known || known[row * width + x] > 0.0f);
            own[x] = enough ? own[x] : NAN;
        }
    }
    free(memory);
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
