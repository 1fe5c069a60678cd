"""Claims: when a target is announced as a possible person, and when it is left as something else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from collections.abc import Set as AbstractSet

from aos_gcs.imaging.persons.decision import AT_LAST, CLAIMED, SURELY_OTHER, FindingKind
from aos_gcs.imaging.step.judgement import SETTLED_BY_FEW_M, SETTLED_M
from aos_gcs.mission.journal import Announcer
from aos_gcs.mission.model.findings import KIND_NAMES, Finding, FindingStatus, TargetEstimate
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.looks import Looks
from aos_gcs.mission.search.targets.persons import SUSPICION
from aos_gcs.mission.search.targets.same_body import PIECES_M, distance_m
from aos_gcs.mission.search.targets.tracker import TargetTracker
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.ports import Severity

SURE_SIGHTINGS = 3
"""Sightings in a row that are surely no person, after which a target is left. Each rests on the frames of up to three
steps; a thorough one is worth as many."""
_OTHERS = frozenset(FindingKind) - CLAIMED - {FindingKind.UNDECIDED}
"""Kinds of what is decided to be no person."""


class Claims:
    """Announces possible persons, and settles what has been looked at. Operators' verdicts overrule it.

    Args:
        detection: settings of the mission.
        journal: told what is announced.
        tracker: tracks, with the latest decisions about them.
        findings: findings of the mission, with operators' verdicts.
    """

    def __init__(
        self, detection: DetectionSettings, journal: Announcer, tracker: TargetTracker, findings: Findings
    ) -> None:
        self._detection = detection
        self._journal = journal
        self._tracker = tracker
        self._findings = findings
        self._looks = Looks()
        self._surely_other: frozenset[int] = frozenset()
        """Tracks that have been seen often enough to be surely no person."""
        self._doubted: set[int] = set()
        """Announced tracks that operators have been told to be unlikely persons by later looks."""
        self.first_at_s: float | None = None
        """Mission time of the first claim; None before it."""

    @property
    def settled_enu_m(self) -> tuple[tuple[float, float], ...]:
        """Places that the swarm does not converge on again: looked at, or judged by operators."""
        settled_enu_m = self.looked_at_enu_m
        return (*settled_enu_m, *self._rivals_enu_m(settled_enu_m))

    @property
    def looked_at_enu_m(self) -> tuple[tuple[float, float], ...]:
        """Places that need no look any more: looked at, surely no person, or judged by operators."""
        target = self._tracker.estimate()
        judged = [
            finding.position_enu_m[:2]
            for finding in self._findings.all()
            if finding.status is FindingStatus.REJECTED
            or (
                finding.status is FindingStatus.CONFIRMED
                and finding.merged_into is None
                and (target is None or finding is not self._findings.at(target, FindingStatus.CONFIRMED))
            )
        ]
        return (*self._looks.settled_enu_m, *judged)

    def _rivals_enu_m(self, settled_enu_m: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        """Return the places of what is no person while something in view may be one.

        The swarm gathers above the largest blob; without this it would leave a person for a larger animal beside it.
        """
        places_enu_m = {key: (float(place[0]), float(place[1])) for key, place in self._tracker.places_enu_m().items()}
        likely = self._tracker.likely_persons()
        persons_enu_m = [
            place
            for key, place in places_enu_m.items()
            if key in likely and not _is_within(place, settled_enu_m, SETTLED_M)
        ]
        if not persons_enu_m:
            return []
        return [
            place
            for key, place in places_enu_m.items()
            if key not in likely and not _is_within(place, persons_enu_m, 2.0 * SETTLED_M)
        ]

    def follow(self) -> None:
        """Move the places with their tracks, after each step's observation."""
        self._looks.follow(self._tracker.places_in_view_enu_m())

    def announce(self, later_enu_m: Sequence[tuple[float, float]] = (), *, in_flight: bool = False) -> int | None:
        """Announce all targets that the latest decisions agree to be persons; return the track to be watched, if any.

        A target known already is watched again when it is the present one, without another announcement.

        Args:
            later_enu_m: places that are left for a later look, and not settled before it.
            in_flight: whether the frames were taken in flight, which tell nobody to be no person.
        """
        present = self._tracker.estimate()
        self._surely_other = frozenset() if in_flight else self._count_others(later_enu_m)
        watched: int | None = None
        for target in self._tracker.estimates():
            is_present = present is not None and target.track_id == present.track_id
            if not self._is_person(target, is_present=is_present):
                continue
            if self._is_new(target):
                self._claim(target)
            elif not is_present:
                continue
            if watched is None or is_present:
                watched = target.track_id
        kept = {watched} if present is None else {watched, present.track_id}
        targets = self._tracker.estimates()
        kept_enu_m = [target.position_enu_m[:2] for target in targets if target.track_id in kept]
        for target in targets:
            # What lies beside a person who is watched may be a piece of it: settled, it would hide the person.
            if _is_within(target.position_enu_m[:2], kept_enu_m, SETTLED_BY_FEW_M):
                continue
            if target.track_id in self._surely_other:
                self._decide(target)
                self._looks.settle(target.track_id, target.position_enu_m)
            elif target.kind in CLAIMED:
                self._looks.settle(target.track_id, target.position_enu_m)
        self._settle_unconfirmed({target.track_id for target in targets}, kept_enu_m)
        for target in targets:
            self._doubt(target)
        return watched

    def _doubt(self, target: TargetEstimate) -> None:
        """Tell operators once that an announced target is unlikely to be a person, by more looks: they decide."""
        confidence = target.person_confidence
        is_doubtful = target.kind is FindingKind.PERSON and confidence is not None and confidence < SUSPICION
        if not is_doubtful or target.track_id in self._doubted:
            return
        if not any(self._findings.at(target, status) for status in (FindingStatus.CONFIRMED, FindingStatus.REJECTED)):
            self._doubted.add(target.track_id)
            text = f"{describe(target, target.kind)}. More looks make a person unlikely: judge it in Decide"
            self._journal.notice(Severity.NEWS, text, track_id=target.track_id)

    def _settle_unconfirmed(self, target_ids: AbstractSet[int], kept_enu_m: Sequence[tuple[float, float]]) -> None:
        """Settle the places of what is surely no person, though it was marked too seldom to be a target."""
        for track_id, (east_m, north_m) in self._tracker.places_enu_m().items():
            place = float(east_m), float(north_m), 0.0
            if track_id not in self._surely_other or track_id in target_ids:
                continue
            if not _is_within(place[:2], kept_enu_m, SETTLED_BY_FEW_M):
                self._looks.settle(track_id, place)

    def is_look_over(self) -> bool:
        """Count a step of converging on the present target; return whether it has been looked at for long enough.

        What is surely no person has been.
        """
        target = self._tracker.estimate()
        if target is None or self._findings.at(target, FindingStatus.REJECTED):
            return True
        steps = self._looks.count(target.track_id, target.position_enu_m)
        return steps >= self._detection.look_steps or target.track_id in self._surely_other

    def _count_others(self, later_enu_m: Sequence[tuple[float, float]]) -> frozenset[int]:
        """Count the latest step's sightings that are surely no person; return the tracks with enough of them.

        They do not count for what is left for later: its look begins anew.
        """
        others: set[int] = set()
        for track_id, (east_m, north_m) in self._tracker.places_enu_m().items():
            if (verdict := self._tracker.latest_verdict(track_id)) is None:
                continue
            place = float(east_m), float(north_m), 0.0
            worth = SURE_SIGHTINGS if verdict.is_thorough else 1
            is_left = _is_within(place[:2], later_enu_m, SETTLED_BY_FEW_M)
            count = self._looks.count_other(
                track_id,
                place,
                is_surely_other=verdict.is_surely_other and not is_left,
                may_be_person=is_left or verdict.probability is None or verdict.probability > SURELY_OTHER,
                worth=worth,
            )
            if count >= SURE_SIGHTINGS:
                others.add(track_id)
        return frozenset(others)

    def may_be_another_person(self) -> bool:
        """Whether the present target is not decided yet, and may be a person by what was seen of it so far."""
        target = self._tracker.estimate()
        if target is None or target.kind is not FindingKind.UNDECIDED:
            return False
        verdict = self._tracker.verdict(target.track_id)
        return verdict is None or verdict.probability is None or verdict.probability >= SUSPICION

    def is_worth_a_search(self) -> bool:
        """Whether the present target, which is out of view, may be a person by what most vehicles saw of it last."""
        target = self._tracker.estimate()
        verdict = None if target is None else self._tracker.verdict(target.track_id)
        return verdict is None or not verdict.is_surely_other

    def is_rejected(self) -> bool:
        """Whether operators have rejected the present target."""
        target = self._tracker.estimate()
        return target is not None and self._findings.at(target, FindingStatus.REJECTED) is not None

    def settle_target(self) -> None:
        """Leave the present target for good; one that is not decided yet is decided by what was seen of it last."""
        target = self._tracker.estimate()
        if target is None:
            return
        self._decide(target)
        self._looks.settle(target.track_id, target.position_enu_m)
        if self._tracker.blob_enu_m is not None:
            self._looks.leave(self._tracker.blob_enu_m)

    def conclude_cut_short(self) -> None:
        """Announce a target whose look ends too early, if it was a person when last seen; others get another look."""
        target = self._tracker.estimate()
        verdict = None if target is None else self._tracker.verdict(target.track_id)
        if target is not None and verdict is not None and verdict.kind is FindingKind.PERSON:
            self._decide(target)

    def announce_at_last(self) -> None:
        """Announce what the search ends without deciding, where it was looked at and is not unlikely to be a person."""
        for finding in self._findings.all():
            place = finding.position_enu_m[:2]
            persons_enu_m = [person.position_enu_m[:2] for person in self._findings.persons()]
            is_open = finding.status is FindingStatus.NEW and not finding.is_claimed and finding.merged_into is None
            is_likely = (finding.person_confidence or 0.0) >= AT_LAST and not finding.found_in
            is_looked_at = _is_within(place, self._looks.settled_enu_m, SETTLED_M)
            if not (is_open and is_likely and is_looked_at) or _is_within(place, persons_enu_m, SETTLED_BY_FEW_M):
                continue
            self._findings.announce(finding.finding_id)
            if finding.track_id is not None:
                self._tracker.settle(finding.track_id, FindingKind.PERSON)
            text = f"{describe(finding, FindingKind.PERSON)}. Undecided when the search ended"
            self._tell_claim(text, finding.track_id)

    def _is_person(self, target: TargetEstimate, *, is_present: bool) -> bool:
        if not target.confirmed or self._findings.at(target, FindingStatus.REJECTED):
            return False
        if self._tracker.agrees(target.track_id):
            return True
        return is_present and self._findings.at(target, FindingStatus.CONFIRMED) is not None

    def _is_new(self, target: TargetEstimate) -> bool:
        if target.kind in CLAIMED:
            return False
        known = self._findings.claimed_at(target, set(self._tracker.places_enu_m())) or self._twin(target, CLAIMED)
        if known is not None:
            self._tracker.settle(target.track_id, known.kind)
            return False
        return True

    def _twin(self, target: TargetEstimate, kinds: AbstractSet[FindingKind]) -> TargetEstimate | None:
        """Return another target that is the same body and has been decided to be one of some kinds, if any."""
        for other in self._tracker.estimates():
            is_one = other.track_id != target.track_id and distance_m(other, target) <= PIECES_M
            if is_one and other.kind in kinds:
                return other
        return None

    def _decide(self, target: TargetEstimate) -> None:
        """Decide for good what a target is, by the latest decision about it, unless that is known."""
        verdict = self._tracker.verdict(target.track_id)
        if verdict is None or target.kind is not FindingKind.UNDECIDED or not target.confirmed:
            return
        is_rejected = self._findings.at(target, FindingStatus.REJECTED) is not None
        if verdict.kind is FindingKind.PERSON:
            if not is_rejected and self._is_new(target):
                self._claim(target)
        elif verdict.kind not in CLAIMED:
            is_known = self._twin(target, _OTHERS) is not None
            self._tracker.settle(target.track_id, verdict.kind)
            if not (is_rejected or is_known):
                text = f"{describe(target, verdict.kind)}. The search goes on"
                self._journal.notice(Severity.INFO, text, track_id=target.track_id)

    def _claim(self, target: TargetEstimate) -> None:
        verdict = self._tracker.verdict(target.track_id)
        kind = FindingKind.PERSON if verdict is None or verdict.kind not in CLAIMED else verdict.kind
        self._tracker.settle(target.track_id, kind)
        self._tell_claim(describe(target, kind), target.track_id)

    def _tell_claim(self, text: str, track_id: int | None) -> None:
        self._journal.notice(Severity.NEWS, text, track_id=track_id)
        if self.first_at_s is None:
            self.first_at_s = self._journal.elapsed_s()


def _is_within(place: tuple[float, float], others: Sequence[tuple[float, float]], distance_m: float) -> bool:
    return any(math.dist(place, other) <= distance_m for other in others)


def describe(target: TargetEstimate | Finding, kind: FindingKind) -> str:
    """Return what was seen, where, how sure that is, and why."""
    confidence, (east_m, north_m, _) = target.person_confidence, target.position_enu_m
    likely = (
        "" if confidence is None else f" ({100 * confidence:.0f} %{'' if kind is FindingKind.PERSON else ' a person'})"
    )
    precision = "" if target.sigma_m is None else f", ± {target.sigma_m:.1f} m"
    reasons = f": {'; '.join(target.reasons)}" if target.reasons else ""
    return f"{KIND_NAMES[kind]}{likely} at {east_m:.1f} m east, {north_m:.1f} m north{precision}{reasons}"
