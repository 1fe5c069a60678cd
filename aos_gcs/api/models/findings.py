"""Wire models of targets and findings."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models.base import PositionModel, VertexModel, WireModel
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import FindingStatus


class EllipseModel(WireModel):
    """One standard deviation of a horizontal position; holds the truth with a probability of 39 %."""

    semi_major_m: float
    semi_minor_m: float
    heading_deg: float = Field(description="Direction of the major axis, clockwise from true north, [0, 180].")


class TargetModel(WireModel):
    """Estimated position of a target."""

    track_id: int = Field(description="Counts from 1 in a mission; 0 if not known.")
    confirmed: bool = Field(description="Seen often enough to be no false alarm.")
    position: PositionModel
    sigma_m: float | None
    ellipse: EllipseModel | None
    speed_mps: float | None
    sightings: int
    seen_at_s: float | None = Field(description="Mission time of the latest sighting.")
    person_confidence: float | None = Field(
        description="Probability, 0 to 1, that it is a person rather than another warm body; null if unknown."
    )
    kind: FindingKind = Field(description="What it is taken for, once that is decided.")
    reasons: list[str] = Field(description="What the probability rests on, in words.")


class LeftPlaceModel(WireModel):
    """A place that is left for a later look."""

    position: VertexModel
    person_confidence: float = Field(description="Probability, 0 to 1, that it is a person, by what has been seen.")


class FindingModel(WireModel):
    """Something that was found, for the searchers."""

    finding_id: int
    status: FindingStatus
    position: PositionModel
    dms: str | None = Field(description="Degrees, minutes and seconds; null while the origin is unknown.")
    utm: str | None
    mgrs: str | None
    sigma_m: float | None
    ellipse: EllipseModel | None
    sightings: int
    person_confidence: float | None = Field(description="Probability, 0 to 1; null if unknown.")
    kind: FindingKind = Field(description="What it is taken for, once that is decided.")
    reasons: list[str] = Field(description="What the probability rests on, in words.")
    significance: float | None = Field(
        description="In surveys, -log10 of the probability that chance makes it; null in missions."
    )
    track_id: int | None = Field(description="Track of the target; null if an operator has marked it.")
    found_at_s: float = Field(
        description="Mission time at which it was first known; below 0 if marked before the start."
    )
    seen_at_s: float
    step: int = Field(description="Step whose frames show it.")
    comment: str
    assignee: str
    operator: str = Field(description="Operator who last changed its status, or marked it; empty if nobody has.")
    merged_into: int | None = Field(description="Earlier finding that it turned out to be, and that counts instead.")
    found_in: str = Field(description="Mission of an earlier sortie that has found it; empty for one of this mission.")


Comment = Annotated[str, Field(max_length=2000)]


class FindingRequest(WireModel):
    """A place that an operator marks."""

    latitude_deg: Annotated[float, Field(strict=True, ge=-90.0, le=90.0, allow_inf_nan=False)]
    longitude_deg: Annotated[float, Field(strict=True, ge=-180.0, le=180.0, allow_inf_nan=False)]
    comment: Comment = ""


class FindingChangeRequest(WireModel):
    """Changes to a finding; fields that are left out, or null, stay as they are."""

    status: FindingStatus | None = None
    comment: Comment | None = None
    assignee: Annotated[str, Field(max_length=100)] | None = None
