"""Checks and draws that all kinds of errors have in common."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.errors import ConfigurationError

FloatArray = NDArray[np.float64]


def check_sizes(errors: Any, kind: str, positive: tuple[str, ...] = ()) -> None:
    """Check that no field of a dataclass of numbers, or of tuples of numbers, is negative or not finite.

    Args:
        errors: instance of a dataclass.
        kind: name of the kind of error, for messages.
        positive: fields that must not be 0 either, such as correlation times.

    Raises:
        ConfigurationError: a field is out of its range; the message names it.
    """
    for field in fields(errors):
        value = getattr(errors, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if part is None:
                continue
            least = "above 0" if field.name in positive else "0 or more"
            if not math.isfinite(part) or part < 0.0 or (part == 0.0 and field.name in positive):
                raise ConfigurationError(f"{kind}.{field.name} must be {least}, got {part}.")


def drifted(
    rng: np.random.Generator, state: FloatArray, size: ArrayLike, duration_s: float, correlation_s: float
) -> FloatArray:
    """Return a Gauss-Markov process ``duration_s`` later; exact for any duration.

    Args:
        rng: draws the part that is new.
        state: values now.
        size: standard deviations, broadcast to the state.
        duration_s: time that has passed.
        correlation_s: time after which the correlation has fallen to 1/e.
    """
    decay = math.exp(-duration_s / correlation_s)
    return np.asarray(decay * state + math.sqrt(1.0 - decay**2) * np.asarray(size) * rng.standard_normal(state.shape))
