"""Marks of the detector on a person in the frames of a flight, by what they show of the person.

The numbers are fitted to rendered frames; docs/searches.md says to which, and how well whole flights agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.groundmap.detection import Posture

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Marks:
    """Habits of the detector with persons of a posture."""

    mean_share: float
    """Share of the frames showing much of a person in which it marks something of them; persons differ."""
    concentration: float
    """Sum of the parameters of the beta distribution of that share: the greater, the more alike are persons."""
    marked_share: float
    """Share of what a frame shows of a person that it marks, where it marks them; one pixel at least."""


_OF_POSTURE: Final = {
    Posture.STANDING: _Marks(mean_share=0.48, concentration=6.0, marked_share=0.65),
    Posture.SITTING: _Marks(mean_share=0.50, concentration=15.0, marked_share=0.55),
    Posture.LYING: _Marks(mean_share=0.66, concentration=15.0, marked_share=0.55),
}
_SCALE_PIXELS: Final = 2.5
"""Pixels of a person in a frame at which the share of frames is reached by 63 %."""
_DISPLACEMENT_M: Final = 0.2
"""Standard deviation of where the marks of one frame lie, on either axis: poses err."""


def persons_share(seed: int, posture: Posture) -> float:
    """Return the share of the frames showing much of the person of a seed in which the detector marks something."""
    rng, own = np.random.default_rng([seed, 48]), _OF_POSTURE[posture]
    return float(rng.beta(own.mean_share * own.concentration, (1.0 - own.mean_share) * own.concentration))


def marks(
    seen: NDArray[np.bool_],
    pixels_m2: FloatArray,
    resolution_m: float,
    *,
    posture: Posture,
    share: float,
    rng: np.random.Generator,
) -> NDArray[np.bool_]:
    """Return what the detector marks in each frame, as cells of the raster, shape (n, rows, columns).

    Args:
        seen: what each frame shows of the person, the same shape.
        pixels_m2: area of the ground that a pixel of each frame covers, shape (n,).
        resolution_m: edge of a cell.
        posture: the person's.
        share: share of the frames showing much of the person in which it marks something, 0 to 1.
        rng: draws which frames and which cells.
    """
    cells = seen.sum(axis=(1, 2))
    pixel_cells = pixels_m2 / resolution_m**2
    pixels = cells / pixel_cells
    is_marked = rng.random(len(seen)) < share * -np.expm1(-pixels / _SCALE_PIXELS)
    marked = np.zeros_like(seen)
    for row in np.flatnonzero(is_marked):
        kept = max(_OF_POSTURE[posture].marked_share, min(1.0, pixel_cells[row] / cells[row]))
        offset = np.rint(rng.normal(0.0, _DISPLACEMENT_M / resolution_m, 2)).astype(int)
        marked[row] = np.roll(seen[row] & (rng.random(seen[row].shape) < kept), offset, axis=(0, 1))
    return marked
