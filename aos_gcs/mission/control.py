"""What the API may do with a mission, its findings, its plan and its replay."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Protocol

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model import (
    Action,
    ActionResult,
    Event,
    Finding,
    FindingChange,
    MissionSnapshot,
    NoticeRecord,
    Phase,
    Picture,
    PictureKind,
    PreflightCheck,
    StepRecord,
)
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings


class MissionControl(Protocol):
    """What the API may do with a running mission."""

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        ...

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far, oldest first."""
        ...

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        ...

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
    ) -> tuple[ActionResult, ...]:
        """Carry out an operator's action for the vehicles named, or for the whole mission when ``None``.

        The focal height is of the action of focusing alone, and ``None`` leaves it to autofocus. The operator's name
        goes into the audit log.

        Raises:
            MissionError: the present phase does not allow it, or an id is unknown; nothing was sent.
        """
        ...

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = ""
    ) -> PreflightCheck:
        """Let a failed check of preflight no longer stand against the launch, and return it as it is then.

        The reason goes into the audit log with the operator's name; ``None`` takes an override back. An override ends
        by itself when the check finds something else.

        Raises:
            MissionError: the present phase does not allow it, or there is no such check, or it has not failed, or it
                must not be overridden.
        """
        ...

    def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Take note of notices, on behalf of all operators; who was first with one stays on record.

        Raises:
            MissionError: there is no notice of such a number; none was acknowledged.
        """
        ...

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the events from now on. Bounded: a slow reader loses its oldest ones, seen as gaps in ``seq``."""
        ...


class FindingControl(Protocol):
    """What the API may do with the findings of a running mission; they stand in its snapshot."""

    def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand.

        Raises:
            MissionError: there are too many already.
        """
        ...

    def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding.

        Raises:
            MissionError: there is no such finding.
        """
        ...


class PlanControl(Protocol):
    """What the API may do with the plan of a mission that has not started."""

    @property
    def settings(self) -> MissionSettings:
        """What the mission flies by at present."""
        ...

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "") -> None:
        """Fly by another plan. Connecting and preflight start anew; the plan is recorded.

        Raises:
            MissionError: the mission has started, or the plan cannot be flown.
        """
        ...


@dataclass(frozen=True, slots=True)
class ReplayState:
    """Where a replay is in the recorded mission."""

    time_s: float
    """Clock seconds since the recording began."""
    duration_s: float
    speed: float
    """Recorded seconds per second."""
    playing: bool


@dataclass(frozen=True, slots=True)
class Timeline:
    """What lies where in a recorded mission; times as in ``ReplayState``."""

    start_utc_s: float
    phases: tuple[tuple[float, Phase], ...]
    """When each phase began."""
    steps: tuple[tuple[float, int], ...]
    """When each step was decided."""
    notices: tuple[tuple[float, NoticeRecord], ...]
    findings: tuple[tuple[float, Finding], ...]
    """When each finding was first known, and what became of it at last."""


class ReplayControl(Protocol):
    """What the API may do with a replay, beside reading it as a mission."""

    def replay(self) -> ReplayState:
        """Return where the replay is."""
        ...

    def timeline(self) -> Timeline:
        """Return what lies where."""
        ...

    def seek(self, *, time_s: float | None = None, speed: float | None = None, playing: bool | None = None) -> None:
        """Change what is given. A time outside of the recording is moved to its nearest end."""
        ...
