"""Randomisation of a particle's attraction: per dimension, by one scalar, or in a sphere.

Source: AOS-APSO paper, section Rotation-Invariant PSO (``eq:pso-sphere``). Drawing and applying are two
functions: the same draws can be applied in another frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray


class Randomness(StrEnum):
    """Kind of the random factor R of a term."""

    VECTOR = "vector"
    """One number per dimension: a box along the axes, so the search prefers them."""
    SCALAR = "scalar"
    """One number per particle: invariant to rotation, on a line only."""
    SPHERICAL = "spherical"
    """A point in a ball about the attractor: invariant to rotation, in all dimensions."""


@dataclass(frozen=True, slots=True, eq=False)
class Draw:
    """The random numbers of one term for all particles."""

    R: NDArray[np.float64]
    """Uniform in [0, 1), shape (n, dim) for ``VECTOR`` and (n, 1) otherwise."""
    units: NDArray[np.float64] | None = None
    """U/|U|, uniformly distributed directions, shape (n, dim); for ``SPHERICAL`` only."""


def draw(randomness: Randomness, n: int, dim: int, rng: np.random.Generator) -> Draw:
    """Return the random numbers of one term for n particles."""
    match randomness:
        case Randomness.VECTOR:
            return Draw(rng.uniform(size=(n, dim)))
        case Randomness.SCALAR:
            return Draw(rng.uniform(size=(n, 1)))
        case Randomness.SPHERICAL:
            U = rng.normal(size=(n, dim))
            return Draw(rng.uniform(size=(n, 1)), U / np.linalg.norm(U, axis=1, keepdims=True))


def attraction(offsets: NDArray[np.float64], drawn: Draw, exponent: int) -> NDArray[np.float64]:
    """Return the randomised pull towards an attractor, without its factor c, shape (n, dim).

    Args:
        offsets: attractor minus position, shape (n, dim).
        drawn: the random numbers; with directions the pull is spherical (``eq:pso-sphere``).
        exponent: m of the spherical pull; larger ones gather the points about the attractor.
    """
    if drawn.units is None:
        return drawn.R * offsets
    distances = np.linalg.norm(offsets, axis=1, keepdims=True)
    pull: NDArray[np.float64] = drawn.R**exponent * distances * drawn.units + offsets
    return pull
