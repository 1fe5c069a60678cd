"""A split swarm: which vehicles look closely, what the others do meanwhile, and where the line forms afterwards."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.imaging.model import StepAnalysis
from aos_gcs.imaging.step.judgement import SETTLED_BY_FEW_M
from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.model.decisions import Situation
from aos_gcs.mission.search.scan.progress import Advance, ScanProgress
from aos_gcs.mission.search.scan.sweep import Sweep, Vet
from aos_gcs.planning.legs import leg_formation
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity

WIDEST_SHARE = 0.9
"""Greatest distance of neighbours in the line of the scanning group, over the footprint of the lowest layer."""

Place = tuple[float, float]
"""East and north."""


class Split:
    """A swarm of which some vehicles look closely while the others scan on along the leg; made by :func:`begin_split`.

    Args:
        look_ids: vehicles that look.
        leg: index of the leg that the others scan.
        began_m: place on it where it was left.
        spacing_m: distance of neighbours in the line of the others.
        sweep: moves that line along the leg.
        threshold_m2: visible area from which something is in view.
        journal: told why the others stop.
    """

    def __init__(
        self,
        look_ids: frozenset[int],
        *,
        leg: int,
        began_m: float,
        spacing_m: float,
        sweep: Sweep,
        threshold_m2: float,
        journal: Announcer,
    ) -> None:
        self.look_ids = look_ids
        self.leg = leg
        self.began_m = began_m
        self.spacing_m = spacing_m
        self._sweep = sweep
        self._threshold_m2 = threshold_m2
        self._journal = journal
        self.passed_enu_m: tuple[Place, ...] = ()
        """Places that do not stop the scanning group: settled ones, and what is looked at."""
        self._others_enu_m: tuple[Place, ...] = ()
        """What else is in view of the vehicles that look closely."""
        self.is_over = False
        """Whether the others scan no more."""
        self.is_at_end = False
        """Whether they have scanned the leg to its end."""
        self.is_catching_up = False
        """Whether the look is over, and its vehicles fly after the others, which scan on until then."""

    def looking(self, situation: Situation) -> Situation:
        """Return a situation with the vehicles that look closely as its swarm."""
        return replace(situation, swarm=tuple(one for one in situation.swarm if one.vehicle_id in self.look_ids))

    def look_on(self, *, is_last: bool) -> None:
        """Note that another person was announced in the step that seemed to end the look.

        Args:
            is_last: whether the search ends with this person, so that no vehicle scans on.
        """
        self.is_catching_up = False
        self.is_over |= is_last

    def end_look(self) -> None:
        """Note that the look is over: its vehicles fly after the others, where these still scan."""
        self.is_catching_up = not self.is_over

    def end_behind(self) -> None:
        """Note that the leg is flown again from where it was left: the others wait, wherever they have got to."""
        self.is_over, self.is_at_end = True, False

    def note_look(
        self, analysis: StepAnalysis, looked_at_enu_m: Sequence[Place], settled_enu_m: Sequence[Place]
    ) -> None:
        """Take in what a step of the look shows.

        Args:
            analysis: its analysis.
            looked_at_enu_m: the target, and the blob that shows it.
            settled_enu_m: places that lead no vehicle any more.
        """
        self.passed_enu_m = tuple(dict.fromkeys((*settled_enu_m, *self.passed_enu_m, *looked_at_enu_m)))
        self._others_enu_m = tuple(place for place in self._in_view(analysis) if not _is_at(place, looked_at_enu_m))

    def leaves_something(self, settled_enu_m: Sequence[Place]) -> bool:
        """Return whether the vehicles that look closely see something that is not settled."""
        return any(not _is_at(place, settled_enu_m) for place in self._others_enu_m)

    def scan_on(
        self, progress: ScanProgress, situation: Situation, analysis: StepAnalysis, vet: Vet
    ) -> tuple[WaypointRecord, ...]:
        """Return the waypoints, with their speeds, of the scanning group; none where it is to stop and wait.

        Args:
            progress: legs of the scan, and the place reached; moved on.
            situation: state of the flight, with the scanning group as its swarm.
            analysis: analysis of their frames.
            vet: checks places in this situation.
        """
        if self.is_over:
            return ()
        waypoints: tuple[WaypointRecord, ...] = ()
        if not (reason := self._why_stop(progress, situation, analysis)):
            waypoints = self._sweep.fly_on(progress.present_leg, progress.along_m, situation, vet)
            reason = "" if waypoints else "the line cannot sweep on"
        if reason:
            self.is_over = True
            self._journal.notice(Severity.INFO, f"The vehicles that scan on stop and wait for the close look: {reason}")
        return waypoints

    def _why_stop(self, progress: ScanProgress, situation: Situation, analysis: StepAnalysis) -> str:
        if seen := self._in_view(analysis):
            east_m, north_m = seen[0]
            return f"something is in view at {east_m:.1f} m east, {north_m:.1f} m north"
        if not self._sweep.is_under_way:
            return ""
        along_m = self._sweep.exposed_at_m(progress.present_leg, situation, analysis.vehicle_ids)
        advance = progress.advance_in_flight(along_m, self._sweep.longest_gap_m)
        self.is_at_end = advance is Advance.END_OF_LEG
        if advance is Advance.GAP:
            return f"no frames from {progress.along_m:.0f} to {along_m:.0f} m of the leg"
        return "they are at the end of the leg" if self.is_at_end else ""

    def _in_view(self, analysis: StepAnalysis) -> tuple[Place, ...]:
        return tuple(
            seen.blob.centroid_enu_m[:2]
            for seen in analysis.sightings
            if (seen.suspected or seen.blob.area_m2 >= self._threshold_m2) and not seen.settled
        )


def begin_split(
    settings: MissionSettings,
    situation: Situation,
    target_enu_m: EnuPoint | None,
    leader_id: int | None,
    *,
    line_m: float,
    progress: ScanProgress,
    journal: Announcer,
) -> Split | None:
    """Return the split with which a close look begins; None where all vehicles look.

    The vehicles nearest to the target look closely, the leader among them; of equally near ones the lower ids.

    Args:
        settings: settings of the mission.
        situation: state of the flight.
        target_enu_m: what is in view.
        leader_id: vehicle that sees most of it.
        line_m: distance of neighbours in the line of all.
        progress: the leg, and the place reached.
        journal: told why no vehicle scans on, and why the scanning group stops.
    """
    fewest, looking, swarm = settings.search.fewest_to_split, settings.search.look_vehicles, situation.swarm
    if fewest is None or len(swarm) < fewest or target_enu_m is None:
        return None
    spacing_m = (len(swarm) - 1) * line_m / (len(swarm) - looking - 1)
    layers_m = [one.layer_height_m for one in swarm if one.layer_height_m is not None]
    lowest_m = min(layers_m, default=settings.flight.lowest_layer_m) - settings.imaging.plane_height_m
    footprint_m = 2.0 * lowest_m * math.tan(settings.planning_fov_rad / 2.0)
    if spacing_m > WIDEST_SHARE * footprint_m:
        text = f"All vehicles look closely: the others would be {spacing_m:.0f} m apart in the line, too far to see all"
        journal.notice(Severity.INFO, text)
        return None
    by_distance = sorted(
        swarm,
        key=lambda one: (
            one.vehicle_id != leader_id,
            math.dist(one.position_enu_m[:2], target_enu_m[:2]),
            one.vehicle_id,
        ),
    )
    look_ids = frozenset(one.vehicle_id for one in by_distance[:looking])
    named = ", ".join(map(str, sorted(look_ids)))
    text = f"Vehicles {named} look closely, the other {len(swarm) - looking} scan on"
    journal.notice(Severity.INFO, text)
    return Split(
        look_ids,
        leg=progress.leg,
        began_m=progress.along_m,
        spacing_m=spacing_m,
        sweep=Sweep(settings.flight, settings.imaging.rate_hz, spacing_m, journal),
        threshold_m2=settings.detection.threshold_m2,
        journal=journal,
    )


def places_of_both(
    split: Split, progress: ScanProgress, situation: Situation, looking_enu_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the places with which a split begins, shape (n, 2): those of the look, and the line of the others.

    Args:
        split: vehicles that look closely.
        progress: the leg, and the place reached.
        situation: state of the flight; its swarm gives the order of the rows.
        looking_enu_m: places of the vehicles that look closely, in that order, shape (k, 2).
    """
    looks = np.array([one.vehicle_id in split.look_ids for one in situation.swarm])
    here_enu_m = situation.positions_enu_m[:, :2]
    places_enu_m = np.empty_like(here_enu_m)
    places_enu_m[looks] = looking_enu_m
    places_enu_m[~looks] = leg_formation(progress.remaining_leg, here_enu_m[~looks], split.spacing_m)
    return places_enu_m


def _is_at(place_enu_m: Place, others_enu_m: Sequence[Place]) -> bool:
    return any(math.dist(place_enu_m, other) <= SETTLED_BY_FEW_M for other in others_enu_m)
