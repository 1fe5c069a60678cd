"""Findings: every confirmed target, and what operators have marked."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace

from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.imaging.persons.decision import CLAIMED, FindingKind
from aos_gcs.imaging.step.judgement import SETTLED_M
from aos_gcs.mission.model.findings import Finding, FindingChange, FindingStatus, TargetEstimate
from aos_gcs.mission.search.targets.same_body import (
    SAME_PLACE_M,
    completed,
    distance_m,
    is_apart,
    is_one,
    is_to_be_merged,
    reach_m,
    with_evidence,
)

MAX_FINDINGS = 500
"""Largest number of findings: with more, detection is far too sensitive."""


class Findings:
    """Keeps findings for good: a target that is lost, or rejected, stays in the list.

    Args:
        earlier: findings of earlier sorties of the operation; recorded like an operator's changes.
    """

    def __init__(self, earlier: Sequence[Finding] = ()) -> None:
        self._findings: dict[int, Finding] = {finding.finding_id: finding for finding in earlier}
        self._edits: list[Finding] = list(earlier)
        """Findings as operators have changed them, since they were taken."""

    def take_edits(self) -> tuple[Finding, ...]:
        """Return the findings as operators have changed them since the last call, in order."""
        edits, self._edits = tuple(self._edits), []
        return edits

    def adopt(self, edits: Sequence[Finding]) -> None:
        """Take in findings as operators have changed them, from a record."""
        self._findings |= {finding.finding_id: finding for finding in edits}

    def all(self) -> tuple[Finding, ...]:
        """Return all findings, oldest first."""
        return tuple(self._findings.values())

    def persons(self) -> tuple[Finding, ...]:
        """Return what this mission has found that counts as a person, oldest first."""
        return tuple(finding for finding in self.all() if finding.stands and not finding.found_in)

    def at(self, target: TargetEstimate, *statuses: FindingStatus) -> Finding | None:
        """Return the finding of a target, or else one at its place, that has one of these statuses."""
        own_id = self._followed_by(target)
        own = [
            finding
            for finding in self._findings.values()
            if finding.status in statuses
            and finding.merged_into is None
            and (finding.finding_id == own_id or distance_m(finding, target) <= SETTLED_M)
        ]
        return min(own, key=lambda finding: finding.finding_id != own_id, default=None)

    def claimed_at(self, target: TargetEstimate, living: AbstractSet[int]) -> Finding | None:
        """Return the announced finding that a target is, if any; ``living`` are the tracks that have not ended."""
        for finding in self._findings.values():
            reach = reach_m(finding, target)
            is_near = distance_m(finding, target) <= (reach if finding.track_id in living else max(SETTLED_M, reach))
            if finding.is_claimed and (finding.track_id == target.track_id or is_near):
                return finding
        return None

    def observe(self, targets: Sequence[TargetEstimate], step: int, now_s: float) -> tuple[Finding, ...]:
        """Update the findings by the targets of a step, and return those that are new.

        Args:
            targets: confirmed ones become findings.
            step: step that has shown them.
            now_s: mission time.
        """
        living = {target.track_id for target in targets}
        new = []
        for target in targets:
            if not target.confirmed:
                continue
            finding = self._of_track(target.track_id) or self._seen_again(target, living)
            if finding is None and (whole := self._whole(target)) is not None:
                if target.kind not in CLAIMED or whole.is_claimed:
                    continue
                # What was announced must be in the list; what the other track turns out to be may be something else.
                finding = whole
            if finding is None:
                if len(self._findings) >= MAX_FINDINGS:
                    continue
                finding = self._make(target.position_enu_m, step, now_s)
                new.append(finding.finding_id)
            elif finding.found_in:
                finding = replace(finding, found_in="", found_at_s=now_s)
            self._findings[finding.finding_id] = _updated(finding, target, step)
        return tuple(self._findings[finding_id] for finding_id in new)

    def announce(self, finding_id: int) -> None:
        """Note that a finding is announced as a possible person, by what was seen of it before."""
        self._findings[finding_id] = replace(self._findings[finding_id], kind=FindingKind.PERSON)

    def merge(self, targets: Sequence[TargetEstimate]) -> tuple[Finding, ...]:
        """Merge findings whose places have come together, the later into the earlier, and part those that are two.

        To be called after each :meth:`observe`, with the same targets. A merged finding stays in the list, follows its
        target and points to the other one, which alone counts.

        Returns:
            Findings that are merged, or are no longer.
        """
        before = dict(self._findings)
        living = {target.track_id for target in targets if target.confirmed}
        followed = [finding for finding in before.values() if finding.track_id in living]
        for finding in followed:
            if finding.merged_into is not None:
                self._follow_merged(finding, finding.merged_into)
        for finding in followed:
            for other_id in before.keys() - {finding.finding_id}:
                self._merge_if_one(*sorted((finding.finding_id, other_id)))
        return tuple(one for one in self.all() if one.merged_into != before[one.finding_id].merged_into)

    def _follow_merged(self, later: Finding, earlier_id: int) -> None:
        """Let the finding that another was merged into have its new evidence, or part them."""
        earlier = self._findings[earlier_id]
        if is_apart(earlier, later):
            self._findings[later.finding_id] = replace(later, merged_into=None)
        else:
            self._findings[earlier_id] = with_evidence(earlier, later)

    def _merge_if_one(self, earlier_id: int, later_id: int) -> None:
        earlier, later = self._findings[earlier_id], self._findings[later_id]
        if earlier.merged_into is not None or later.merged_into is not None or not is_to_be_merged(earlier, later):
            return
        self._findings[earlier_id] = completed(earlier, later)
        for finding in self.all():
            if later_id in {finding.finding_id, finding.merged_into}:
                self._findings[finding.finding_id] = replace(finding, merged_into=earlier_id)

    def add(self, position_enu_m: EnuPoint, comment: str, operator: str, step: int, now_s: float) -> Finding:
        """Mark a place by hand; see ``MissionCommands.add_finding``."""
        if len(self._findings) >= MAX_FINDINGS:
            raise MissionError(f"There are {MAX_FINDINGS} findings already, the most that are kept.")
        finding = replace(self._make(position_enu_m, step, now_s), comment=comment, operator=operator)
        self._findings[finding.finding_id] = finding
        self._edits.append(finding)
        return finding

    def date(self, finding_id: int, at_s: float) -> None:
        """Note the mission time, below 0, of a finding that was marked by hand before the start."""
        finding = replace(self._findings[finding_id], found_at_s=at_s, seen_at_s=at_s)
        self._findings[finding_id] = finding
        self._edits.append(finding)

    def change(self, finding_id: int, change: FindingChange, operator: str) -> Finding:
        """Judge, comment or assign; see ``MissionCommands.change_finding``.

        Only a change of the status makes somebody the operator who has decided.
        """
        finding = self._findings.get(finding_id)
        if finding is None:
            raise MissionError(f"There is no finding {finding_id}.")
        if change.status is not None and (same := finding.merged_into) is not None:
            raise MissionError(
                f"Finding {finding_id} is the same as finding {same}: judge finding {same}, "
                "or mark the position of a second person."
            )
        if change.is_empty:
            return finding
        status = finding.status if change.status is None else change.status
        finding = replace(
            finding,
            status=status,
            comment=finding.comment if change.comment is None else change.comment,
            assignee=finding.assignee if change.assignee is None else change.assignee,
            operator=finding.operator if status is finding.status else operator,
        )
        self._findings[finding_id] = finding
        self._edits.append(finding)
        return finding

    def _make(self, position_enu_m: EnuPoint, step: int, now_s: float) -> Finding:
        finding_id = len(self._findings) + 1
        return Finding(finding_id, FindingStatus.NEW, position_enu_m, found_at_s=now_s, seen_at_s=now_s, step=step)

    def _of_track(self, track_id: int) -> Finding | None:
        """Return the finding that follows a track."""
        return next((finding for finding in self._findings.values() if finding.track_id == track_id), None)

    def _whole(self, target: TargetEstimate) -> Finding | None:
        """Return the finding, still followed, of whose body a target is a second track; None if there is none.

        It gets a finding of its own as soon as it is taken for something else. One that is announced while the finding
        is not decided is followed from then on.
        """
        for finding in self._findings.values():
            is_other = target.kind in CLAIMED and finding.kind not in {FindingKind.UNDECIDED, target.kind}
            if finding.track_id is not None and is_one(finding, target) and not is_other:
                return finding
        return None

    def _followed_by(self, target: TargetEstimate) -> int | None:
        """Return the id of the finding that a target belongs to, by its track."""
        own = self._of_track(target.track_id)
        if own is None:
            return None
        return own.finding_id if own.merged_into is None else own.merged_into

    def _seen_again(self, target: TargetEstimate, living: set[int]) -> Finding | None:
        """Return the nearest finding at the target's place whose own target is lost, or that an earlier sortie has."""
        near = [
            (away_m, finding.finding_id)
            for finding in self._findings.values()
            if (finding.track_id is not None or finding.found_in)
            and finding.track_id not in living
            and finding.merged_into is None
            if (away_m := distance_m(finding, target)) <= SAME_PLACE_M
        ]
        return self._findings[min(near)[1]] if near else None


def _updated(finding: Finding, target: TargetEstimate, step: int) -> Finding:
    """Return a finding updated by its target; place and step stay while the target is out of view.

    The track of a target that has moved goes on with its speed: after a minute that says nothing about where it is.
    """
    seen_at_s = finding.seen_at_s if target.seen_at_s is None else target.seen_at_s
    is_new = finding.track_id is None
    is_seen = is_new or target.seen_at_s is None or target.seen_at_s > finding.seen_at_s
    is_decided = finding.kind is not FindingKind.UNDECIDED and target.kind in {FindingKind.UNDECIDED, finding.kind}
    knows_no_better = is_decided or target.person_confidence is None
    return replace(
        finding,
        track_id=target.track_id,
        position_enu_m=target.position_enu_m if is_seen else finding.position_enu_m,
        sigma_m=target.sigma_m if is_seen else finding.sigma_m,
        ellipse=target.ellipse if is_seen else finding.ellipse,
        sightings=target.sightings,
        person_confidence=finding.person_confidence if knows_no_better else target.person_confidence,
        kind=finding.kind if is_decided else target.kind,
        reasons=finding.reasons if is_decided and finding.reasons else target.reasons,
        significance=target.significance,
        seen_at_s=seen_at_s,
        step=step if is_new or seen_at_s > finding.seen_at_s else finding.step,
    )
