"""Memory that is used again: the system hands out new memory page by page, which takes longer than a pass over it."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

MAX_KEPT_BYTES = 16_000_000
"""Larger arrays are not kept."""

_spare: deque[NDArray[np.float32]] = deque(maxlen=12)
"""Arrays of shape (n,) that nobody uses; threads may take and add at the same time."""


def borrow(*shape: int) -> NDArray[np.float32]:
    """Return an array with any content."""
    size = math.prod(shape)
    while True:
        try:
            memory = _spare.pop()
        except IndexError:
            return np.empty(shape, dtype=np.float32)
        # Arrays of other sizes are of frames that do not come any more.
        if memory.size == size:
            return memory.reshape(shape)


def give_back(memory: NDArray[np.float32]) -> None:
    """Keep a contiguous array for others: the caller must not use it, or a part of it, any more."""
    if memory.nbytes <= MAX_KEPT_BYTES:
        _spare.append(memory.reshape(-1))
