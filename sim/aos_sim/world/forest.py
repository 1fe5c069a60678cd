"""Broad-leaved trees on a jittered grid.

A leaf is one pointed triangle of the area of a square of 14-32 cm: a spray of small leaves rather than a single one,
which hides as much with half the triangles.

Leaves, clumps and jitter are chosen so that at 300 trees/ha a nadir view from 35-44 m height and at most 12 m beside a
standing person shows 15-20 % of it: measured 0.159 +- 0.014 over 60 worlds of 60 m with 40 views each
(``tests/benchmarks/bench_render.py`` repeats it on fewer). Worlds differ: half of them lie within 0.09 and 0.19.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.mesh import (
    FloatArray,
    Material,
    Mesh,
    concatenate,
    normalised,
    perpendicular_axes,
    tubes,
    uniform_mesh,
)

HEIGHT_RANGE_M = (12.0, 18.0)
CROWN_RADIUS_RANGE_M = (3.2, 4.6)
LEAVES_PER_TREE = 2600
TWIG_CLUMPS_PER_TREE = 80
CLUMP_SIGMA_M = 0.55
LEAF_HALF_SIZE_RANGE_M = (0.07, 0.16)
BRANCHES_PER_TREE = 8
GRID_JITTER = 0.2
"""Largest offset of a trunk from the middle of its cell, in cells."""
CROWN_BASE_FRACTION = 0.35
"""Height of the crown's lower edge, as a fraction of the tree's height."""

LEAF_TEMPERATURE_CELSIUS = 11.5
BARK_TEMPERATURE_CELSIUS = 12.2
TEMPERATURE_SPREAD_K = 0.8
"""Largest deviation of one leaf or face of bark. Bounded, so that no single leaf looks like a warm body."""

_LEAF_COLOURS = np.array([[74, 104, 44], [88, 118, 50], [64, 96, 46], [98, 116, 58], [80, 98, 40]], np.float32)
_BARK_COLOUR = np.array([88, 74, 60], np.float32)
_BARK_SKY_SHARE = 0.45
# Corners (across, along) of a leaf in half-sizes s: twice as long as wide, centroid 0, area (2 s)^2.
_LEAF_CORNERS = ((-1.0, -4 / 3), (1.0, -4 / 3), (0.0, 8 / 3))


@dataclass(frozen=True, slots=True, eq=False)
class Forest:
    """Trees and their mesh; one row per tree."""

    trunk_enu_m: NDArray[np.float64]
    """Foot of the trunk, shape (n, 2)."""
    height_m: NDArray[np.float64]
    crown_radius_m: NDArray[np.float64]
    mesh: Mesh


def grow_forest(rng: np.random.Generator, west_m: float, south_m: float, side_m: float, trees_per_ha: float) -> Forest:
    """Plant and build the trees of a square; crowns may reach beyond its edges, trunks do not."""
    count = round(trees_per_ha * side_m**2 / 1e4)
    trunk = np.array([west_m, south_m]) + _jittered_grid(rng, count, side_m)
    height = rng.uniform(*HEIGHT_RANGE_M, count)
    radius = rng.uniform(*CROWN_RADIUS_RANGE_M, count)
    if count == 0:
        return Forest(trunk, height, radius, concatenate([]))
    crowns = _Crowns.of_trees(trunk, height, radius)
    clumps = _clump_centres(rng, crowns)
    mesh = concatenate([_leaves(rng, crowns, clumps), _wood(rng, trunk, height, clumps)])
    return Forest(trunk, height, radius, mesh)


def _jittered_grid(rng: np.random.Generator, count: int, side_m: float) -> NDArray[np.float64]:
    """Points in [0, side_m]^2, shape (count, 2): one at most per cell, off its middle by up to a part of the cell."""
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / max(columns, 1))
    chosen = np.sort(rng.permutation(rows * columns)[:count])
    cell = np.column_stack([chosen % max(columns, 1), chosen // max(columns, 1)])
    jitter = rng.uniform(-GRID_JITTER, GRID_JITTER, (count, 2))
    return np.asarray((cell + 0.5 + jitter) * (side_m / np.maximum([columns, rows], 1)))


@dataclass(frozen=True, slots=True, eq=False)
class _Crowns:
    """Ellipsoids, one row per tree."""

    centre_m: NDArray[np.float64]
    """Shape (trees, 3)."""
    semi_axes_m: NDArray[np.float64]
    """Shape (trees, 3)."""

    @classmethod
    def of_trees(
        cls, trunk_enu_m: NDArray[np.float64], height_m: NDArray[np.float64], radius_m: NDArray[np.float64]
    ) -> _Crowns:
        half_depth = height_m * (1 - CROWN_BASE_FRACTION) / 2
        centre = np.column_stack([trunk_enu_m, height_m - half_depth])
        return cls(centre, np.column_stack([radius_m, radius_m, half_depth]))


def _clump_centres(rng: np.random.Generator, crowns: _Crowns) -> NDArray[np.float64]:
    """Centres of the twig clumps, evenly spread in the crowns, shape (trees, clumps, 3)."""
    trees = len(crowns.centre_m)
    direction = normalised(rng.standard_normal((trees * TWIG_CLUMPS_PER_TREE, 3)))
    # Foliage grows where the light is: the inner third of the crown is bare.
    distance = np.cbrt(rng.uniform(0.04, 1.0, len(direction)))
    offset = (direction * distance[:, None]).reshape(trees, TWIG_CLUMPS_PER_TREE, 3)
    return np.asarray(crowns.centre_m[:, None] + offset * crowns.semi_axes_m[:, None])


def _leaves(rng: np.random.Generator, crowns: _Crowns, clumps: NDArray[np.float64]) -> Mesh:
    trees = len(clumps)
    clump = np.arange(LEAVES_PER_TREE) % TWIG_CLUMPS_PER_TREE
    offset = rng.standard_normal((trees, LEAVES_PER_TREE, 3), dtype=np.float32) * np.float32(CLUMP_SIGMA_M)
    centre = clumps.astype(np.float32)[:, clump] + offset
    triangles = _leaf_triangles(rng, centre.reshape(-1, 3))
    brightness = rng.uniform(0.85, 1.15, (trees, TWIG_CLUMPS_PER_TREE))[:, clump] * rng.uniform(
        0.85, 1.15, (trees, LEAVES_PER_TREE)
    )
    tree_colour = _LEAF_COLOURS[rng.integers(len(_LEAF_COLOURS), size=trees)]
    colour = (brightness[..., None] * tree_colour[:, None]).reshape(-1, 3)
    temperature = LEAF_TEMPERATURE_CELSIUS + rng.uniform(-TEMPERATURE_SPREAD_K, TEMPERATURE_SPREAD_K, len(triangles))
    return uniform_mesh(triangles, Material.LEAF, colour, temperature, _leaf_sky_share(crowns, centre).ravel())


def _leaf_triangles(rng: np.random.Generator, centre_m: FloatArray) -> FloatArray:
    """Leaves that turn to the light, the mean normal pointing up, shape (n, 3, 3)."""
    count = len(centre_m)
    normal = rng.standard_normal((count, 3), dtype=np.float32) + np.array([0, 0, 0.7], np.float32)
    first, second = perpendicular_axes(normal)
    spin = rng.random((count, 1), dtype=np.float32) * np.float32(2 * np.pi)
    half_size = rng.uniform(*LEAF_HALF_SIZE_RANGE_M, (count, 1)).astype(np.float32)
    across = half_size * (np.cos(spin) * first + np.sin(spin) * second)
    along = half_size * (np.cos(spin) * second - np.sin(spin) * first)
    corners = [centre_m + np.float32(x) * across + np.float32(y) * along for x, y in _LEAF_CORNERS]
    return np.stack(corners, axis=1)


def _leaf_sky_share(crowns: _Crowns, centre_m: FloatArray) -> FloatArray:
    """Darker towards the inside and the bottom of the crown, shape (trees, leaves)."""
    relative = (centre_m - crowns.centre_m[:, None]) / crowns.semi_axes_m[:, None]
    outwards = np.clip(np.linalg.norm(relative, axis=2), 0.0, 1.0)
    upwards = np.clip((relative[..., 2] + 1) / 2, 0.0, 1.0)
    return np.asarray(0.25 + 0.6 * outwards * upwards, dtype=np.float32)


def _wood(
    rng: np.random.Generator, trunk: NDArray[np.float64], height: NDArray[np.float64], clumps: NDArray[np.float64]
) -> Mesh:
    """Trunks, and branches that rise from them to some of the clumps."""
    trees = len(trunk)
    foot = np.column_stack([trunk, np.zeros(trees)])
    top = np.column_stack([trunk, 0.9 * height])
    trunk_radius = 0.012 * height
    trunks = tubes(foot, top, trunk_radius, 0.2 * trunk_radius, sides=7)
    tips = clumps[:, :BRANCHES_PER_TREE].reshape(-1, 3)
    forks = np.column_stack([np.repeat(trunk, BRANCHES_PER_TREE, axis=0), 0.75 * tips[:, 2]])
    branches = tubes(forks, tips, np.full(len(tips), 0.06), np.full(len(tips), 0.015), sides=4)
    triangles = np.concatenate([trunks, branches])
    colour = _BARK_COLOUR * rng.uniform(0.85, 1.15, (len(triangles), 1))
    temperature = BARK_TEMPERATURE_CELSIUS + rng.uniform(-TEMPERATURE_SPREAD_K, TEMPERATURE_SPREAD_K, len(triangles))
    return uniform_mesh(triangles, Material.BARK, colour, temperature, _BARK_SKY_SHARE)
