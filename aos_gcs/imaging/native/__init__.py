"""Compiled kernels of imaging, which replace passes of NumPy and OpenCV where they have been built."""
