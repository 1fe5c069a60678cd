"""Broad-leaved trees on a jittered grid.

A leaf is one triangle whose area is that of a square of 14-32 cm: a spray of small leaves rather than a single one,
which halves the mesh without changing what the canopy hides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.mesh import Material, Mesh, concatenate, normalised, perpendicular_axes, tubes, uniform_mesh

HEIGHT_RANGE_M = (12.0, 18.0)
CROWN_RADIUS_RANGE_M = (3.2, 4.6)
LEAVES_PER_TREE = 3500
TWIG_CLUMPS_PER_TREE = 150
CLUMP_SIGMA_M = 0.7
LEAF_HALF_SIZE_RANGE_M = (0.07, 0.16)
BRANCHES_PER_TREE = 8
CROWN_BASE_FRACTION = 0.35
"""Height of the crown's lower edge, as a fraction of the tree's height."""

LEAF_TEMPERATURE_CELSIUS = 11.5
BARK_TEMPERATURE_CELSIUS = 12.2

_LEAF_COLOURS = np.array([[74, 104, 44], [88, 118, 50], [64, 96, 46], [98, 116, 58], [80, 98, 40]], np.float32)
_BARK_COLOUR = np.array([88, 74, 60], np.float32)
# Equilateral triangle of the same area as a square: 3 sqrt(3) / 4 r^2 = (2 s)^2.
_CIRCUMRADIUS_PER_HALF_SIZE = 4 / 27**0.25


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
    clumps = _clump_centres(rng, trunk, height, radius)
    mesh = concatenate([_leaves(rng, clumps), _wood(rng, trunk, height, clumps)])
    return Forest(trunk, height, radius, mesh)


def _jittered_grid(rng: np.random.Generator, count: int, side_m: float) -> NDArray[np.float64]:
    """Points in [0, side_m]^2, shape (count, 2): one at most per cell, anywhere in the middle 80 % of the cell."""
    cells = int(np.ceil(np.sqrt(count)))
    chosen = np.sort(rng.permutation(cells * cells)[:count])
    corner = np.column_stack([chosen % cells, chosen // cells]) if count else np.empty((0, 2))
    return np.asarray((corner + rng.uniform(0.1, 0.9, (count, 2))) * (side_m / max(cells, 1)))


def _clump_centres(
    rng: np.random.Generator, trunk: NDArray[np.float64], height: NDArray[np.float64], radius: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Centres of the twig clumps inside an ellipsoidal crown, shape (trees, clumps, 3)."""
    shape = (len(trunk), TWIG_CLUMPS_PER_TREE)
    direction = normalised(rng.standard_normal((shape[0] * shape[1], 3))).reshape(*shape, 3)
    # Foliage grows where the light is: the inner third of the crown is bare.
    distance = np.cbrt(rng.uniform(0.04, 1.0, shape))[..., None]
    half_depth = height * (1 - CROWN_BASE_FRACTION) / 2
    semi_axes = np.stack([radius, radius, half_depth], axis=-1)[:, None]
    centre = np.column_stack([trunk, height - half_depth])[:, None]
    return np.asarray(centre + direction * distance * semi_axes)


def _leaves(rng: np.random.Generator, clumps: NDArray[np.float64]) -> Mesh:
    trees = len(clumps)
    clump = np.arange(LEAVES_PER_TREE) % TWIG_CLUMPS_PER_TREE
    offset = rng.standard_normal((trees, LEAVES_PER_TREE, 3), dtype=np.float32) * np.float32(CLUMP_SIGMA_M)
    centre = (clumps.astype(np.float32)[:, clump] + offset).reshape(-1, 3)
    count = len(centre)
    # Leaves turn to the light: the mean normal points up.
    normal = rng.standard_normal((count, 3), dtype=np.float32) + np.array([0, 0, 0.7], np.float32)
    spin = rng.uniform(0, 2 * np.pi, count).astype(np.float32)
    circumradius = (rng.uniform(*LEAF_HALF_SIZE_RANGE_M, count) * _CIRCUMRADIUS_PER_HALF_SIZE).astype(np.float32)
    across, along = perpendicular_axes(normal)
    triangles = np.empty((count, 3, 3), np.float32)
    for corner in range(3):
        angle = spin + np.float32(corner * 2 * np.pi / 3)
        triangles[:, corner] = centre + circumradius[:, None] * (
            np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * along
        )
    tree_colour = _LEAF_COLOURS[rng.integers(len(_LEAF_COLOURS), size=trees)] * rng.uniform(0.9, 1.1, (trees, 1))
    colour = np.repeat(tree_colour, LEAVES_PER_TREE, axis=0) * rng.uniform(0.8, 1.2, (count, 1))
    temperature = LEAF_TEMPERATURE_CELSIUS + 0.5 * rng.standard_normal(count)
    return uniform_mesh(triangles, Material.LEAF, colour, temperature)


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
    temperature = BARK_TEMPERATURE_CELSIUS + 0.4 * rng.standard_normal(len(triangles))
    return uniform_mesh(triangles, Material.BARK, colour, temperature)
