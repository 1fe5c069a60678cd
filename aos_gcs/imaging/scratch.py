"""Memory that is used again: the system hands out new memory page by page, which takes longer than a pass over it."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

MAX_KEPT_BYTES = 16_000_000
"""Larger arrays are not kept."""

MAX_KEPT_ARRAYS = 12
"""The oldest make room for others."""

_spare: deque[NDArray[np.float32]] = deque(maxlen=MAX_KEPT_ARRAYS)
"""Arrays of shape (n,) that nobody uses; threads may take and add at the same time."""


def borrow(*shape: int) -> NDArray[np.float32]:
    """Return an array with any content."""
    size = math.prod(shape)
    for _ in range(len(_spare)):
        try:
            memory = _spare.pop()
        except IndexError:
            break
        if memory.size == size:
            return memory.reshape(shape)
        # The first to make room for others: perhaps of frames that do not come any more.
        _spare.appendleft(memory)
    return np.empty(shape, dtype=np.float32)


def give_back(memory: NDArray[np.float32]) -> None:
    """Keep a contiguous array for others: the caller must not use it, or a part of it, any more."""
    if memory.nbytes <= MAX_KEPT_BYTES:
        _spare.append(memory.reshape(-1))
