"""Tracks of targets from sightings, and what the latest decisions about each agree on."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.imaging.geolocation import Geolocation, locate_together
from aos_gcs.imaging.model import FocalGrid, StepAnalysis
from aos_gcs.imaging.persons.decision import CLAIMED, DECISION, FORM_TOLD, FindingKind, Verdict, telling
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.mission.model.findings import ErrorEllipse, TargetEstimate
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.pool import Pools, look_at
from aos_gcs.mission.search.targets.same_body import SAME_PLACE_M
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.tracking.tracker import Measurement, Track, Tracks, observe

_WORSE = 1.5
"""Variance, over that of the place known, up to which a later place of a target that stays replaces it."""


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """A sighting that belongs to a track."""

    step: int
    """Counts the steps."""
    position_enu_m: NDArray[np.float64]
    """Shape (3,)."""
    surprise_m: float | None
    """Distance from where the track predicted it; None for the first sighting of a track."""
    is_marked: bool
    """Whether enough frames mark the same cell."""
    verdict: Verdict | None = None
    """Decision after this sighting; None if there was none."""

    @property
    def is_claimable(self) -> bool:
        """Whether it counts for a claim: it has been judged; without temperatures, an anomaly that frames agree on."""
        if self.verdict is None:
            return False
        return self.is_marked if self.verdict.kind is FindingKind.ANOMALY else self.verdict.probability is not None


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Place of a target, with its error and time."""

    position_enu_m: NDArray[np.float64]
    """Shape (3,)."""
    covariance_m2: NDArray[np.float64]
    """Horizontal, shape (2, 2)."""
    seen_at_s: float
    """Mission time at which it was seen there."""


class TargetTracker:
    """Tracks everything that is seen, and reports one target at a time: that of the largest blob not settled yet.

    ``observe`` and then ``judge`` once per step.
    """

    def __init__(self, settings: MissionSettings) -> None:
        self._detection = settings.detection
        self._tracking = settings.tracking
        self._uncertainty = settings.uncertainty
        self._speed_mps = settings.flight.arrival_speed_mps
        self._tracks = Tracks()
        self._seen: dict[int, deque[_Seen]] = {}
        """Latest sightings of each track."""
        self._step = 0
        self._up_m: dict[int, float] = {}
        """Height of the ground at each track."""
        self._judged: dict[int, Judgement] = {}
        """Latest decision about each track, where there is one, with its best place."""
        self._shown: dict[int, Verdict] = {}
        """Verdict on each track that the latest step marks, or at which it shows something warm."""
        self._pools = Pools()
        """Verdicts on each track's body."""
        self._person_places: dict[int, _Place] = {}
        """Place of each track when a step last took it for a person."""
        self._last_places: dict[int, _Place] = {}
        """Place of each track when a step last showed it."""
        self._kinds: dict[int, FindingKind] = {}
        """What each track is taken for, where that is decided for good."""
        self._target: Track | None = None
        self.measured_enu_m: EnuPoint | None = None
        """Position of the target by the latest step alone; None when it is out of view."""
        self.blob_enu_m: EnuPoint | None = None
        """Middle on the focal plane of the blob that showed it last; None while no target is reported."""
        self.steps_out_of_view = 0
        self.sees_targets = False
        """Whether anything large enough for a target was seen in the latest step, also where it is settled."""

    @property
    def target_walks(self) -> bool:
        """Whether the target more likely moves than stays."""
        return self._target is not None and not self._target.stays

    @property
    def looked_at_enu_m(self) -> list[tuple[float, float]]:
        """Places of the target and of the blob that has shown it; none where there is no target."""
        target = self.estimate()
        return [] if target is None else [place[:2] for place in (target.position_enu_m, self.blob_enu_m) if place]

    def observe(self, analysis: StepAnalysis, now_s: float, ground: Terrain | None = None) -> bool:
        """Update the tracks by a step's analysis and return whether a target is in view; settled places have none.

        Targets are on the ground in view, where that is known; else on the focal plane.
        """
        least_m2 = self._detection.threshold_m2
        sightings = [seen for seen in analysis.sightings if seen.suspected or seen.blob.area_m2 >= least_m2]
        lines = [seen.views for seen in sightings]
        places = locate_together(lines, analysis.grid.height_m, self._uncertainty, self._speed_mps, ground)
        self._tracks, track_ids = observe(
            self._tracks,
            [_measurement(place) for place in places],
            now_s,
            self._tracking,
            lambda position_enu_m: _is_covered(analysis.grid, analysis.coverage, position_enu_m),
        )
        self._step += 1
        self._seen = {track.track_id: self._seen.get(track.track_id) or self._none() for track in self._tracks.tracks}
        for sighting, place, track_id in zip(sightings, places, track_ids, strict=True):
            track = self._tracks.find(track_id)
            surprise_m = None if track is None else track.surprise_m
            is_marked = sighting.blob.max_count >= self._detection.found_min_count
            latest = self._seen.setdefault(track_id, self._none())
            latest.append(_Seen(self._step, place.position_enu_m, surprise_m, is_marked))
            self._up_m[track_id] = float(place.position_enu_m[2])
        self.sees_targets = bool(sightings)
        if not sightings or sightings[0].settled:
            self.measured_enu_m = None
            self.steps_out_of_view += 1
            self._target = self._tracks.find(self._target.track_id) or self._target if self._target else None
            return False
        self.measured_enu_m = _point(places[0].position_enu_m)
        self.blob_enu_m = sightings[0].blob.centroid_enu_m
        self.steps_out_of_view = 0
        self._target = self._tracks.find(track_ids[0])
        return True

    def places_enu_m(self) -> dict[int, NDArray[np.float64]]:
        """Return the horizontal place of every track, shape (2,), by its id."""
        return {track.track_id: track.position_enu_m for track in self._tracks.tracks}

    def places_in_view_enu_m(self) -> dict[int, NDArray[np.float64]]:
        """Return the same of the tracks that the latest step shows; those of the others are predicted."""
        return {key: place for key, place in self.places_enu_m().items() if self._in_view(key) is not None}

    def judge(self, judgements: Mapping[int, Judgement]) -> None:
        """Take in what the tracks are taken for after a step, by their ids; without a result the former one stays."""
        before, self._judged, self._shown = self._judged, {}, {}
        self._pools.follow({track.track_id: track.stays for track in self._tracks.tracks})
        self._take_in(judgements, before)
        in_view = [track for track in self._tracks.tracks if self._in_view(track.track_id) is not None]
        self._last_places |= {track.track_id: self._place(track) for track in in_view}

    def _take_in(self, judgements: Mapping[int, Judgement], before: Mapping[int, Judgement]) -> None:
        for track in self._tracks.tracks:
            judgement, former = judgements.get(track.track_id), before.get(track.track_id)
            if judgement is None:
                if former is not None:
                    self._judged[track.track_id] = former
                continue
            is_in_view = self._in_view(track.track_id) is not None
            if is_in_view:
                latest = self._seen[track.track_id]
                latest[-1] = replace(latest[-1], verdict=judgement.verdict)
            # Where nothing warm shows, only a mark tells that something else is there: leaves may hide it.
            if is_in_view or judgement.place is not None:
                self._shown[track.track_id] = judgement.verdict
                self._pools.add(track.track_id, look_at(judgement, track.position_enu_m))
            self._judged[track.track_id] = (
                judgement if former is None or not track.stays else _updated(former, judgement)
            )
            if judgement.verdict.kind is FindingKind.PERSON:
                self._person_places[track.track_id] = self._place(track)

    def latest_verdict(self, track_id: int) -> Verdict | None:
        """Return the decision about a track that the latest step marks, or shows something warm at; else None.

        It is surely no person only where its form by all looks does not say otherwise.
        """
        shown, pool = self._shown.get(track_id), self._pools.get(track_id)
        if shown is None or pool is None:
            return shown
        return replace(shown, is_surely_other=pool.verdict.is_surely_other)

    def likely_persons(self) -> frozenset[int]:
        """Return the tracks in view that are taken for a person by their latest sightings, and not decided for good."""
        return frozenset(
            track_id
            for track_id in self._seen
            if track_id not in self._kinds
            and self._in_view(track_id) is not None
            and (verdict := self.verdict(track_id)) is not None
            and (verdict.probability or 0.0) >= DECISION
        )

    def attend(self, track_id: int) -> None:
        """Report this target from now on."""
        self._target = self._tracks.find(track_id) or self._target

    def settle(self, track_id: int, kind: FindingKind) -> None:
        """Note what a track is taken for, for good."""
        self._kinds[track_id] = kind

    def verdict(self, track_id: int) -> Verdict | None:
        """Return what the latest sightings of a track are taken for together; None if none has been judged."""
        if (pool := self._pools.get(track_id)) is not None:
            return pool.verdict
        judgement = self._judged.get(track_id)
        return None if judgement is None else judgement.verdict

    def give_up(self) -> None:
        """Report no target until one is in view again."""
        self._target = self.blob_enu_m = None

    def estimate(self) -> TargetEstimate | None:
        """Return the target in view, or else the one seen last."""
        return None if self._target is None else self._describe(self._target)

    def estimates(self) -> tuple[TargetEstimate, ...]:
        """Return all confirmed targets, and the one that :meth:`estimate` returns."""
        shown = [track for track in self._tracks.tracks if track.confirmed or self._is_target(track)]
        if self._target is not None and not any(map(self._is_target, shown)):
            shown.append(self._target)
        return tuple(map(self._describe, shown))

    def agrees(self, track_id: int) -> bool:
        """Return whether the latest sightings of a track agree: together they are of a person, all in one place.

        They agree on one place when they lie about their mean, or on one path when each lies where the track predicted
        it. A warm body that stays may show between them, too. A person needs as many looks that count as evidence, and
        to be so sure that no more of them are awaited.
        Without temperatures each must be an anomaly, and none of the steps between may lack one.
        """
        latest, verdict = list(self._seen.get(track_id, ())), self.verdict(track_id)
        if verdict is not None and verdict.kind is FindingKind.PERSON:
            if not verdict.is_sure or not self._is_looked_at_enough(track_id):
                return False
            if self._stays_warm(track_id):
                return True
        if len(latest) < self._detection.found_steps or not all(seen.is_claimable for seen in latest):
            return False
        if self._in_view(track_id) is None or verdict is None or verdict.kind not in CLAIMED:
            return False
        if verdict.kind is FindingKind.ANOMALY and latest[-1].step - latest[0].step >= len(latest):
            return False
        surprises_m = [math.inf if seen.surprise_m is None else seen.surprise_m for seen in latest]
        spread_m = _spread_m([seen.position_enu_m for seen in latest])
        return min(spread_m, max(surprises_m)) <= self._detection.found_radius_m

    def _is_looked_at_enough(self, track_id: int) -> bool:
        """Return whether enough looks tell what a track is, and enough vantage points its form, once one shows it."""
        if (pool := self._pools.get(track_id)) is None:
            return False
        is_form_told = not pool.form_sums.sums or (pool.form is not None and pool.form.vantage_points >= FORM_TOLD)
        return is_form_told and len(telling(pool.verdicts)) >= self._detection.found_steps

    def _stays_warm(self, track_id: int) -> bool:
        """Return whether something warm shows in one place, often enough."""
        pool, steps = self._pools.get(track_id), self._detection.found_steps
        places_enu_m = () if pool is None else pool.warm_enu_m[-steps:]
        return len(places_enu_m) == steps and _spread_m(places_enu_m) <= self._detection.found_radius_m

    def _none(self) -> deque[_Seen]:
        return deque(maxlen=self._detection.found_steps)

    def _in_view(self, track_id: int) -> _Seen | None:
        """Return the latest step's sighting of a track; None if it shows none."""
        latest = self._seen.get(track_id)
        return latest[-1] if latest and latest[-1].step == self._step else None

    def _is_target(self, track: Track) -> bool:
        return self._target is not None and track.track_id == self._target.track_id

    def _describe(self, track: Track) -> TargetEstimate:
        place = self._place(track)
        verdict = self.verdict(track.track_id)
        east_mps, north_mps = track.velocity_enu_mps
        return TargetEstimate(
            position_enu_m=_point(place.position_enu_m),
            sigma_m=math.sqrt(float(np.trace(place.covariance_m2)) / 2.0),
            sightings=track.hits,
            track_id=track.track_id,
            confirmed=track.confirmed,
            ellipse=error_ellipse(place.covariance_m2),
            velocity_enu_mps=(float(east_mps), float(north_mps)),
            seen_at_s=place.seen_at_s,
            person_confidence=None if verdict is None else verdict.probability,
            kind=self._kinds.get(track.track_id, FindingKind.UNDECIDED),
            reasons=() if verdict is None else verdict.reasons,
        )

    def _place(self, track: Track) -> _Place:
        """Return where a target is: where its warm body is, if it has one.

        An announced person stays where it was last taken for one, when its track goes on to something else. A walking
        target that is out of view is given where it was last seen: where its track goes on to, nobody has seen it.
        """
        judgement, known = self._judged.get(track.track_id), self._person_places.get(track.track_id)
        if judgement is not None and known is not None and self._kinds.get(track.track_id) is FindingKind.PERSON:
            verdict = judgement.verdict
            is_other = verdict.probability is not None and verdict.kind is not FindingKind.PERSON
            if is_other or (track.stays and _is_elsewhere(judgement.place, known.position_enu_m)):
                return known
        if judgement is not None and judgement.place is not None and track.stays:
            return _Place(judgement.place.position_enu_m, judgement.place.covariance_m2[:2, :2], track.seen_at_s)
        if self._in_view(track.track_id) is None and track.track_id in self._last_places:
            return self._last_places[track.track_id]
        position_enu_m = np.array([*track.position_enu_m, self._up_m[track.track_id]])
        return _Place(position_enu_m, track.covariance_m2, track.seen_at_s)


def _spread_m(positions_enu_m: Sequence[NDArray[np.float64]]) -> float:
    """Return the greatest distance of positions from their mean."""
    positions = np.array(positions_enu_m)
    return float(np.linalg.norm(positions - positions.mean(axis=0), axis=1).max())


def _updated(former: Judgement, latest: Judgement) -> Judgement:
    """Return the latest decision about a target that stays, with the former place where that is better known.

    A place far from the former one is that of another body, which the track has gone on to.
    """
    if former.place is None:
        return latest
    if latest.place is not None:
        is_better = _variance_m2(latest.place) <= _WORSE * _variance_m2(former.place)
        if is_better or _is_elsewhere(latest.place, former.place.position_enu_m):
            return latest
    return replace(latest, place=former.place)


def _is_elsewhere(place: Geolocation | None, known_enu_m: NDArray[np.float64]) -> bool:
    """Return whether a warm body is not where one is known to be, shape (3,), and so another one."""
    return place is not None and float(np.linalg.norm(place.position_enu_m[:2] - known_enu_m[:2])) > SAME_PLACE_M


def _variance_m2(place: Geolocation) -> float:
    return float(np.trace(place.covariance_m2[:2, :2]))


def error_ellipse(covariance_m2: NDArray[np.float64]) -> ErrorEllipse:
    """Return the ellipse of one standard deviation of a horizontal position with this covariance, shape (2, 2)."""
    (minor_m2, major_m2), axes = np.linalg.eigh(covariance_m2)
    east, north = axes[:, 1]
    return ErrorEllipse(
        semi_major_m=math.sqrt(max(major_m2, 0.0)),
        semi_minor_m=math.sqrt(max(minor_m2, 0.0)),
        heading_rad=math.atan2(east, north) % math.pi,
    )


def _measurement(place: Geolocation) -> Measurement:
    return Measurement(place.position_enu_m[:2], place.random_m2[:2, :2], place.systematic_m2[:2, :2])


def _is_covered(grid: FocalGrid, coverage: NDArray[np.uint16], position_enu_m: NDArray[np.float64]) -> bool:
    row = math.floor((grid.north_m - position_enu_m[1]) / grid.resolution_m)
    column = math.floor((position_enu_m[0] - grid.west_m) / grid.resolution_m)
    return 0 <= row < grid.rows and 0 <= column < grid.columns and bool(coverage[row, column])


def _point(position_enu_m: NDArray[np.float64] | list[float]) -> EnuPoint:
    east_m, north_m, up_m = (float(value) for value in position_enu_m)
    return east_m, north_m, up_m
