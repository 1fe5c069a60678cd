"""Rules by which two targets, or two findings, count as one body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import Finding, FindingStatus, TargetEstimate

SAME_PLACE_M = 3.0
"""Distance within which a new target is a finding whose own target was lost."""
PIECES_M = 0.5
"""Distance within which two targets are one, whatever they are taken for: pieces of a body are located together."""
SAME_BODY_M = 1.5
"""Distance within which two targets of one kind are one: pieces of a person who lies stretched out."""
_CONFIDENCE = 2.0
"""Factor between the standard deviation of a distance and the error that is taken into account."""
_LATELY_S = 10.0
"""Time between the sightings of one body in which it has hardly moved."""
_APART = 1.25
"""Distance at which merged findings are two again, over that up to which they are one."""


def distance_m(one: Finding | TargetEstimate, other: Finding | TargetEstimate) -> float:
    """Return the horizontal distance."""
    return math.dist(one.position_enu_m[:2], other.position_enu_m[:2])


def reach_m(one: Finding | TargetEstimate, other: Finding | TargetEstimate) -> float:
    """Return the distance up to which the two may be one body, by its size and by both their errors."""
    error_m = _CONFIDENCE * math.hypot(one.sigma_m or 0.0, other.sigma_m or 0.0)
    return min(max(SAME_BODY_M, error_m), SAME_PLACE_M)


def distinct(targets: Sequence[TargetEstimate], target: TargetEstimate | None) -> tuple[TargetEstimate, ...]:
    """Return the targets without those that are pieces of another one; ``target`` itself stays."""
    kept: list[TargetEstimate] = []
    for one in sorted(targets, key=lambda one: target is None or one.track_id != target.track_id):
        if all(distance_m(one, other) > PIECES_M for other in kept):
            kept.append(one)
    return tuple(one for one in targets if one in kept)


def is_one(finding: Finding, target: TargetEstimate) -> bool:
    """Return whether a finding and a target that are both in view are one body."""
    reach = reach_m(finding, target) if _is_same_kind(finding, target) else PIECES_M
    return distance_m(finding, target) <= reach


def is_to_be_merged(earlier: Finding, later: Finding) -> bool:
    """Return whether two findings of the list are one body, by their places and what they are taken for.

    What operators say of both stays as it is, and so does what they have rejected or marked by hand: a rejection must
    not reach another finding, which may be a person.
    """
    if None in {earlier.track_id, later.track_id} or FindingStatus.REJECTED in {earlier.status, later.status}:
        return False
    if earlier.status is FindingStatus.CONFIRMED and later.status is FindingStatus.CONFIRMED:
        return False
    return _is_same_kind(earlier, later) and distance_m(earlier, later) <= reach_m(earlier, later)


def is_apart(earlier: Finding, later: Finding) -> bool:
    """Return whether a merged finding is another body than the finding that it was merged into."""
    return not _is_same_kind(earlier, later) or distance_m(earlier, later) > _APART * reach_m(earlier, later)


def completed(earlier: Finding, later: Finding) -> Finding:
    """Return the earlier one of two findings that are merged now, with what operators have said of the later one."""
    takes_verdict = earlier.status is FindingStatus.NEW and later.status is FindingStatus.CONFIRMED
    return replace(
        with_evidence(earlier, later),
        status=later.status if takes_verdict else earlier.status,
        operator=later.operator if takes_verdict else earlier.operator,
        comment=earlier.comment or later.comment,
        assignee=earlier.assignee or later.assignee,
    )


def with_evidence(earlier: Finding, later: Finding) -> Finding:
    """Return the earlier one of two merged findings with the evidence of the later one that it lacks.

    It stands where the better known of the two does: the track of the earlier one may have drifted away, as one does
    that has taken something else for its body for a while.
    """
    takes_kind = earlier.kind is FindingKind.UNDECIDED and later.kind is not FindingKind.UNDECIDED
    placed = later if _is_better_placed(later, earlier) else earlier
    return replace(
        earlier,
        position_enu_m=placed.position_enu_m,
        sigma_m=placed.sigma_m,
        ellipse=placed.ellipse,
        kind=later.kind if takes_kind else earlier.kind,
        person_confidence=later.person_confidence if takes_kind else earlier.person_confidence,
        reasons=later.reasons if takes_kind else earlier.reasons,
        seen_at_s=max(earlier.seen_at_s, later.seen_at_s),
        step=max(earlier.step, later.step),
    )


def _is_better_placed(one: Finding, other: Finding) -> bool:
    """Return whether a finding's place is known better than that of another, and is not much older."""
    if one.sigma_m is None or one.seen_at_s < other.seen_at_s - _LATELY_S:
        return False
    return other.sigma_m is None or one.sigma_m < other.sigma_m


def _is_same_kind(one: Finding | TargetEstimate, other: Finding | TargetEstimate) -> bool:
    return one.kind is other.kind or FindingKind.UNDECIDED in {one.kind, other.kind}
