"""Shared state of a mission's procedures: for the whole mission, and for one plan."""

from __future__ import annotations

from dataclasses import dataclass, field

from aos_gcs.mission.auto_start import AutoStart
from aos_gcs.mission.command_order import CommandOrder
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.suspending import SuspensionState
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Clock, ThreadWorker, Worker


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightContext:
    """Parts that fly and monitor vehicles by one plan; another plan makes another context."""

    settings: MissionSettings
    clock: Clock
    roster: Roster
    journal: Journal
    flight: FlightControl
    imaging: Worker = field(default_factory=ThreadWorker)
    """Analyses images."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionContext:
    """Parts that a mission keeps, whichever plan it flies by."""

    clock: Clock
    roster: Roster
    journal: Journal
    recorder: Recorder
    loop_monitor: LoopMonitor
    auto_start: AutoStart
    order: CommandOrder
    suspension: SuspensionState
    imaging: Worker
    """Analyses images."""

    def flight_context(self, settings: MissionSettings) -> FlightContext:
        """Return the context of a flight by these settings; preflight has not set its limits yet."""
        flight = FlightControl(self.roster, self.clock, self.journal, settings.flight, settings.deadlines)
        return FlightContext(
            settings=settings,
            clock=self.clock,
            roster=self.roster,
            journal=self.journal,
            flight=flight,
            imaging=self.imaging,
        )
