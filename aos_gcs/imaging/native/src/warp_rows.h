/* A row of a warped image, for one type of pixels: PIXEL is the type, LOAD8 reads eight of them as floats, and NAME makes
   the names. Included by warp.c once for each type. */

/* Adds bilinear samples at n pixels (offsets of their upper left neighbours, and shares of the others) to sums. */
INLINE void NAME(add_samples)(const PIXEL *image, long row_step, const int bands, const int32_t *offset,
                              const float *share_u, const float *share_v, long n, float *total) {
    if (bands == 4) {
        for (long k = 0; k < n; k++) {
            const PIXEL *p = image + offset[k];
            const v8 upper = LOAD8(p), lower = LOAD8(p + row_step);
            const v8 both = upper + (lower - upper) * share_v[k];
            const v4 left = __builtin_shufflevector(both, both, 0, 1, 2, 3);
            const v4 right = __builtin_shufflevector(both, both, 4, 5, 6, 7);
            v4 sum;
            memcpy(&sum, total + 4 * k, sizeof sum);
            sum += left + (right - left) * share_u[k];
            memcpy(total + 4 * k, &sum, sizeof sum);
        }
        return;
    }
    for (long k = 0; k < n; k++) {
        const PIXEL *p = image + offset[k];
        for (int band = 0; band < bands; band++) {
            float upper_left = p[band], upper_right = p[band + bands];
            float lower_left = p[row_step + band], lower_right = p[row_step + band + bands];
            float left = upper_left + (lower_left - upper_left) * share_v[k];
            float right = upper_right + (lower_right - upper_right) * share_v[k];
            total[bands * k + band] += left + (right - left) * share_u[k];
        }
    }
}

INLINE void NAME(add_row)(const warped_image *own, const int bands, long row, long first, long end, float *total) {
    const float u_max = (float)(own->width - 1), v_max = (float)(own->height - 1);
    const int32_t column_max = (int32_t)(own->width - 2), row_max = (int32_t)(own->height - 2);
    const int32_t row_step = (int32_t)(own->width * bands);
    const double *H = own->H;
    const float du = (float)H[0], dv = (float)H[3], dw = (float)H[6];
    int32_t offset[BLOCK];
    float share_u[BLOCK], share_v[BLOCK];
    for (long start = first; start < end; start += BLOCK) {
        /* Double precision at the start of a block, single precision within it. */
        const float u0 = (float)(H[0] * start + H[1] * row + H[2]);
        const float v0 = (float)(H[3] * start + H[4] * row + H[5]);
        const float w0 = (float)(H[6] * start + H[7] * row + H[8]);
        for (int k = 0; k < BLOCK; k++) {
            float step = (float)k, per_depth = 1.0f / (w0 + dw * step);
            float u = (u0 + du * step) * per_depth, v = (v0 + dv * step) * per_depth;
            /* Clamped at the border; beyond the span, where nothing is read, also what is no number. */
            u = u > 0.0f ? u : 0.0f;
            v = v > 0.0f ? v : 0.0f;
            u = u < u_max ? u : u_max;
            v = v < v_max ? v : v_max;
            int32_t column = (int32_t)u, own_row = (int32_t)v;
            column = SMALLER(column, column_max);
            own_row = SMALLER(own_row, row_max);
            share_u[k] = u - (float)column;
            share_v[k] = v - (float)own_row;
            offset[k] = own_row * row_step + column * bands;
        }
        NAME(add_samples)((const PIXEL *)own->pixels, row_step, bands, offset, share_u, share_v,
                          SMALLER(end - start, BLOCK), total + start * bands);
    }
}
