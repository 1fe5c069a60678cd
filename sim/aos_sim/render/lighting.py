"""Light, computed once per world.

Sun and surfaces stand still, so that what a triangle or a spot of ground looks like depends on nothing but itself: a
frame needs one look-up per pixel, and shadows come for free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_sim.render.raycaster import RayCaster
from aos_sim.world.conditions import CLIMATES, Climate
from aos_sim.world.ground import Ground
from aos_sim.world.mesh import FloatArray, Mesh
from aos_sim.world.relief import Relief
from aos_sim.world.scene import Scene

_SUN_AZIMUTH_RAD = math.radians(200.0)
_SUN_ELEVATION_RAD = math.radians(52.0)
TO_SUN = np.array(
    [
        math.sin(_SUN_AZIMUTH_RAD) * math.cos(_SUN_ELEVATION_RAD),
        math.cos(_SUN_AZIMUTH_RAD) * math.cos(_SUN_ELEVATION_RAD),
        math.sin(_SUN_ELEVATION_RAD),
    ],
    np.float32,
)
"""Unit vector to the sun."""

_FLOOR_SKY_SHARE = 0.45
"""Part of the sky's light that reaches the ground."""
_CANOPY_TOP_M = 18.0
_SURFACE_OFFSET_M = 0.01
_SHADOW_CELL_M = 0.1
_DOWNHILL = 2.0
"""Factor by which shadows may be longer where the ground falls away from the sun."""


def shade_mesh(mesh: Mesh, occluders: RayCaster, climate: Climate) -> FloatArray:
    """Return red, green, blue (0 to 255) and °C per triangle, shape (n, 4), as seen from any side."""
    if len(mesh) == 0:
        return np.empty((0, 4), np.float32)
    a, b, c = (mesh.triangles_enu_m[:, corner] for corner in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    # Leaves let light through and every triangle has two sides: the sign of the normal does not matter.
    facing = 0.4 + 0.6 * np.abs(normal @ TO_SUN) / np.maximum(length, 1e-12)
    centre = (a + b + c) / 3
    sunlit = occluders.is_free(centre + _SURFACE_OFFSET_M * TO_SUN, np.broadcast_to(TO_SUN, centre.shape).copy())
    light = climate.sky * mesh.sky_share + climate.sun * facing * sunlit
    shaded = np.empty((len(mesh), 4), np.float32)
    shaded[:, :3] = np.minimum(mesh.albedo_rgb * light[:, None], 255.0)
    shaded[:, 3] = climate.temperatures(mesh.temperature_celsius, mesh.material, mesh.albedo_rgb, sunlit)
    return shaded


@dataclass(frozen=True, slots=True, eq=False)
class LitGround:
    """The ground with the trees' shadows on it."""

    ground: Ground
    sunlit: NDArray[np.bool_]
    """Raster of ``_SHADOW_CELL_M``, row 0 in the south, with a border in full sun that stands for all beyond."""
    west_m: float
    south_m: float
    climate: Climate

    relief: Relief | None = None
    """Shape of the ground; None: the plane z = 0."""

    def sample(self, east_m: NDArray[np.floating], north_m: NDArray[np.floating]) -> FloatArray:
        """Return red, green, blue (0 to 255) and °C at places of the ground, shape (n, 4)."""
        rows, columns = self.sunlit.shape
        row = np.clip((north_m - self.south_m) / _SHADOW_CELL_M, 0, rows - 1).astype(np.intp)
        column = np.clip((east_m - self.west_m) / _SHADOW_CELL_M, 0, columns - 1).astype(np.intp)
        sunlit = self.sunlit[row, column]
        samples = self.ground.sample(east_m, north_m)
        facing = TO_SUN[2] if self.relief is None else np.maximum(self.relief.normal(east_m, north_m) @ TO_SUN, 0.0)
        samples[:, :3] *= (self.climate.sky * _FLOOR_SKY_SHARE + self.climate.sun * facing * sunlit)[:, None]
        samples[:, 3] += self.climate.ambient_k + self.climate.sun_warming_k * sunlit
        return samples


def light_ground(scene: Scene, occluders: RayCaster) -> LitGround:
    """Cast the shadows of the forest on the ground."""
    margin_m = _CANOPY_TOP_M / math.tan(_SUN_ELEVATION_RAD) + 6.0
    if scene.relief is not None:
        margin_m *= _DOWNHILL
    west, south = scene.area_enu_m.min(axis=0) - margin_m
    cells = math.ceil((scene.parameters.side_m + 2 * margin_m) / _SHADOW_CELL_M)
    climate = CLIMATES[scene.parameters.conditions]
    if occluders.is_empty:
        sunlit = np.ones((cells, cells), np.bool_)
        return LitGround(scene.ground, sunlit, float(west), float(south), climate, scene.relief)
    centre = (np.arange(cells) + 0.5) * _SHADOW_CELL_M
    east, north = np.meshgrid(west + centre, south + centre)
    points = np.column_stack([east.ravel(), north.ravel(), np.zeros(cells * cells)]).astype(np.float32)
    if scene.relief is not None:
        points = scene.relief.lifted(points)
    sunlit = occluders.is_free(points, np.broadcast_to(TO_SUN, points.shape).copy()).reshape(cells, cells)
    return LitGround(scene.ground, sunlit, float(west), float(south), climate, scene.relief)
