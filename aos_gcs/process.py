"""What this process does differently from any other Python program: threads of libraries, and garbage collection."""

from __future__ import annotations

import gc
import os


def use_one_blas_thread() -> None:
    """Keep BLAS from threads of its own in this process and those that it starts, unless told otherwise.

    Call it before NumPy is imported, as it is then that BLAS reads their number. Matrices of a mission are small, and
    these threads wait for one another with a loop that takes a core each: beside processes that compute, a step of the
    strategy took many times as long.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def use_one_opencv_thread() -> None:
    """Keep OpenCV from threads of its own in the same way: a study is parallel by its processes."""
    os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")


def settle_garbage() -> None:
    """Leave everything that exists now out of later collections, after a last one.

    Call it before links are opened, in each sortie. A collection looks through all objects that were made before, of
    which modules have more than 100,000, and no other thread runs meanwhile: links and commands would be held up.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
