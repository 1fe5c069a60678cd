"""The laboratory's world: the simulator's forest with one movable person (``aos_gcs.lab.worlds``)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.lab.worlds import ForestType, Target, TargetViews, TerrainShape, WorldParameters
from aos_sim.errors.cameras import LAST_MOMENT_S, ErringCameras, four_bands
from aos_sim.errors.hover import Hover
from aos_sim.errors.model import ErrorModel, error_model
from aos_sim.render.raycaster import NO_HIT, RayCaster
from aos_sim.render.renderer import LitForest, Renderer
from aos_sim.world.mesh import FloatArray
from aos_sim.world.person import Person, Posture, person_mesh
from aos_sim.world.scene import Scene, SceneParameters, build_scene
from aos_sim.world.species import BROADLEAF, CONIFER

CELL_M = 0.05
"""Cell size of the raster around the target; a camera of 512 pixels and 50 degrees at 35 m has pixels of 0.064 m."""
HALF_WIDTH_CELLS = 60
"""Half the raster's edge: 3 m hold what a standing person hides from a camera that sees it 55 degrees off the nadir."""

RASTER_CELLS = 2 * HALF_WIDTH_CELLS

_SPECIES = {ForestType.BROADLEAF: BROADLEAF, ForestType.CONIFER: CONIFER}

_ViewKey = tuple[bytes, bytes, CameraModel, Target]
"""Position and rotation of a camera, its model, and the target: all that decides what it sees of it."""


class LabWorld:
    """A forest and its ray caster; light and textures are made when the first image is asked for."""

    def __init__(self, scene: Scene, errors: ErrorModel) -> None:
        self._scene = scene
        self._errors = errors
        self._forest = RayCaster(scene.forest.mesh.triangles_enu_m)
        self._latest_cells: dict[_ViewKey, tuple[NDArray[np.intp], NDArray[np.bool_]]] = {}

    @property
    def area_enu_m(self) -> NDArray[np.float64]:
        """See :attr:`aos_gcs.lab.worlds.World.area_enu_m`."""
        return self._scene.area_enu_m

    @property
    def trunks_enu_m(self) -> NDArray[np.float64]:
        """See :attr:`aos_gcs.lab.worlds.World.trunks_enu_m`."""
        return self._scene.forest.trunk_enu_m

    def view_target(self, poses: Sequence[Pose], camera: CameraModel, target: Target) -> TargetViews:
        """See :meth:`aos_gcs.lab.worlds.World.view_target`."""
        corner = _raster_corner(target)
        keys = [(pose.position_enu_m.tobytes(), pose.R_cam2enu.tobytes(), camera, target) for pose in poses]
        # A drone that holds its place above a target that stays sees what it saw in the step before.
        known = {key: self._latest_cells[key] for key in keys if key in self._latest_cells}
        new = [index for index, key in enumerate(keys) if key not in known]
        cells = self._cells_of_target([poses[index] for index in new], camera, target, corner)
        known.update(zip((keys[index] for index in new), cells, strict=True))
        self._latest_cells = known
        unoccluded = np.zeros((len(poses), RASTER_CELLS, RASTER_CELLS), dtype=np.bool_)
        seen = np.zeros_like(unoccluded)
        for view, key in enumerate(keys):
            covered, free = known[key]
            unoccluded[view].reshape(-1)[covered] = True
            seen[view].reshape(-1)[covered[free]] = True
        west, north = corner
        return TargetViews(seen, unoccluded, west * CELL_M, north * CELL_M, CELL_M)

    def _cells_of_target(
        self, poses: Sequence[Pose], camera: CameraModel, target: Target, corner: tuple[int, int]
    ) -> list[tuple[NDArray[np.intp], NDArray[np.bool_]]]:
        """Return per pose the cells of the raster that belong to the target, and which of them no leaf hides."""
        if not poses:
            return []
        triangles, body = _body(replace(target, position_enu_m=(0.0, 0.0)))
        west, north = corner
        index = np.arange(RASTER_CELLS)
        # Frame: the target's place is the origin, so that one body serves all steps of a walk.
        east_m, north_m = (
            CELL_M * (west + index + 0.5) - target.position_enu_m[0],
            CELL_M * (north - index - 0.5) - target.position_enu_m[1],
        )
        place_m = np.array([*target.position_enu_m, 0.0])
        positions_m = np.array([pose.position_enu_m for pose in poses]) - place_m
        view, row, column = _candidates(positions_m, triangles, east_m, north_m)
        offset_m = np.column_stack([east_m[column], north_m[row], np.zeros(len(row))]) - positions_m[view]
        inside = _in_image(offset_m, np.array([pose.R_cam2enu for pose in poses])[view], camera)
        view, cell, directions = view[inside], (row * RASTER_CELLS + column)[inside], offset_m[inside]
        directions = directions.astype(np.float32)
        triangle, distance = body.first_hit_with_distance(positions_m[view].astype(np.float32), directions)
        hit = triangle != NO_HIT
        view, cell = view[hit], cell[hit]
        origins = (positions_m + place_m)[view].astype(np.float32)
        _, forest_distance = self._forest.first_hit_with_distance(origins, directions[hit])
        free = distance[hit] < forest_distance
        ends = np.searchsorted(view, np.arange(1, len(poses)))
        return list(zip(np.split(cell, ends), np.split(free, ends), strict=True))

    def render(
        self, poses: Sequence[Pose], camera: CameraModel, target: Target | None, rng: np.random.Generator
    ) -> list[NDArray[np.float32]]:
        """See :meth:`aos_gcs.lab.worlds.World.render`."""
        renderer = self._renderer.with_persons([] if target is None else [_person(target)])
        hover = Hover(self._errors, len(poses), self._scene.parameters.seed)
        cameras = ErringCameras(self._errors, camera, self._scene.parameters.seed)
        drawn = rng.spawn(1)[0]
        moment = int(drawn.integers(LAST_MOMENT_S))
        frames = [
            cameras.expose(
                renderer.view,
                hover.motion(vehicle, pose.position_enu_m, _heading_rad(pose), drawn),
                rng,
                camera_id=vehicle,
                index=moment,
                at_s=moment,
            )
            for vehicle, pose in enumerate(poses)
        ]
        return [four_bands(frame) for frame in frames]

    @cached_property
    def _renderer(self) -> Renderer:
        return Renderer(self._scene, LitForest(self._scene), self._errors.wind)


def build_lab_world(parameters: WorldParameters) -> LabWorld:
    """Grow the forest of these parameters; see :class:`aos_gcs.lab.worlds.WorldBuilder`."""
    if parameters.terrain != TerrainShape.FLAT:
        raise ConfigurationError(f"terrain must be flat, the only one that is simulated, got {parameters.terrain!r}.")
    if parameters.forest not in _SPECIES:
        raise ConfigurationError(f"forest must be one of {', '.join(_SPECIES)}, got {parameters.forest!r}.")
    errors = error_model(parameters.errors, "errors")
    scene = SceneParameters(
        seed=parameters.seed,
        trees_per_ha=parameters.trees_per_ha,
        side_m=parameters.side_m,
        species=_SPECIES[parameters.forest],
    )
    return LabWorld(build_scene(scene), errors)


def _heading_rad(pose: Pose) -> float:
    """Return the heading of a camera that looks straight down."""
    east, north, _ = -pose.R_cam2enu[:, 1]
    return math.atan2(east, north)


def _person(target: Target) -> Person:
    """An average adult in a red jacket: what differs between scenes is the forest, the place and the posture."""
    return Person(
        name="target",
        position_enu_m=np.array([*target.position_enu_m, 0.0]),
        heading_rad=target.heading_rad,
        height_m=1.75,
        posture=Posture(target.posture),
        clothing_rgb=(196, 44, 40),
        skin_temperature_celsius=32.0,
        clothing_temperature_celsius=26.0,
    )


@lru_cache(maxsize=8)
def _body(target: Target) -> tuple[FloatArray, RayCaster]:
    """Return the triangles of a target, whose place is the origin, and their ray caster."""
    triangles = person_mesh(_person(target)).triangles_enu_m
    return triangles, RayCaster(triangles)


def _raster_corner(target: Target) -> tuple[int, int]:
    """Return the raster's western and northern edge, in cells."""
    east_m, north_m = target.position_enu_m
    return math.floor(east_m / CELL_M) - HALF_WIDTH_CELLS, math.floor(north_m / CELL_M) + HALF_WIDTH_CELLS


def _candidates(
    positions_m: NDArray[np.float64],
    triangles_m: FloatArray,
    east_m: NDArray[np.floating],
    north_m: NDArray[np.floating],
) -> tuple[NDArray[np.intp], ...]:
    """Return view, row and column of all cells that the body may cover: those in the bounds of its projected box."""
    low, high = triangles_m.min(axis=(0, 1)).astype(np.float64), triangles_m.max(axis=(0, 1)).astype(np.float64)
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1).reshape(8, 3)
    offset = corners - positions_m[:, None]
    reach = -positions_m[:, None, 2:] / offset[..., 2:]
    on_ground = positions_m[:, None, :2] + reach * offset[..., :2]
    (west, south), (east, north) = on_ground.min(axis=1).T, on_ground.max(axis=1).T
    first_column, end_column = np.searchsorted(east_m, west), np.searchsorted(east_m, east, side="right")
    first_row, end_row = np.searchsorted(-north_m, -north), np.searchsorted(-north_m, -south, side="right")
    widths, heights = end_column - first_column, end_row - first_row
    counts = widths * heights
    view = np.repeat(np.arange(len(positions_m)), counts)
    number = np.arange(len(view)) - np.repeat(np.cumsum(counts) - counts, counts)
    row, column = np.divmod(number, widths[view])
    return view, first_row[view] + row, first_column[view] + column


def _in_image(offset_m: NDArray[np.float64], R_cam2enu: NDArray[np.float64], camera: CameraModel) -> NDArray[np.bool_]:
    """Whether points at ``offset_m`` (k, 3) from cameras turned by ``R_cam2enu`` (k, 3, 3) are imaged, shape (k,)."""
    x, y, depth = np.einsum("ki,kij->jk", offset_m, R_cam2enu)
    # Pixels multiplied by the depth: nothing to divide by beside the camera.
    u, v = camera.fx_px * x + camera.cx_px * depth, camera.fy_px * y + camera.cy_px * depth
    across = (u >= -0.5 * depth) & (u <= (camera.width_px - 0.5) * depth)
    along = (v >= -0.5 * depth) & (v <= (camera.height_px - 0.5) * depth)
    return np.asarray((depth > 0.0) & across & along)
