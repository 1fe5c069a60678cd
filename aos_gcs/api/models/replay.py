"""Wire models of a replay."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.model import FindingStatus, Phase
from aos_gcs.ports import Severity


class ReplayModel(WireModel):
    """Where a replay is in the recorded mission."""

    time_s: float = Field(description="Since the recording began.")
    duration_s: float
    speed: float = Field(description="Recorded seconds per second.")
    playing: bool


class ReplayPhaseModel(WireModel):
    """When a phase began."""

    time_s: float
    phase: Phase


class ReplayStepModel(WireModel):
    """When a step was decided."""

    time_s: float
    step: int


class ReplayNoticeModel(WireModel):
    """When something happened."""

    time_s: float
    severity: Severity
    text: str
    vehicle_id: int | None


class ReplayFindingModel(WireModel):
    """When a finding was first known, and what became of it at last."""

    time_s: float
    finding_id: int
    status: FindingStatus


class TimelineModel(WireModel):
    """A replay, and what lies where in it."""

    replay: ReplayModel
    start_utc_s: float
    phases: list[ReplayPhaseModel]
    steps: list[ReplayStepModel]
    notices: list[ReplayNoticeModel]
    findings: list[ReplayFindingModel]


class ReplayRequest(WireModel):
    """What is to change in a replay; null leaves it as it is."""

    time_s: Annotated[float, Field(allow_inf_nan=False)] | None = None
    speed: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None
    playing: bool | None = None
