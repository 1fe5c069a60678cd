/* What tells the loader which library fits. */

/* Returns whether this processor can run the library that is compiled for AVX2. */
int aos_has_avx2(void) {
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") != 0;
#else
    return 0;
#endif
}

/* Returns the checksum of the sources that this library is compiled from. */
unsigned aos_sources(void) { return AOS_SOURCES; }
