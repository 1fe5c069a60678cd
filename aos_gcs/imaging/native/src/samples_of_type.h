/* Samples of images with one type of pixels: PIXEL is the type, LOAD8 reads eight of them as floats, and NAME makes the
   names. Included by samples.h once for each type. */

/* Adds bilinear samples at n pixels (offsets of their upper left neighbours, and shares of the others) to sums. */
INLINE void NAME(add_samples)(const void *pixels, long row_step, const int bands, const int32_t *offset,
                              const float *share_u, const float *share_v, long n, float *total) {
    const PIXEL *image = pixels;
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
