"""Choice between a close look and the scan: what finds a person sooner, by the expected gain per second.

A look at what is a person with the probability p takes about T_L seconds, and the way back to the leg T_R. Meanwhile
the scan of the legs, which takes T_S in all and notices a person with the probability P, would find the person with the
density P / T_S, if what is in view is not the person. The look comes first where

    p / (T_L + T_R) >= (1 - p) P / T_S;

otherwise the line flies on, and what it sees of the place on its way counts: it may show a person after all. That it
is none is not concluded from frames in flight. What is left is looked at behind the last leg, the greatest gain per
second first.

Buffered: yes, the places that are left for later, one for each thing that was seen; each is looked at, or rejected.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.imaging.persons.decision import Verdict
from aos_gcs.imaging.step.judgement import SETTLED_BY_FEW_M, SETTLED_M
from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.model.decisions import LeftPlace
from aos_gcs.mission.search.scan.progress import ScanProgress
from aos_gcs.mission.search.targets.tracker import TargetTracker
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import LookOrder, SearchMode
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity

LOOK_S: Final = 25.0
"""Time of a close look: six steps of four seconds."""
RETURN_S: Final = 10.0
"""Time to stop for it, and to form the line on the leg again."""
TURN_S: Final = 10.0
"""Time from the end of a leg to the line on the next one."""
UNTOLD: Final = 0.2
"""Probability that something is a person that nothing tells about yet: as many bodies are persons."""
USUAL_POD: Final = 0.9
"""Probability with which a scan notices a person, where none is wanted."""
_LEG_M: Final = 4.0
"""Length of the leg on which a place is looked at later, from one side of it to the other: two stops."""
_ASIDE_M: Final = 10.0
"""Distance up to which vehicles look at a place from the side, where the geofence keeps them from flying over it."""

Place = tuple[float, float]


@dataclass(slots=True, eq=False)
class _Later:
    """A place that is left for later."""

    place_enu_m: Place
    probability: float
    is_judged: bool = False
    track_id: int | None = None
    """Track that has shown it last."""
    is_told: bool = False
    leads: bool = False
    """Whether it is worth a look now, and leads the swarm where the next step shows it."""

    @property
    def text(self) -> str:
        """The place in words."""
        return f"{self.place_enu_m[0]:.1f} m east, {self.place_enu_m[1]:.1f} m north"


class LookChoice:
    """Leaves what is in view for later, where the scan is expected to find a person sooner.

    Args:
        settings: settings of the mission.
        journal: told what is left for later.
        progress: legs of the scan.
        left_for_later: places that the former sortie has left for later, or the station before, where its flight was
            taken up.
    """

    def __init__(
        self,
        settings: MissionSettings,
        journal: Announcer,
        progress: ScanProgress,
        left_for_later: Sequence[LeftPlace] = (),
    ) -> None:
        self._settings = settings
        self._journal = journal
        self._progress = progress
        self.taken_up = tuple(left_for_later)
        """Places that had been left for later before."""
        self._later = [_Later(one.place_enu_m, one.probability, is_judged=True) for one in self.taken_up]
        self._look_legs: set[int] = set()
        """Indices of the legs that are flown for a look."""

    @property
    def is_look_leg(self) -> bool:
        """Whether the present leg is flown for a look."""
        return self._progress.leg in self._look_legs

    @property
    def later_enu_m(self) -> tuple[Place, ...]:
        """Places that are left for later: they lead nobody on the legs, where looks may come later."""
        return () if not self._is_choosing else tuple(one.place_enu_m for one in self._later if not one.leads)

    @property
    def left_for_later(self) -> tuple[LeftPlace, ...]:
        """Places that are left for later, in the order in which they came into view."""
        return tuple(LeftPlace(one.place_enu_m, one.probability) for one in self._later)

    def leaves(self, place_enu_m: Place, verdict: Verdict | None, vehicles: int) -> bool:
        """Tell whether what is in view is left for later, and note it.

        Args:
            place_enu_m: where it is.
            verdict: what it is taken for so far; None: it has not been judged yet, which takes one more step.
            vehicles: number of vehicles of the swarm.
        """
        if not self._is_choosing:
            return False
        probability = _probability(verdict)
        known = self._at(place_enu_m)
        if verdict is not None and self._is_worth_it(probability, vehicles):
            self._later = [one for one in self._later if one is not known]
            return False
        if known is None:
            self._later.append(_Later(place_enu_m, probability))
        return True

    def review(
        self, tracker: TargetTracker, looked_at_enu_m: Sequence[Place], vehicles: int, *, is_free: bool
    ) -> int | None:
        """Take in what a step has shown of the places.

        Args:
            tracker: tracks, with the latest decisions about them.
            looked_at_enu_m: places that have been looked at, or are surely no person.
            vehicles: number of vehicles of the swarm.
            is_free: whether the swarm is on its legs, and may look at something.

        Returns:
            Track that is worth a look now and was to lead this step, which does not show it any more; it is not left
            for later. None where none is.
        """
        leading = [one for one in self._later if one.leads]
        shown = self._take_in(tracker)
        self._drop(looked_at_enu_m)
        for one in self._later:
            one.leads = one in shown and self._is_choosing and self._is_worth_it(one.probability, vehicles)
        self._tell_later()
        known_ids = tracker.places_enu_m().keys()
        missed = [one for one in leading if one in self._later and one not in shown and one.track_id in known_ids]
        if not (missed and is_free and self._is_choosing):
            return None
        best = max(missed, key=lambda one: one.probability)
        self._later.remove(best)
        return best.track_id

    def _take_in(self, tracker: TargetTracker) -> list[_Later]:
        """Return the places that the step has shown, with what they are taken for now."""
        shown: list[_Later] = []
        for track_id, (east_m, north_m) in tracker.places_in_view_enu_m().items():
            place_enu_m, verdict = (float(east_m), float(north_m)), tracker.verdict(track_id)
            if (one := self._at(place_enu_m)) is None or verdict is None:
                continue
            probability = _probability(verdict)
            # A person beside something else counts, not what is beside the person.
            if one in shown and probability < one.probability:
                continue
            one.place_enu_m, one.probability, one.track_id = place_enu_m, probability, track_id
            one.is_judged = True
            if one not in shown:
                shown.append(one)
        return shown

    def _tell_later(self) -> None:
        """Tell what is left for later, once each, when it has been judged."""
        for one in self._later:
            if one.is_judged and not (one.leads or one.is_told):
                one.is_told = True
                self._journal.notice(
                    Severity.INFO,
                    f"Left for later: {one.text} ({100 * one.probability:.0f} % a person). Scanning on is expected to "
                    "find a person sooner",
                )

    def next_leg(self, looked_at_enu_m: Sequence[Place], limits: SafetyLimits | None) -> ScanLeg | None:
        """Return a leg over the place whose look gains most, to be flown behind all others; None where none is left.

        Args:
            looked_at_enu_m: places that have been looked at, or are surely no person.
            limits: limits of the flight; None before its first step.
        """
        self._drop(looked_at_enu_m)
        if not (within := [one for one in self._later if _is_in_reach(one, limits)]):
            return None
        speed_mps, from_enu_m = self._settings.flight.cruise_speed_mps, self._progress.here_enu_m

        def gain(one: _Later) -> float:
            return one.probability / (LOOK_S + RETURN_S + math.dist(one.place_enu_m, from_enu_m) / speed_mps)

        best = max(within, key=gain)
        self._later.remove(best)
        self._look_legs.add(len(self._progress.legs))
        east, north = self._settings.scan_direction_enu
        east_m, north_m = best.place_enu_m
        self._journal.notice(Severity.INFO, f"Close look started (left for later before): {best.text}")
        return ScanLeg((east_m - east * _LEG_M / 2.0, north_m - north * _LEG_M / 2.0), (east, north), _LEG_M)

    def tell_left(self, looked_at_enu_m: Sequence[Place], limits: SafetyLimits | None) -> None:
        """Tell operators the places that the search ends without a look at; the arguments are those of the next leg."""
        self._drop(looked_at_enu_m)
        if self._later:
            places = "; ".join(_in_words(one, limits) for one in self._later)
            self._journal.notice(Severity.WARNING, f"Not examined (left for later): {places}")

    def _drop(self, looked_at_enu_m: Sequence[Place]) -> None:
        self._later = [one for one in self._later if not _is_within(one, looked_at_enu_m)]

    @property
    def _is_choosing(self) -> bool:
        search = self._settings.search
        return search.looks is LookOrder.GAIN and search.mode is SearchMode.CONTINUOUS and not self.is_look_leg

    def _is_worth_it(self, probability: float, vehicles: int) -> bool:
        flight, search = self._settings.flight, self._settings.search
        legs = self._progress.planned_legs
        scan_s = sum(leg.length_m for leg in legs) / flight.leg_speed_mps + TURN_S * len(legs)
        fewest = search.fewest_to_split
        # Where some look and the others scan on, the scan loses their share alone.
        share = 1.0 if fewest is None or vehicles < fewest else search.look_vehicles / vehicles
        scan_hz = share * (search.pod or USUAL_POD) / scan_s
        return probability / (LOOK_S + RETURN_S) >= (1.0 - probability) * scan_hz

    def _at(self, place_enu_m: Place) -> _Later | None:
        near = (one for one in self._later if math.dist(one.place_enu_m, place_enu_m) <= SETTLED_BY_FEW_M)
        return min(near, key=lambda one: math.dist(one.place_enu_m, place_enu_m), default=None)


def _probability(verdict: Verdict | None) -> float:
    """Return how likely something is a person; what is no evidence, as frames in flight often, tells nothing."""
    if verdict is None or verdict.probability is None or not verdict.is_evidence:
        return UNTOLD
    return verdict.probability


def _is_within(one: _Later, others_enu_m: Sequence[Place]) -> bool:
    return any(math.dist(one.place_enu_m, other) <= SETTLED_M for other in others_enu_m)


def _in_words(one: _Later, limits: SafetyLimits | None) -> str:
    return one.text if _is_in_reach(one, limits) else f"{one.text} (the geofence keeps vehicles away)"


def _is_in_reach(one: _Later, limits: SafetyLimits | None) -> bool:
    """Tell whether the geofence allows a look at a place: that of a former sortie may have been another one."""
    if limits is None:
        return True
    fence, *_ = limits.boundaries()
    return fence.depth_m(np.array(one.place_enu_m)) > fence.margin_m - _ASIDE_M
