"""Triangle meshes with the properties that the renderer shades."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float32]


class Material(IntEnum):
    """Material of a triangle."""

    LEAF = 0
    BARK = 1
    CLOTHING = 2
    SKIN = 3
    FUR = 4
    STONE = 5
    FABRIC = 6
    WATER = 7


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles without shared vertices, one row per triangle in every array."""

    triangles_enu_m: FloatArray
    """Shape (n, 3 vertices, 3 axes)."""
    material: NDArray[np.uint8]
    """Values of :class:`Material`, shape (n,)."""
    albedo_rgb: FloatArray
    """Colour in white light, 0 to 255, shape (n, 3)."""
    temperature_celsius: FloatArray
    """Apparent temperature, shape (n,)."""
    sky_share: FloatArray
    """Part of the sky's light that reaches the triangle, 0 to 1, shape (n,)."""

    def __len__(self) -> int:
        return len(self.triangles_enu_m)


def concatenate(meshes: Sequence[Mesh]) -> Mesh:
    """Join meshes in the given order; no mesh at all gives an empty one."""
    meshes = [*meshes, _EMPTY]
    return Mesh(
        np.concatenate([mesh.triangles_enu_m for mesh in meshes]),
        np.concatenate([mesh.material for mesh in meshes]),
        np.concatenate([mesh.albedo_rgb for mesh in meshes]),
        np.concatenate([mesh.temperature_celsius for mesh in meshes]),
        np.concatenate([mesh.sky_share for mesh in meshes]),
    )


def uniform_mesh(
    triangles_enu_m: FloatArray,
    material: Material,
    albedo_rgb: ArrayLike,
    temperature_celsius: ArrayLike,
    sky_share: ArrayLike,
) -> Mesh:
    """Mesh of one material; colour, shape (3,) or (n, 3), temperature and sky share, () or (n,), are broadcast."""
    count = len(triangles_enu_m)
    return Mesh(
        triangles_enu_m,
        np.full(count, material, dtype=np.uint8),
        np.broadcast_to(np.asarray(albedo_rgb, dtype=np.float32), (count, 3)),
        np.broadcast_to(np.asarray(temperature_celsius, dtype=np.float32), (count,)),
        np.broadcast_to(np.asarray(sky_share, dtype=np.float32), (count,)),
    )


def tubes(
    start_m: ArrayLike, end_m: ArrayLike, start_radius_m: ArrayLike, end_radius_m: ArrayLike, sides: int
) -> FloatArray:
    """Side faces of tapered tubes, open at both ends.

    Args:
        start_m: Centres of the first rings, shape (n, 3).
        end_m: Centres of the second rings, shape (n, 3), different from the first.
        start_radius_m: Shape (n,).
        end_radius_m: Shape (n,).
        sides: Number of faces round a tube.

    Returns:
        Triangles, shape (n * sides * 2, 3, 3), those of a tube in sequence.
    """
    start, end = np.asarray(start_m, dtype=np.float64), np.asarray(end_m, dtype=np.float64)
    across, up = perpendicular_axes(end - start)
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(angle)[:, None] * across[:, None] + np.sin(angle)[:, None] * up[:, None]
    lower = start[:, None] + np.asarray(start_radius_m)[:, None, None] * ring
    upper = end[:, None] + np.asarray(end_radius_m)[:, None, None] * ring
    next_lower, next_upper = np.roll(lower, -1, axis=1), np.roll(upper, -1, axis=1)
    faces = np.stack(
        [np.stack([lower, next_lower, upper], axis=2), np.stack([upper, next_lower, next_upper], axis=2)], axis=2
    )
    return faces.reshape(-1, 3, 3).astype(np.float32)


def ellipsoid(centre_m: ArrayLike, semi_axes_m: ArrayLike, segments: int = 12, rings: int = 8) -> FloatArray:
    """Closed axis-parallel ellipsoid, triangles of shape (segments * rings * 2, 3, 3); those at the poles vanish."""
    polar = np.linspace(0.0, np.pi, rings + 1)[:, None]
    azimuth = np.linspace(0.0, 2 * np.pi, segments + 1)[None, :]
    sphere = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar) * np.ones_like(azimuth)],
        axis=-1,
    )
    points = np.asarray(centre_m) + np.asarray(semi_axes_m) * sphere
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[:-1, 1:], points[1:, 1:]
    faces = np.stack([np.stack([a, b, c], axis=2), np.stack([c, b, d], axis=2)], axis=2)
    return faces.reshape(-1, 3, 3).astype(np.float32)


def perpendicular_axes(direction: NDArray[np.floating]) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Two unit vectors that are perpendicular to each direction and to one another, each of shape (n, 3)."""
    steep = np.abs(direction[:, 2:]) > 0.9 * np.linalg.norm(direction, axis=1, keepdims=True)
    helper = np.where(steep, np.array([1, 0, 0], direction.dtype), np.array([0, 0, 1], direction.dtype))
    first = normalised(np.cross(direction, helper))
    return first, normalised(np.cross(direction, first))


def normalised(vectors: NDArray[np.floating]) -> NDArray[np.floating]:
    """Vectors of length one, shape (n, 3)."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


_EMPTY = Mesh(
    np.empty((0, 3, 3), np.float32),
    np.empty(0, np.uint8),
    np.empty((0, 3), np.float32),
    np.empty(0, np.float32),
    np.empty(0, np.float32),
)
