"""Numerical libraries on one thread: a study is parallel by its processes."""

from __future__ import annotations

import os


def use_one_thread() -> None:
    """Keep BLAS and OpenCV from threads of their own in this process and those that it starts, unless told otherwise.

    Their threads wait for one another with a loop that takes a processor each. Call it before NumPy is imported.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")
