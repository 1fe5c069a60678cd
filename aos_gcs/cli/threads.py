"""Threads of numerical libraries, which read their number when NumPy is imported first."""

from __future__ import annotations

import os


def use_one_blas_thread() -> None:
    """Keep BLAS from threads of its own in this process and those that it starts, unless told otherwise.

    Matrices of a mission are small, and these threads wait for one another with a loop that takes a core each: beside
    processes that compute, a step of the strategy took many times as long.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def use_one_opencv_thread() -> None:
    """Keep OpenCV from threads of its own in the same way: a study is parallel by its processes."""
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")
