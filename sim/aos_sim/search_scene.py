"""The scenes of the study of effectiveness (``aos_gcs.lab.scenes``): forest, bodies, and vehicles that err."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.lab.scenes import Body, Exposure, PositionGrade, SceneSettings
from aos_sim.noise import (
    GNSS,
    RTK,
    LastingErrors,
    SensorErrors,
    draw_lasting_errors,
    draw_thermal_pattern,
    reported_pose,
)
from aos_sim.render.renderer import Renderer
from aos_sim.world.person import Posture
from aos_sim.world.scene import SceneParameters, build_scene

SIDE_M = 60.0
"""Side of the forest: the ground that ten cameras see from 35-44 m, in a line or gathered around a body."""
MAX_OF_A_KIND = 2
"""Animals, stones and cloths: none to so many of each."""
HOVER_SPEED_MPS = 0.2
"""Standard deviation per axis of what is left of a vehicle's motion when it hovers."""

BACKDROP_STRIDE = 2
"""Forest is rendered in every second pixel where no body is; its statistics are those of full frames."""

_ERRORS = {PositionGrade.GNSS: GNSS, PositionGrade.RTK: RTK}
_SENSOR = SensorErrors()


class SimulatedSearchScene:
    """See :class:`aos_gcs.lab.scenes.SearchScene`."""

    def __init__(self, settings: SceneSettings) -> None:
        scene_rng, self._vehicle_rng = np.random.default_rng([settings.seed, int(settings.has_person)]).spawn(2)
        animals, stones, cloths = (int(count) for count in scene_rng.integers(0, MAX_OF_A_KIND + 1, 3))
        self._scene = build_scene(
            SceneParameters(
                seed=settings.seed,
                trees_per_ha=settings.trees_per_ha,
                side_m=SIDE_M,
                persons=int(settings.has_person),
                posture=list(Posture)[int(scene_rng.integers(len(Posture)))],
                animals=animals,
                stones=stones,
                cloths=cloths,
            )
        )
        self._renderer = Renderer(self._scene)
        # Both grades from the same draws: they differ in the size of the position errors and in nothing else.
        error_seed = int(self._vehicle_rng.integers(2**63))
        self._lasting: dict[PositionGrade, LastingErrors] = {
            grade: draw_lasting_errors(np.random.default_rng(error_seed), errors, settings.vehicles)
            for grade, errors in _ERRORS.items()
        }
        self._pattern_seed = int(self._vehicle_rng.integers(2**63))

    @property
    def bodies(self) -> Sequence[Body]:
        """See :attr:`aos_gcs.lab.scenes.SearchScene.bodies`."""
        persons = [Body(f"person {person.posture}", _place(person.position_enu_m)) for person in self._scene.persons]
        others = [Body(other.kind, _place(other.position_enu_m)) for other in self._scene.distractors]
        return (*persons, *others)

    def visible_areas_m2(self, positions_enu_m: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
        """See :meth:`aos_gcs.lab.scenes.SearchScene.visible_areas_m2`."""
        poses = self._true_poses(positions_enu_m)
        pixels = np.array([self._renderer.visible_body_pixels(pose, camera) for pose in poses])
        heights_m = np.array([pose.position_enu_m[2] for pose in poses])
        return np.asarray(pixels * (heights_m**2 / (camera.fx_px * camera.fy_px))[:, np.newaxis])

    def expose(
        self, positions_enu_m: NDArray[np.float64], camera: CameraModel, rng: np.random.Generator
    ) -> list[Exposure]:
        """See :meth:`aos_gcs.lab.scenes.SearchScene.expose`."""
        return [
            Exposure(
                image=self._image(vehicle, pose, camera, rng), reported=self._reports(vehicle, pose, rng.spawn(1)[0])
            )
            for vehicle, pose in enumerate(self._true_poses(positions_enu_m))
        ]

    def _true_poses(self, positions_enu_m: NDArray[np.float64]) -> list[Pose]:
        """Return the true positions of the vehicles, which steer by GNSS positions."""
        errors_m = self._lasting[PositionGrade.GNSS].position_enu_m
        return [nadir_pose(position_m) for position_m in positions_enu_m - errors_m]

    def _image(self, vehicle: int, pose: Pose, camera: CameraModel, rng: np.random.Generator) -> NDArray[np.float32]:
        frame = self._renderer.render(pose, camera, rng, BACKDROP_STRIDE)
        pattern = draw_thermal_pattern(
            np.random.default_rng([self._pattern_seed, vehicle]), _SENSOR, frame.thermal_celsius.shape
        )
        return np.dstack([frame.rgb.astype(np.float32), frame.thermal_celsius + pattern])

    def _reports(self, vehicle: int, pose: Pose, rng: np.random.Generator) -> dict[PositionGrade, Pose]:
        velocity_enu_mps = rng.normal(0.0, HOVER_SPEED_MPS, 3)
        state = rng.bit_generator.state
        reports = {}
        for grade, errors in _ERRORS.items():
            rng.bit_generator.state = state
            reports[grade] = reported_pose(
                rng, pose, errors, self._lasting[grade], vehicle=vehicle, velocity_enu_mps=velocity_enu_mps
            )
        return reports


def build_search_scene(settings: SceneSettings) -> SimulatedSearchScene:
    """Build a scene; see :class:`aos_gcs.lab.scenes.SceneBuilder`."""
    return SimulatedSearchScene(settings)


def _place(position_enu_m: NDArray[np.float64]) -> tuple[float, float]:
    return float(position_enu_m[0]), float(position_enu_m[1])
