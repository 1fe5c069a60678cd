"""Events of a mission's stream."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind, StepRecord
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.ports import Severity


@dataclass(frozen=True, slots=True)
class PlanRecord:
    """A plan that the mission flies from now on."""

    plan: MissionPlan
    operator: str
    """Name of the operator who has applied it."""


@dataclass(frozen=True, slots=True)
class JumpRecord:
    """A replay has gone to another time, and what was told before is no longer so."""

    notices: tuple[NoticeRecord, ...]
    """Notices of the mission up to that time."""


class EventKind(StrEnum):
    """Kind of the data that an event carries."""

    SNAPSHOT = "snapshot"
    """MissionSnapshot, a few times per second."""
    STEP = "step"
    """StepRecord."""
    NOTICE = "notice"
    """NoticeRecord."""
    PICTURES = "pictures"
    """PicturesRecord: new rasters can be fetched."""
    PLAN = "plan"
    """PlanRecord."""
    JUMP = "jump"
    """JumpRecord; in replays alone."""


@dataclass(frozen=True, slots=True)
class NoticeRecord:
    """Something that happened, for the operator and the log. Older records have neither number (from 1) nor time."""

    severity: Severity
    text: str
    vehicle_id: int | None
    elapsed_s: float
    notice_id: int = 0
    utc_s: float = 0.0
    track_id: int | None = None
    """Track of the target that it is about; None for anything else."""


@dataclass(frozen=True, slots=True)
class PicturesRecord:
    """Rasters of a step are ready."""

    step: int
    kinds: tuple[PictureKind, ...]
    west_m: float
    south_m: float
    east_m: float
    north_m: float


EventData = MissionSnapshot | StepRecord | NoticeRecord | PicturesRecord | PlanRecord | JumpRecord


@dataclass(frozen=True, slots=True)
class Event:
    """One entry of the mission's only event stream."""

    seq: int
    """Counts from 1 without gaps; a subscriber that sees a gap has lost events to its own slowness."""
    utc_s: float
    kind: EventKind
    data: EventData
