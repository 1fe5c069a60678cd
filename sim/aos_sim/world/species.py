"""Kinds of trees.

Leaves, clumps and jitter of the broad-leaved ones are chosen so that at 300 trees/ha a nadir view from 35-44 m height
and at most 12 m beside a standing person shows 15-20 % of it: measured 0.178 +- 0.008 over 200 forests of 60 m with 40
views each (``aos-gcs lab calibrate --worlds 200``). Forests differ: half of them lie within 0.11 and 0.22.
Conifers are as tall, but slender: from above they hide less (docs/laboratory.md has the figures).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class CrownShape(StrEnum):
    """The body that the foliage fills."""

    ELLIPSOID = "ellipsoid"
    CONE = "cone"


@dataclass(frozen=True, slots=True)
class Species:
    """Properties of the trees of one kind."""

    height_range_m: tuple[float, float]
    crown_radius_range_m: tuple[float, float]
    crown_base_fraction: float
    """Height of the crown's lower edge, as a fraction of the tree's height."""
    crown_shape: CrownShape
    leaves: int
    """Per tree. A leaf is one pointed triangle of the area of a square: a spray of small leaves or needles rather than
    a single one, which hides as much with half the triangles."""
    leaf_half_size_range_m: tuple[float, float]
    """Half the side of that square."""
    clumps: int
    """Twigs per tree, round which the leaves gather."""
    clump_sigma_m: float
    colours_rgb: tuple[tuple[int, int, int], ...]
    """Colours of the leaves, by tree."""


BROADLEAF = Species(
    height_range_m=(12.0, 18.0),
    crown_radius_range_m=(3.2, 4.6),
    crown_base_fraction=0.35,
    crown_shape=CrownShape.ELLIPSOID,
    leaves=2400,
    leaf_half_size_range_m=(0.07, 0.16),
    clumps=80,
    clump_sigma_m=0.55,
    colours_rgb=((74, 104, 44), (88, 118, 50), (64, 96, 46), (98, 116, 58), (80, 98, 40)),
)

CONIFER = Species(
    height_range_m=(13.0, 18.0),
    crown_radius_range_m=(2.2, 3.2),
    crown_base_fraction=0.12,
    crown_shape=CrownShape.CONE,
    leaves=2600,
    leaf_half_size_range_m=(0.07, 0.15),
    clumps=90,
    clump_sigma_m=0.35,
    colours_rgb=((46, 78, 44), (54, 86, 48), (42, 70, 46), (60, 84, 52)),
)
