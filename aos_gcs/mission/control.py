"""Ports of a mission towards its users: the view, the commands, and the control of a replay."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Protocol

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.events import Event, NoticeRecord
from aos_gcs.mission.model.findings import Finding, FindingChange
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.proposals import ProposalRecord, ProposalUse
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import Picture, PictureKind, StepRecord
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import MissionSettings


class MissionView(Protocol):
    """Read access to a mission, in flight or replayed."""

    def snapshot(self) -> MissionSnapshot:
        """Return the present state."""
        ...

    def steps(self) -> Sequence[StepRecord]:
        """Return all steps so far, oldest first."""
        ...

    def picture(self, kind: PictureKind) -> Picture | None:
        """Return the latest raster of a kind, if there is one."""
        ...

    def subscribe(self) -> AbstractContextManager[AsyncIterator[Event]]:
        """Follow the events from now on. Bounded: a slow reader loses its oldest ones, seen as gaps in ``seq``."""
        ...


class FindingCommands(Protocol):
    """What operators do with findings, of missions and of surveys. Their sign-in names go into the record."""

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        """Mark a place by hand.

        Raises:
            MissionError: there are too many findings already.
        """
        ...

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        """Judge, comment or assign a finding.

        Raises:
            MissionError: there is no such finding.
        """
        ...


class MissionCommands(FindingCommands, Protocol):
    """Commands of operators to a mission in flight. Their sign-in names go into the record."""

    async def act(
        self,
        action: Action,
        vehicle_ids: tuple[int, ...] | None,
        focal_height_m: float | None = None,
        *,
        operator: str = "",
        seen: Seen | None = None,
    ) -> tuple[ActionResult, ...]:
        """Carry out an action for the vehicles named, or for the whole mission when ``None``.

        The focal height belongs to the action of focusing alone; ``None`` leaves it to autofocus. ``seen`` is the state
        by which the operator commands; ``None`` for a program that reads the mission itself.

        Raises:
            OutdatedError: the state is too old, or another command came in between; a hold is never refused for that.
            MissionError: the present phase does not allow it, or an id is unknown; nothing was sent.
        """
        ...

    async def override_check(
        self, vehicle_id: int, check: str, reason: str | None, *, operator: str = "", seen: Seen | None = None
    ) -> PreflightCheck:
        """Let the mission launch in spite of a failed preflight check, and return the check as it is then.

        The reason goes into the audit log; ``None`` withdraws an override. An override ends when the check finds
        something else.

        Raises:
            OutdatedError: the state that the operator saw is too old.
            MissionError: the present phase does not allow it, or there is no such check, or it has not failed, or it
                must not be overridden.
        """
        ...

    async def acknowledge(self, notice_ids: Sequence[int], *, operator: str = "") -> None:
        """Acknowledge notices on behalf of all operators; the first to acknowledge one stays on record.

        Raises:
            MissionError: there is no notice of such a number; none was acknowledged.
        """
        ...

    async def announce(self, text: str, *, operator: str = "") -> None:
        """Put on record what operators have settled among themselves, such as who has control."""
        ...

    async def decide_proposal(self, proposal_id: int, use: ProposalUse, *, operator: str = "") -> ProposalRecord:
        """Put on record what an operator makes of a proposal of others; one that becomes a finding is marked as one.

        Plans are changed by operators, and applied by :meth:`apply_plan`, whatever is decided here.

        Raises:
            MissionError: it is gone, was decided about, or cannot be used so.
        """
        ...

    @property
    def settings(self) -> MissionSettings:
        """Settings that the mission flies by at present."""
        ...

    async def apply_plan(self, plan: MissionPlan, *, operator: str = "", seen: Seen | None = None) -> None:
        """Fly by another plan. Connecting and preflight start anew; the plan is recorded.

        Raises:
            OutdatedError: the state that the operator saw is too old, or another command came in between.
            MissionError: the mission has started, or the plan cannot be flown.
        """
        ...


@dataclass(frozen=True, slots=True)
class ReplayState:
    """Position of a replay in the recorded mission."""

    time_s: float
    """Clock seconds since the recording began."""
    duration_s: float
    speed: float
    """Recorded seconds per second."""
    playing: bool


@dataclass(frozen=True, slots=True)
class Timeline:
    """Times of what happened in a recorded mission, as in ``ReplayState``."""

    start_utc_s: float
    phases: tuple[tuple[float, Phase], ...]
    """Start of each phase."""
    steps: tuple[tuple[float, int], ...]
    """Time of each decision."""
    notices: tuple[tuple[float, NoticeRecord], ...]
    findings: tuple[tuple[float, Finding], ...]
    """Time at which each finding was first known, and its last state."""


class ReplayControl(Protocol):
    """Control of a replay, which is read as a ``MissionView``."""

    def replay(self) -> ReplayState:
        """Return the position of the replay."""
        ...

    def timeline(self) -> Timeline:
        """Return the times of what happened."""
        ...

    def seek(self, *, time_s: float | None = None, speed: float | None = None, playing: bool | None = None) -> None:
        """Change what is given. A time outside of the recording is moved to its nearest end."""
        ...
