"""Random generators from their saved states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


def load_rng(data: Mapping[str, Any]) -> np.random.Generator:
    """Return a generator that continues where the one stood that ``dump_rng`` has saved."""
    bit_generator = np.random.PCG64(0)
    bit_generator.state = dict(data)
    return np.random.Generator(bit_generator)
