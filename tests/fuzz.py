"""Number of examples that the fuzz tests take: a few hundred with all other tests, many more in the slow ones."""

from __future__ import annotations

import os
from typing import Final

import numpy as np

SEED: Final = int(os.environ.get("AOS_GCS_FUZZ_SEED", "0"))
"""First seed; every example has its own, which a failure names."""


def damage(content: bytes, rng: np.random.Generator) -> bytes:
    """Return bytes that a disk, a network or an attacker has changed: flipped, cut off, repeated or replaced."""
    data = bytearray(content)
    match rng.integers(0, 5):
        case 0:
            for place in rng.integers(0, max(1, len(data)), rng.integers(1, 8)):
                data[place : place + 1] = bytes([rng.integers(0, 256)])
        case 1:
            del data[rng.integers(0, len(data) + 1) :]
        case 2:
            place, size = rng.integers(0, len(data) + 1), rng.integers(0, 64)
            data[place:place] = data[:size]
        case 3:
            place, size = rng.integers(0, len(data) + 1), rng.integers(0, 64)
            data[place : place + size] = rng.bytes(size)
        case _:
            data = bytearray(rng.bytes(rng.integers(0, 200)))
    return bytes(data)
