"""Searches for one person by all methods: what their frames see of the person, and when that is enough.

A forest is grown around the person alone: views from elsewhere do not pass through other trees. Rays tell what a frame
shows of the body, :mod:`aos_gcs.lab.search.marks` what the detector marks of that.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.tile import MAX_VIEWS
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.detectability.study import BANDS, marked_cells
from aos_gcs.lab.search.chosen import fly_chosen
from aos_gcs.lab.search.chosen_legs import fly_chosen_legs
from aos_gcs.lab.search.marks import marks, persons_share
from aos_gcs.lab.search.model import (
    Conditions,
    Method,
    SearchKey,
    SearchOutcome,
    SearchResult,
    SearchStudySettings,
    forest_of,
    occlusion_of,
    plan_for,
)
from aos_gcs.lab.search.paths import SearchFlight, flown_plan, fly_legs
from aos_gcs.lab.search.persons import person_about_a_point, person_anywhere
from aos_gcs.lab.walk import free_place
from aos_gcs.lab.worlds import Target, World, WorldParameters, build_world
from aos_gcs.planning.detection.expected_views import forest_directions
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.prior.model import AreaPrior

FloatArray = NDArray[np.float64]

IMAGE_PX: Final = 512
_PATCH_M: Final = 50.0
"""Side of the forest around a person: rays from the corners of images pass no crown that would lean in from beyond."""
_CHOOSING: Final = {Method.CHOSEN: fly_chosen, Method.CHOSEN_LEGS: fly_chosen_legs}
_PLACES_M: Final = 4.0
"""Persons are at most so far from its middle, on both axes."""


def search_for_person(settings: SearchStudySettings, key: SearchKey) -> SearchResult:
    """Search for the person of a key by all methods; equal arguments give equal results."""
    rng = np.random.default_rng([key.seed, round(key.trees_per_ha), 16])
    world = build_world(WorldParameters(seed=key.seed, trees_per_ha=key.trees_per_ha, side_m=_PATCH_M))
    place_m = free_place(rng, world.area_enu_m.mean(axis=0), _PLACES_M, world.trunks_enu_m)
    target = Target((float(place_m[0]), float(place_m[1])), float(rng.uniform(0.0, math.tau)), settings.posture)
    outcomes: list[SearchOutcome] = []
    for hectares in settings.hectares:
        # In the same place of the area for all methods and numbers of vehicles.
        prior = None
        if settings.spread is None:
            in_area_m = person_anywhere(hectares, rng)
        else:
            area_enu_m = plan_for(settings.pod, Conditions(key.trees_per_ha, 1, hectares)).area_enu_m
            in_area_m, prior = person_about_a_point(area_enu_m, settings.spread, rng)
        watch = _Watch(world, target, in_area_m, key.seed, renders=key.seed % 1000 < settings.images)
        for vehicles in settings.vehicles:
            conditions = Conditions(key.trees_per_ha, vehicles, hectares, settings.rate_hz)
            outcomes += _searches(settings, conditions, watch, prior)
    return SearchResult(key, tuple(outcomes))


def _searches(
    settings: SearchStudySettings, conditions: Conditions, watch: _Watch, prior: AreaPrior | None
) -> Iterator[SearchOutcome]:
    def flown(method: Method, number: int = 0) -> SearchFlight | None:
        if method is not Method.PRIOR:
            return search_flight(settings.pod, conditions, method, number)
        plan = _planned(settings.pod, conditions)
        return None if plan is None else fly_legs(plan, number, prior)

    for method in settings.methods:
        first = flown(method)
        if first is None:
            continue
        at_once = method is Method.LAWNMOWER
        views, predicted = watch.predicted(first, conditions.trees_per_ha, settings.posture)
        seen_s = watch.noticed_s(first, single=at_once)
        rendered = watch.rendered_s(first) is not None if watch.renders and method is Method.PLANNED else None
        before_s, noticed = 0.0, seen_s is not None
        for number in range(1, settings.passes):
            flight = None if seen_s is not None else flown(method, number)
            if seen_s is not None or flight is None:
                break
            before_s += first.duration_s
            seen_s = watch.noticed_s(flight, single=at_once)
        claimed_s = None if seen_s is None else before_s + seen_s + (0.0 if at_once else settings.close_look_s)
        yield SearchOutcome(
            method=method,
            vehicles=conditions.vehicles,
            hectares=conditions.hectares,
            duration_s=first.duration_s,
            path_m=first.path_m,
            views=views,
            predicted=predicted,
            noticed=noticed,
            claimed_s=claimed_s,
            rendered=rendered,
        )


@lru_cache(maxsize=16)
def _planned(pod: float, conditions: Conditions) -> MissionPlan | None:
    return flown_plan(plan_for(pod, conditions), Method.PLANNED)


@lru_cache(maxsize=1024)
def search_flight(pod: float, conditions: Conditions, method: Method, number: int = 0) -> SearchFlight | None:
    """Return the flight of a method, which depends on nothing of the person; None where there is none.

    Args:
        pod: wanted probability of detection of a standing person.
        conditions: forest, whose density is known, vehicles and area.
        method: how the area is searched.
        number: number of the flight, where several follow each other.
    """
    plan = plan_for(pod, conditions)
    if method not in _CHOOSING:
        flown = flown_plan(plan, method)
        return None if flown is None else fly_legs(flown, number)
    if number == 0:
        planned = flown_plan(plan, Method.PLANNED)
        return None if planned is None else _CHOOSING[method](planned, pod)
    # Nothing in it is drawn: a flight that has missed somebody is flown again with its axes exchanged.
    flight = search_flight(pod, conditions, method)
    if flight is None or number % 2 == 0:
        return flight
    return replace(flight, cameras_enu_m=flight.cameras_enu_m[:, [1, 0, 2]])


class _Watch:
    """A person in an area, as the frames of flights show it."""

    def __init__(self, world: World, target: Target, in_area_m: FloatArray, seed: int, *, renders: bool) -> None:
        self.renders = renders
        self._seed = seed
        self._world = world
        self._target = target
        self._in_area_m = in_area_m
        self._threshold_m2 = DetectionSettings().threshold_m2

    def _near(self, flight: SearchFlight, half_view: float) -> tuple[FloatArray, FloatArray]:
        """Return the times of the exposures that may show the person, and their cameras about the forest."""
        offset_m = flight.cameras_enu_m[:, :2] - self._in_area_m
        near = (np.abs(offset_m) <= flight.cameras_enu_m[:, 2:] * half_view).all(axis=1)
        cameras_m = flight.cameras_enu_m[near].copy()
        cameras_m[:, :2] = offset_m[near] + np.array(self._target.position_enu_m)
        return flight.times_s[near], cameras_m

    def predicted(self, flight: SearchFlight, trees_per_ha: float, posture: Posture) -> tuple[int, float]:
        """Return the number of independent views of the person's place, and the probability of detection there."""
        camera = _camera()
        _, cameras_m = self._near(flight, camera.width_px / 2.0 / camera.fx_px)
        directions = forest_directions(forest_of(trees_per_ha))
        place_m = np.array([*self._target.position_enu_m, 0.0])
        squares, counted = directions.squares(np.zeros(3), place_m - cameras_m)
        views = min(len(np.unique(squares[counted])), MAX_VIEWS)
        law = detection_by_views(occlusion_of(trees_per_ha), DETECTABILITY[posture])
        return views, float(law[views])

    def noticed_s(self, flight: SearchFlight, *, single: bool) -> float | None:
        """Return when frames have shown enough of the person, together or a single one; None if they never do."""
        camera = _camera()
        # Bodies stick out: the frame beyond whose edge the feet are may show the head.
        times_s, cameras_m = self._near(flight, 1.1 * camera.width_px / 2.0 / camera.fx_px)
        if not len(times_s):
            return None
        shown = self._world.view_target([nadir_pose(one) for one in cameras_m], camera, self._target)
        cell_m2 = shown.resolution_m**2
        pixels_m2 = (cameras_m[:, 2] / camera.fx_px) ** 2
        # The same draws for the same frames of the same person.
        rng = np.random.default_rng([self._seed, len(times_s)])
        marked = marks(
            shown.seen,
            pixels_m2,
            shown.resolution_m,
            posture=self._target.posture,
            share=persons_share(self._seed, self._target.posture),
            rng=rng,
        )
        marked = marked.reshape(len(times_s), -1)
        together = marked if single else np.logical_or.accumulate(marked, axis=0)
        (enough,) = np.nonzero(together.sum(axis=1) * cell_m2 >= self._threshold_m2)
        return float(times_s[enough[0]]) if len(enough) else None

    def rendered_s(self, flight: SearchFlight) -> float | None:
        """Return when rendered frames have marked enough of the person; None if they never do."""
        camera, imaging = _camera(), ImagingSettings()
        times_s, cameras_m = self._near(flight, camera.width_px / 2.0 / camera.fx_px)
        poses = [nadir_pose(one) for one in cameras_m]
        if not poses:
            return None
        shown = self._world.view_target(poses, camera, self._target)
        images = self._world.render(poses, camera, self._target, np.random.default_rng(len(poses)))
        marked: set[int] = set()
        for view, (time_s, image, pose) in enumerate(zip(times_s, images, poses, strict=True)):
            marked.update(marked_cells(Frame(1, image, BANDS, pose, camera), shown, view, imaging))
            if len(marked) * shown.resolution_m**2 >= self._threshold_m2:
                return float(time_s)
        return None


@lru_cache(maxsize=1)
def _camera() -> CameraModel:
    return CameraModel.from_fov(IMAGE_PX, IMAGE_PX, math.radians(50.0))
