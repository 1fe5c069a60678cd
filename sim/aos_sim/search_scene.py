"""The scenes of the study of effectiveness (``aos_gcs.lab.scenes``): forest, bodies, and vehicles that err."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.lab.scenes import Exposure, PositionGrade, SceneBody, SceneSettings
from aos_sim.errors.cameras import LAST_MOMENT_S, ErringCameras, four_bands
from aos_sim.errors.hover import Hover
from aos_sim.errors.model import error_model
from aos_sim.render.renderer import Renderer
from aos_sim.world.person import Posture
from aos_sim.world.scene import SceneParameters, build_scene

SIDE_M = 60.0
"""Side of the forest: the ground that ten cameras see from 35-44 m, in a line or gathered around a body."""
MAX_OF_A_KIND = 2
"""Animals, stones, cloths, stumps and puddles: none to so many of each."""

BACKDROP_STRIDE = 2
"""Forest is rendered in every second pixel where no body is; its statistics are those of full frames."""

_FLOWN_BY = PositionGrade.GNSS
"""Grade of the positions by which the vehicles steer."""


class SimulatedSearchScene:
    """See :class:`aos_gcs.lab.scenes.SearchScene`."""

    def __init__(self, settings: SceneSettings) -> None:
        scene_rng, self._vehicle_rng = np.random.default_rng([settings.seed, int(settings.has_person)]).spawn(2)
        animals, stones, cloths, stumps, waters = (int(count) for count in scene_rng.integers(0, MAX_OF_A_KIND + 1, 5))
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
                stumps=stumps,
                waters=waters,
                dressed=True,
            )
        )
        self._model = error_model(_FLOWN_BY)
        self._renderer = Renderer(self._scene, wind=self._model.wind)
        # Both grades from the same draws: they differ in the size of the position errors and in nothing else.
        self._error_seed = int(self._vehicle_rng.integers(2**63))
        self._hover = {grade: Hover(error_model(grade), settings.vehicles, self._error_seed) for grade in PositionGrade}

    @property
    def bodies(self) -> Sequence[SceneBody]:
        """See :attr:`aos_gcs.lab.scenes.SearchScene.bodies`."""
        persons = [
            SceneBody(f"person {person.posture}", _place(person.position_enu_m)) for person in self._scene.persons
        ]
        others = [SceneBody(other.kind, _place(other.position_enu_m)) for other in self._scene.distractors]
        return (*persons, *others)

    def visible_areas_m2(self, positions_enu_m: NDArray[np.float64], camera: CameraModel) -> NDArray[np.float64]:
        """See :meth:`aos_gcs.lab.scenes.SearchScene.visible_areas_m2`."""
        errors_m = self._hover[_FLOWN_BY].position_error_enu_m
        poses = [nadir_pose(position_m) for position_m in positions_enu_m - errors_m]
        pixels = np.array([self._renderer.visible_body_pixels(pose, camera) for pose in poses])
        heights_m = np.array([pose.position_enu_m[2] for pose in poses])
        return np.asarray(pixels * (heights_m**2 / (camera.fx_px * camera.fy_px))[:, np.newaxis])

    def expose(
        self, positions_enu_m: NDArray[np.float64], camera: CameraModel, rng: np.random.Generator
    ) -> list[Exposure]:
        """See :meth:`aos_gcs.lab.scenes.SearchScene.expose`."""
        moment = int(rng.integers(LAST_MOMENT_S))
        hover, cameras = self._hover[_FLOWN_BY], ErringCameras(self._model, camera, self._error_seed)
        exposures = []
        for vehicle, waypoint_enu_m in enumerate(positions_enu_m):
            motion = hover.motion(vehicle, waypoint_enu_m, 0.0, rng)
            frame = cameras.expose(self._view, motion, rng, camera_id=vehicle, index=moment, at_s=moment)
            reported = {grade: self._hover[grade].reported(vehicle, motion) for grade in PositionGrade}
            exposures.append(Exposure(four_bands(frame), reported))
        return exposures

    def _view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:
        return self._renderer.view(pose, camera, at_s, BACKDROP_STRIDE)


def build_search_scene(settings: SceneSettings) -> SimulatedSearchScene:
    """Build a scene; see :class:`aos_gcs.lab.scenes.SceneBuilder`."""
    return SimulatedSearchScene(settings)


def _place(position_enu_m: NDArray[np.float64]) -> tuple[float, float]:
    return float(position_enu_m[0]), float(position_enu_m[1])
