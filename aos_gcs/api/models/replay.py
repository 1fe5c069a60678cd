"""Wire models of a replay."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StrictBool

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.mission.model.phase import Phase
from aos_gcs.ports import Severity


class ReplayModel(WireModel):
    """Position of a replay in the recorded mission."""

    time_s: float = Field(description="Time since the recording began.")
    duration_s: float
    speed: float = Field(description="Recorded seconds per second.")
    playing: bool


class ReplayPhaseModel(WireModel):
    """Time at which a phase began."""

    time_s: float
    phase: Phase


class ReplayStepModel(WireModel):
    """Time at which a step was decided."""

    time_s: float
    step: int


class ReplayNoticeModel(WireModel):
    """Time of a notice."""

    time_s: float
    severity: Severity
    text: str
    vehicle_id: int | None


class ReplayFindingModel(WireModel):
    """Time at which a finding was first known, and its final status."""

    time_s: float
    finding_id: int
    status: FindingStatus


class TimelineModel(WireModel):
    """A replay and its timeline."""

    replay: ReplayModel
    start_utc_s: float
    phases: list[ReplayPhaseModel]
    steps: list[ReplayStepModel]
    notices: list[ReplayNoticeModel]
    findings: list[ReplayFindingModel]


class ReplayRequest(WireModel):
    """Changes to a replay; null leaves a field as it is."""

    time_s: Annotated[float, Field(strict=True, allow_inf_nan=False)] | None = None
    speed: Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)] | None = None
    playing: StrictBool | None = None
    mission_id: Annotated[str, Field(min_length=1, max_length=200)] | None = Field(
        default=None, description="Show another sortie of the operation, from its beginning; the rest applies to it."
    )
