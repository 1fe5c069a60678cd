"""Targets that are tracked, and findings that operators judge."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.imaging.persons.decision import CLAIMED, FindingKind

KIND_NAMES: Mapping[FindingKind, str] = {
    FindingKind.UNDECIDED: "Undecided",
    FindingKind.PERSON: "Possible person",
    FindingKind.ANIMAL: "Animal?",
    FindingKind.WARM_OBJECT: "Warm object?",
    FindingKind.OBJECT: "Object, not warm",
    FindingKind.ANOMALY: "Anomaly",
}
"""Names for operators; the dashboard uses the same."""

MAX_DISTANCE_M: Final = 50_000.0
"""Largest distance from the origin of a place that is marked by hand; a farther one is a mistake."""


@dataclass(frozen=True, slots=True)
class ErrorEllipse:
    """One standard deviation of a horizontal position; holds the truth with a probability of 39 %."""

    semi_major_m: float
    semi_minor_m: float
    heading_rad: float
    """Heading of the major axis, clockwise from north, [0, pi]."""


@dataclass(frozen=True, slots=True)
class TargetEstimate:
    """Estimated position of a target. Records of older missions lack what has a default."""

    position_enu_m: EnuPoint
    """Position of the ground below it, at the latest step."""
    sigma_m: float | None
    """Standard deviation along a horizontal axis, the mean over all directions; None when it is not known."""
    sightings: int
    track_id: int = 0
    """Counts from 1 in a mission; 0: not known."""
    confirmed: bool = True
    """Seen often enough to be no false alarm."""
    ellipse: ErrorEllipse | None = None
    velocity_enu_mps: tuple[float, float] | None = None
    """Horizontal."""
    seen_at_s: float | None = None
    """Mission time of the latest sighting."""
    person_confidence: float | None = None
    """Probability that it is a person rather than another warm body; None when no temperatures tell."""
    kind: FindingKind = FindingKind.UNDECIDED
    """What it is taken for, once that is decided."""
    reasons: tuple[str, ...] = ()
    """What the probability rests on, in words."""
    significance: float | None = None
    """Significance in a survey's pictures: -log10 of the probability of chance. None in missions."""


class FindingStatus(StrEnum):
    """Operators' judgement of a finding."""

    NEW = "new"
    CONFIRMED = "confirmed"
    REJECTED = "rejected"


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that searchers should know of: a confirmed target, or what an operator has marked."""

    finding_id: int
    """Counts from 1."""
    status: FindingStatus
    position_enu_m: EnuPoint
    """Position of the ground below it."""
    found_at_s: float
    """Mission time at which it was first known; below 0 for one marked by hand before the start, and 0 until then."""
    seen_at_s: float
    """Mission time of the latest sighting; of one marked by hand, when it was marked."""
    step: int
    """Step in which it was last seen, whose frames show it; a step of the mission ``found_in``, if there is one."""
    track_id: int | None = None
    """The target that it follows; None for one marked by hand."""
    sigma_m: float | None = None
    ellipse: ErrorEllipse | None = None
    sightings: int = 0
    person_confidence: float | None = None
    """Probability that it is a person; None when no temperatures tell."""
    kind: FindingKind = FindingKind.UNDECIDED
    """What it is taken for, once that is decided."""
    reasons: tuple[str, ...] = ()
    """What the probability rests on, in words."""
    significance: float | None = None
    """See :class:`TargetEstimate`."""
    comment: str = ""
    assignee: str = ""
    """Person or team that it is assigned to."""
    operator: str = ""
    """Operator who has last changed the status, or marked it; in older records, who has last commented on it, too."""
    merged_into: int | None = None
    """The earlier finding that it has turned out to be, and that counts instead; None for one of its own."""
    found_in: str = ""
    """Mission of an earlier sortie that has found it, whose frames show it; empty for a finding of this mission."""

    @property
    def decided_by(self) -> str:
        """Operator who has confirmed or rejected it; empty while nobody has."""
        return "" if self.status is FindingStatus.NEW else self.operator

    @property
    def is_claimed(self) -> bool:
        """Whether the mission has announced it as a possible person."""
        return self.kind in CLAIMED

    @property
    def stands(self) -> bool:
        """Whether it counts as a person: announced or confirmed, not rejected, and no other finding's person."""
        counts = self.merged_into is None and self.status is not FindingStatus.REJECTED
        return counts and (self.is_claimed or self.status is FindingStatus.CONFIRMED)


@dataclass(frozen=True, slots=True)
class FindingChange:
    """Changes of a finding by an operator; None leaves a field as it is."""

    status: FindingStatus | None = None
    comment: str | None = None
    assignee: str | None = None

    @property
    def is_empty(self) -> bool:
        """Whether nothing is to be changed."""
        return self == FindingChange()
