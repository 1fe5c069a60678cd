"""A mission of the study of missions: flown in virtual time, and judged by the truth."""

from __future__ import annotations

import logging
import math
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from aos_gcs.airspace.polygon import as_polygon, signed_area_m2
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.model import SurfaceKind
from aos_gcs.imaging.persons.decision import CLAIMED
from aos_gcs.lab.flights import Flight, FlightParameters, Place, build_flight
from aos_gcs.lab.missions.model import HERE_M, LegChoice, MissionKey, MissionResult, MissionsSettings
from aos_gcs.mission.model.decisions import ConclusionRecord
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import LookOrder
from aos_gcs.runtime.simulated.planned_missions import planned_for, predicted, with_chosen_legs
from aos_gcs.runtime.simulated.virtual_mission import FlownMission, fly, mission_settings, search_settings

PersonsAt = Callable[[float], Sequence[Place]]
"""Returns the places of the persons, some seconds after the start of a mission."""


def fly_mission(settings: MissionsSettings, key: MissionKey) -> MissionResult:
    """Fly one mission of a study. Equal arguments give equal results but for the processor time.

    Raises:
        ConfigurationError: preflight does not let it take off, or a value is out of its range.
    """
    spacing = settings.spacing(key.errors)
    flight = build_flight(
        FlightParameters(
            seed=key.seed,
            vehicles=settings.vehicles,
            trees_per_ha=key.trees_per_ha,
            has_person=key.has_person,
            errors=key.errors,
            conditions=key.conditions,
            side_m=settings.side_m,
            image_size_px=settings.image_size_px,
            terrain=settings.terrain,
            launch_spacing_m=spacing.launch_m,
        )
    )
    begin_s = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "ground.tif"
        ground = file if flight.write_ground(file) else None
        planned = mission_settings(
            flight,
            settings.vehicles,
            settings.strategy,
            key.seed,
            ground=ground,
            spacing=spacing,
            follow=settings.follow_ground,
            search=search_settings(settings.search_mode),
        )
        if settings.surface:
            planned = replace(planned, imaging=replace(planned.imaging, surface=SurfaceKind(settings.surface)))
        if settings.looks:
            planned = replace(planned, search=replace(planned.search, looks=LookOrder(settings.looks)))
        if settings.pod is not None:
            planned = planned_for(planned, key.trees_per_ha, settings.pod)
        legs: tuple[ScanLeg, ...] = ()
        if settings.pod is not None and settings.legs == LegChoice.CHOSEN:
            planned, legs = with_chosen_legs(planned, settings.pod)
        with _without_notices():
            mission = fly(flight, planned, legs=legs)
    if mission.snapshot.outcome is Outcome.FAILED and not mission.steps:
        raise ConfigurationError(f"Missions with --errors {key.errors} do not take off. {mission.snapshot.message}")
    result = judge(key, flight, mission, time.process_time() - begin_s)
    if settings.pod is None:
        return result
    return replace(result, predicted=predicted(planned, flight.persons_enu_m, flight.postures, legs))


def check_flights(settings: MissionsSettings, keys: Iterable[MissionKey]) -> None:
    """Have the simulator refuse what it cannot build before the first mission is flown, by worlds without trees.

    Raises:
        ConfigurationError: there is no such strategy or search mode, no simulator is installed, or it refuses a
            condition, a grade of errors or the terrain.
    """
    settings.check_strategy()
    search_settings(settings.search_mode)
    for conditions, errors in sorted({(key.conditions, key.errors) for key in keys}):
        build_flight(
            FlightParameters(
                seed=0,
                vehicles=1,
                trees_per_ha=0.0,
                has_person=True,
                errors=errors,
                conditions=conditions,
                side_m=settings.side_m,
                image_size_px=settings.image_size_px,
                terrain=settings.terrain,
            )
        )


@contextmanager
def _without_notices() -> Iterator[None]:
    """Keep the notices of simulated missions from the log, unless it is to have everything."""
    log = logging.getLogger("aos_gcs.mission")
    former = log.level
    if not log.isEnabledFor(logging.DEBUG):
        log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(former)


def judge(key: MissionKey, flight: Flight, mission: FlownMission, processor_s: float) -> MissionResult:
    """Return what a mission has come to."""
    snapshot, count = mission.snapshot, len(flight.persons_enu_m)

    def persons_at(after_s: float) -> Sequence[Place]:
        return flight.persons_at((snapshot.started_utc_s or 0.0) + after_s)

    # Persons may walk: what was seen of one is compared with where it was then.
    seen = [(one, one.position_enu_m[:2], persons_at(one.seen_at_s)) for one in snapshot.findings]
    claims = [(place, persons) for one, place, persons in seen if one.is_claimed and one.stands]
    nearest_m = [min((math.dist(place, them[row]) for place, them in claims), default=math.inf) for row in range(count)]
    found = [row for row in range(count) if nearest_m[row] <= HERE_M]
    # What is announced when the search ends is so behind the last step.
    at_last_s = mission.steps[-1].elapsed_s if mission.steps else None
    times_s = [_claimed_after_s(row, persons_at, mission.conclusions) or at_last_s for row in found]
    false_convergences, false_convergence_s = false_approaches(mission.steps, persons_at)
    stated = [
        (one.person_confidence, _nearest_m(place, persons) <= HERE_M)
        for one, place, persons in seen
        if one.merged_into is None and one.person_confidence is not None
    ]
    return MissionResult(
        key=key,
        persons=count,
        claims=len(claims),
        true_claims=sum(_nearest_m(place, persons) <= HERE_M for place, persons in claims),
        persons_found=len(found),
        errors_m=tuple(error_m for error_m in nearest_m if error_m <= HERE_M),
        claimed_after_s=tuple(time_s for time_s in times_s if time_s is not None),
        coverage=snapshot.covered_fraction or 0.0,
        area_ha=abs(signed_area_m2(as_polygon(flight.area_enu_m, "area_enu_m"))) / 1e4,
        false_convergences=false_convergences,
        false_convergence_s=false_convergence_s,
        min_separation_m=flight.min_separation_m,
        landed=flight.landed,
        outcome=str(snapshot.outcome),
        duration_s=snapshot.elapsed_s,
        steps=len(mission.steps),
        processor_s=processor_s,
        min_height_above_ground_m=flight.min_height_above_ground_m,
        probabilities=tuple(probability for probability, _ in stated),
        is_person=tuple(is_person for _, is_person in stated),
        persons_noticed=sum(row in found or _is_looked_at(row, persons_at, mission.steps) for row in range(count)),
    )


def false_approaches(steps: Sequence[StepRecord], persons_at: PersonsAt) -> tuple[int, float]:
    """Return how often a swarm converged on something that is no person, and for how many seconds in all.

    A step of converging counts to the next step. Where its target is out of view, it is that of the step before; one
    farther than 3 m from the one before is another.
    """
    count, cost_s = 0, 0.0
    target_enu_m: Place | None = None
    for step, following in pairwise(steps):
        if step.phase is not Phase.CONVERGE:
            target_enu_m = None
            continue
        place = target_enu_m if step.target_enu_m is None else step.target_enu_m[:2]
        if place is None or _nearest_m(place, persons_at(step.elapsed_s)) <= HERE_M:
            target_enu_m = None
            continue
        count += target_enu_m is None or math.dist(place, target_enu_m) > HERE_M
        cost_s += following.elapsed_s - step.elapsed_s
        target_enu_m = place
    return count, cost_s


def _is_looked_at(row: int, persons_at: PersonsAt, steps: Sequence[StepRecord]) -> bool:
    """Tell whether a close look was at something near a person."""
    looks = ((step, step.target_enu_m) for step in steps if step.phase is Phase.CONVERGE)
    return any(
        target is not None and math.dist(target[:2], persons_at(step.elapsed_s)[row]) <= HERE_M
        for step, target in looks
    )


def _nearest_m(place_enu_m: Place, others_enu_m: Iterable[Place]) -> float:
    return min((math.dist(place_enu_m, other) for other in others_enu_m), default=math.inf)


def _claimed_after_s(row: int, persons_at: PersonsAt, conclusions: Mapping[int, ConclusionRecord]) -> float | None:
    """Return when a target near a person was first taken for a person for good."""
    for _, conclusion in sorted(conclusions.items()):
        for target in conclusion.targets:
            seen_at_s = conclusion.now_s if target.seen_at_s is None else target.seen_at_s
            if target.kind in CLAIMED and math.dist(target.position_enu_m[:2], persons_at(seen_at_s)[row]) <= HERE_M:
                return conclusion.now_s
    return None
