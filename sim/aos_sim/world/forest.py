"""Trees on a jittered grid."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

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
from aos_sim.world.relief import Relief
from aos_sim.world.species import BROADLEAF, CrownShape, Species

BRANCHES_PER_TREE = 8
_TRUNK_SIDES = 7
_BRANCH_SIDES = 4
GRID_JITTER = 0.2
"""Largest offset of a trunk from the middle of its cell, in cells."""

LEAF_TEMPERATURE_CELSIUS = 11.5
BARK_TEMPERATURE_CELSIUS = 12.2
TEMPERATURE_SPREAD_K = 0.8
"""Largest deviation of one leaf or face of bark. Bounded, so that no single leaf looks like a warm body."""

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
    """All leaves, then all trunks, then all branches; tree by tree in each of them."""

    def on(self, relief: Relief) -> Forest:
        """Return the forest of level ground standing on another: every tree as high as the ground at its trunk."""
        trees = len(self.trunk_enu_m)
        if not trees:
            return self
        wood = (2 * _TRUNK_SIDES, 2 * _BRANCH_SIDES * BRANCHES_PER_TREE)
        parts = (len(self.mesh) // trees - sum(wood), *wood)
        tree = np.concatenate([np.repeat(np.arange(trees), triangles) for triangles in parts])
        triangles_m = self.mesh.triangles_enu_m.copy()
        triangles_m[..., 2] += relief.height_m(*self.trunk_enu_m.T).astype(np.float32)[tree, np.newaxis]
        return replace(self, mesh=replace(self.mesh, triangles_enu_m=triangles_m))


def grow_forest(
    rng: np.random.Generator,
    corner_enu_m: tuple[float, float],
    side_m: float,
    trees_per_ha: float,
    species: Species = BROADLEAF,
) -> Forest:
    """Plant and build the trees of a square; crowns may reach beyond its edges, trunks do not.

    Args:
        rng: draws places, sizes and leaves.
        corner_enu_m: south-western corner of the square.
        side_m: its side.
        trees_per_ha: 10,000 square metres.
        species: species of all trees.
    """
    count = round(trees_per_ha * side_m**2 / 1e4)
    trunk = np.array(corner_enu_m) + _jittered_grid(rng, count, side_m)
    height = rng.uniform(*species.height_range_m, count)
    radius = rng.uniform(*species.crown_radius_range_m, count)
    if count == 0:
        return Forest(trunk, height, radius, concatenate([]))
    crowns = _Crowns.of_trees(trunk, height, radius, species.crown_base_fraction)
    clumps = _clump_centres(rng, crowns, species)
    mesh = concatenate([_leaves(rng, crowns, clumps, species), _wood(rng, trunk, height, clumps)])
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
    """Ellipsoids that hold the crowns, one row per tree."""

    centre_m: NDArray[np.float64]
    """Shape (trees, 3)."""
    semi_axes_m: NDArray[np.float64]
    """Shape (trees, 3)."""

    @classmethod
    def of_trees(
        cls,
        trunk_enu_m: NDArray[np.float64],
        height_m: NDArray[np.float64],
        radius_m: NDArray[np.float64],
        base_fraction: float,
    ) -> _Crowns:
        half_depth = height_m * (1 - base_fraction) / 2
        centre = np.column_stack([trunk_enu_m, height_m - half_depth])
        return cls(centre, np.column_stack([radius_m, radius_m, half_depth]))


def _clump_centres(rng: np.random.Generator, crowns: _Crowns, species: Species) -> NDArray[np.float64]:
    """Centres of the twig clumps, evenly spread in the crowns, shape (trees, clumps, 3)."""
    trees = len(crowns.centre_m)
    place = _in_ball if species.crown_shape is CrownShape.ELLIPSOID else _in_cone
    offset = place(rng, trees * species.clumps).reshape(trees, species.clumps, 3)
    return np.asarray(crowns.centre_m[:, None] + offset * crowns.semi_axes_m[:, None])


def _in_ball(rng: np.random.Generator, count: int) -> NDArray[np.floating]:
    """Points in the unit ball, shape (count, 3)."""
    direction = normalised(rng.standard_normal((count, 3)))
    # Foliage grows where the light is: the inner third of the crown is bare.
    return np.asarray(direction * np.cbrt(rng.uniform(0.04, 1.0, count))[:, None])


def _in_cone(rng: np.random.Generator, count: int) -> NDArray[np.floating]:
    """Points in the cone of radius 1 at z = -1 with its apex at z = 1, shape (count, 3)."""
    width = np.cbrt(rng.uniform(0.0, 1.0, count))
    # As in the ball, the foliage is outside.
    radius = width * np.sqrt(rng.uniform(0.1, 1.0, count))
    angle = rng.uniform(0.0, 2 * np.pi, count)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 1 - 2 * width])


def _leaves(rng: np.random.Generator, crowns: _Crowns, clumps: NDArray[np.float64], species: Species) -> Mesh:
    trees = len(clumps)
    clump = np.arange(species.leaves) % species.clumps
    offset = rng.standard_normal((trees, species.leaves, 3), dtype=np.float32) * np.float32(species.clump_sigma_m)
    centre = clumps.astype(np.float32)[:, clump] + offset
    triangles = _leaf_triangles(rng, centre.reshape(-1, 3), species.leaf_half_size_range_m)
    brightness = rng.uniform(0.85, 1.15, (trees, species.clumps))[:, clump] * rng.uniform(
        0.85, 1.15, (trees, species.leaves)
    )
    colours = np.array(species.colours_rgb, np.float32)
    tree_colour = colours[rng.integers(len(colours), size=trees)]
    colour = (brightness[..., None] * tree_colour[:, None]).reshape(-1, 3)
    temperature = LEAF_TEMPERATURE_CELSIUS + rng.uniform(-TEMPERATURE_SPREAD_K, TEMPERATURE_SPREAD_K, len(triangles))
    return uniform_mesh(triangles, Material.LEAF, colour, temperature, _leaf_sky_share(crowns, centre).ravel())


def _leaf_triangles(
    rng: np.random.Generator, centre_m: FloatArray, half_size_range_m: tuple[float, float]
) -> FloatArray:
    """Leaves that turn to the light, the mean normal pointing up, shape (n, 3, 3)."""
    count = len(centre_m)
    normal = rng.standard_normal((count, 3), dtype=np.float32) + np.array([0, 0, 0.7], np.float32)
    first, second = perpendicular_axes(normal)
    spin = rng.random((count, 1), dtype=np.float32) * np.float32(2 * np.pi)
    half_size = rng.uniform(*half_size_range_m, (count, 1)).astype(np.float32)
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
    trunks = tubes(foot, top, trunk_radius, 0.2 * trunk_radius, sides=_TRUNK_SIDES)
    tips = clumps[:, :BRANCHES_PER_TREE].reshape(-1, 3)
    forks = np.column_stack([np.repeat(trunk, BRANCHES_PER_TREE, axis=0), 0.75 * tips[:, 2]])
    branches = tubes(forks, tips, np.full(len(tips), 0.06), np.full(len(tips), 0.015), sides=_BRANCH_SIDES)
    triangles = np.concatenate([trunks, branches])
    colour = _BARK_COLOUR * rng.uniform(0.85, 1.15, (len(triangles), 1))
    temperature = BARK_TEMPERATURE_CELSIUS + rng.uniform(-TEMPERATURE_SPREAD_K, TEMPERATURE_SPREAD_K, len(triangles))
    return uniform_mesh(triangles, Material.BARK, colour, temperature, _BARK_SKY_SHARE)
