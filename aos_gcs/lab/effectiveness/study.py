"""The study of effectiveness, one scene at a time: how often 'a person is here' is right, and with which error.

A swarm has scanned until something came into view, gathers above it by the strategy of missions, and looks with
rendered frames whose poses and temperatures err as in the field. What is warm below it is described, located and
recorded with the truth; :mod:`aos_gcs.lab.effectiveness.report` judges it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import Frame, StepAnalysis
from aos_gcs.imaging.persons.bodies import Body, find_bodies
from aos_gcs.imaging.persons.evidence import Evidence
from aos_gcs.imaging.persons.warm_bodies import WarmView, warm_view
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.scenes import Exposure, PositionGrade, SceneBody, SceneSettings, SearchScene, build_scene
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.registry import make_strategy

BANDS = ("red", "green", "blue", "thermal")
_SCENE = Uncertainty(focal_height_m=0.0, target_height_m=0.5, target_height_sigma_m=0.4)
"""The ground is known to be flat; persons stand, sit or lie, and what else is warm is no higher."""
UNCERTAINTIES = {
    PositionGrade.GNSS: replace(_SCENE, position_horizontal_m=0.5, position_vertical_m=0.75),
    PositionGrade.RTK: replace(_SCENE, position_horizontal_m=0.02, position_vertical_m=0.03),
}
"""Uncertainty of poses and scenes as assumed by geolocation."""

IN_VIEW_M2 = 0.05
"""The threshold T of missions."""
_START_DISTANCE_M = 8.0
"""Distance of the line from the body that it is about to find, against the scan direction."""
_START_SPREAD_M = 8.0
"""Greatest lateral offset at which the middle of the line may pass the body."""


@dataclass(frozen=True, slots=True)
class StudySettings:
    """Settings of flight and cameras in a scene.

    Raises:
        ConfigurationError: if a value lies outside its range; the text names it.
    """

    strategy: str = "aos-apso"
    vehicles: int = 10
    altitude_m: float = 35.0
    """Altitude of the lowest vehicle; the others fly above it, one metre apart."""
    image_size_px: int = 512
    fov_rad: float = math.radians(50.0)
    approach_steps: int = 10
    """Steps in which the swarm gathers; the visible area of what attracts it is computed, not imaged."""
    imaging_steps: int = 3
    """Steps that follow, with rendered frames through the imaging engine; the decision rests on them."""

    def __post_init__(self) -> None:
        make_strategy(self.strategy, {})
        if not 2 <= self.vehicles <= 100:
            raise ConfigurationError(f"vehicles must lie within 2 and 100, got {self.vehicles}.")
        if not 64 <= self.image_size_px <= 2048:
            raise ConfigurationError(f"image_size_px must lie within 64 and 2048, got {self.image_size_px}.")
        if self.approach_steps < 0 or self.imaging_steps < 1:
            raise ConfigurationError(
                f"approach_steps must be at least 0 and imaging_steps at least 1, "
                f"got {self.approach_steps} and {self.imaging_steps}."
            )

    @property
    def camera(self) -> CameraModel:
        """Camera model of every vehicle."""
        return CameraModel.from_fov(self.image_size_px, self.image_size_px, self.fov_rad)


@dataclass(frozen=True, slots=True, order=True)
class SceneKey:
    """Names one scene of the study."""

    trees_per_ha: float
    seed: int
    has_person: bool


@dataclass(frozen=True, slots=True)
class WarmBody:
    """One warm body as the swarm knows it."""

    evidence: Evidence
    position_enu_m: tuple[float, float]
    sigma_m: float
    """Root of the mean of the position's variances in east and north."""


@dataclass(frozen=True, slots=True)
class Anomaly:
    """The largest blob of one step."""

    area_m2: float
    position_enu_m: tuple[float, float]


@dataclass(frozen=True, slots=True)
class SceneResult:
    """Knowledge of the swarm at the end, and the truth."""

    key: SceneKey
    bodies: tuple[SceneBody, ...]
    approached: str | None
    """Kind of the body that the swarm gathered above; None: it saw none, and went on scanning."""
    anomalies: dict[PositionGrade, tuple[Anomaly | None, ...]]
    """The largest anomaly of each step with rendered frames, by the grade of positions; None where there was none."""
    warm: dict[PositionGrade, tuple[WarmBody, ...]]
    """Warm bodies, by the grade of positions that the frames are laid on the ground with; the largest first."""


def scene_keys(densities: Iterable[float], first_seed: int, scenes: int) -> list[SceneKey]:
    """Return so many scenes with a person, and as many without, per density; within a density no two have one seed."""
    return [
        SceneKey(density, 2 * index + has_person, bool(has_person))
        for index in range(first_seed, first_seed + scenes)
        for density in densities
        for has_person in (0, 1)
    ]


def study_scene(key: SceneKey, settings: StudySettings) -> SceneResult:
    """Fly one scene; a few seconds. Equal arguments give equal results."""
    scene = build_scene(SceneSettings(key.seed, key.trees_per_ha, key.has_person, settings.vehicles))
    flight = _Flight(scene, settings, np.random.default_rng([key.seed, int(key.has_person), 7]))
    # A person is what the study is about; without one, the swarm may take whatever it sees for it.
    wanted = slice(0, 1) if key.has_person else slice(0, len(scene.bodies))
    approached = flight.approach(wanted)
    views, anomalies = flight.look()
    return SceneResult(
        key=key,
        bodies=tuple(scene.bodies),
        approached=None if approached is None else scene.bodies[approached].kind,
        anomalies={grade: tuple(anomalies[grade]) for grade in PositionGrade},
        warm={
            grade: tuple(map(_warm_body, find_bodies(views[grade], 0.0, UNCERTAINTIES[grade])))
            for grade in PositionGrade
        },
    )


def study_scenes(keys: Iterable[SceneKey], settings: StudySettings, jobs: int) -> Iterator[SceneResult]:
    """Fly many scenes in so many processes, and yield results as they come."""
    keys = list(keys)
    if jobs == 1:
        yield from (study_scene(key, settings) for key in keys)
        return
    # Not forked: OpenCV's and BLAS's threads do not survive it.
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        tasks = [pool.submit(study_scene, key, settings) for key in keys]
        for task in as_completed(tasks):
            yield task.result()


class _Flight:
    """The swarm in one scene: positions and the state of its strategy."""

    def __init__(self, scene: SearchScene, settings: StudySettings, rng: np.random.Generator) -> None:
        self._scene = scene
        self._settings = settings
        self._start_rng, self._strategy_rng, self._camera_rng = rng.spawn(3)
        self._strategy = make_strategy(settings.strategy, {})
        self._state: Any = self._strategy.init(np.array([0.0, 1.0]))
        self._vehicle_ids = tuple(range(1, settings.vehicles + 1))
        self._heights_m = settings.altitude_m + np.arange(settings.vehicles, dtype=np.float64)
        self._positions_enu_m = np.zeros((settings.vehicles, 2))

    def approach(self, wanted: slice) -> int | None:
        """Gather above one of the wanted bodies; return its index, or None if none has come into view."""
        bodies_enu_m = np.array([body.position_enu_m for body in self._scene.bodies]).reshape(-1, 2)
        self._line_up(bodies_enu_m[wanted])
        leading = None
        for _ in range(self._settings.approach_steps):
            areas_m2 = self._scene.visible_areas_m2(self._at_heights(), self._settings.camera)[:, wanted]
            together_m2 = areas_m2.sum(axis=0)
            leading = int(together_m2.argmax()) if together_m2.max(initial=0.0) >= IN_VIEW_M2 else None
            self._move(
                np.zeros(self._settings.vehicles) if leading is None else areas_m2[:, leading],
                None if leading is None else bodies_enu_m[wanted][leading],
            )
        return leading

    def look(self) -> tuple[dict[PositionGrade, list[WarmView]], dict[PositionGrade, list[Anomaly | None]]]:
        """Make the steps with rendered frames; return what is warm in them, and the largest anomaly of each step."""
        views: dict[PositionGrade, list[WarmView]] = {grade: [] for grade in PositionGrade}
        anomalies: dict[PositionGrade, list[Anomaly | None]] = {grade: [] for grade in PositionGrade}
        for _ in range(self._settings.imaging_steps):
            exposures = self._scene.expose(self._at_heights(), self._settings.camera, self._camera_rng)
            analyses = {}
            for grade in PositionGrade:
                frames = self._frames(exposures, grade)
                analyses[grade] = analyse_step(frames, ImagingSettings())
                views[grade] += [warm_view(frame) for frame in frames]
                anomalies[grade].append(_anomaly(analyses[grade]))
            # The swarm flies by one of the grades; the other one looks at the same flight.
            self._follow(analyses[PositionGrade.GNSS])
        return views, anomalies

    def _line_up(self, goals_enu_m: NDArray[np.float64]) -> None:
        """Place the line of the scan south of one of the goals, or of the forest's middle where there is none."""
        goal_enu_m = np.array([0.0, 30.0])
        if len(goals_enu_m):
            goal_enu_m = goals_enu_m[int(self._start_rng.integers(len(goals_enu_m)))]
        aside_m = float(self._start_rng.uniform(-_START_SPREAD_M, _START_SPREAD_M))
        places = np.arange(self._settings.vehicles) - (self._settings.vehicles - 1) / 2
        east_m = goal_enu_m[0] + aside_m + self._strategy.spacing_m * places
        self._positions_enu_m = np.column_stack((east_m, np.full(len(places), goal_enu_m[1] - _START_DISTANCE_M)))

    def _follow(self, analysis: StepAnalysis) -> None:
        in_view = analysis.blob is not None and analysis.visibility_m2 >= IN_VIEW_M2
        target_enu_m = np.array(analysis.blob.centroid_enu_m[:2]) if analysis.blob is not None and in_view else None
        self._move(analysis.fitness, target_enu_m)

    def _move(self, fitness: NDArray[np.float64], target_enu_m: NDArray[np.float64] | None) -> None:
        observation = Observation(
            vehicle_ids=self._vehicle_ids,
            positions_enu_m=self._positions_enu_m,
            fitness=fitness,
            target_in_view=target_enu_m is not None,
            target_enu_m=target_enu_m,
            heights_m=self._heights_m,
        )
        self._state = self._strategy.tell(self._state, observation)
        self._positions_enu_m, self._state = self._strategy.ask(self._state, self._strategy_rng)

    def _at_heights(self) -> NDArray[np.float64]:
        return np.column_stack((self._positions_enu_m, self._heights_m))

    def _frames(self, exposures: list[Exposure], grade: PositionGrade) -> list[Frame]:
        return [
            Frame(vehicle_id, exposure.image, BANDS, exposure.reported[grade], self._settings.camera)
            for vehicle_id, exposure in zip(self._vehicle_ids, exposures, strict=True)
        ]


def _anomaly(analysis: StepAnalysis) -> Anomaly | None:
    if analysis.blob is None:
        return None
    east_m, north_m, _ = analysis.blob.centroid_enu_m
    return Anomaly(analysis.blob.area_m2, (east_m, north_m))


def _warm_body(body: Body) -> WarmBody:
    variance_m2 = float(np.trace(body.place.covariance_m2[:2, :2])) / 2
    east_m, north_m, _ = body.place.position_enu_m
    return WarmBody(body.evidence, (float(east_m), float(north_m)), math.sqrt(variance_m2))
