"""Shared state of a mission's procedures: for the whole mission, and for one plan."""

from __future__ import annotations

from dataclasses import dataclass, field

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.mission.auto_start import AutoStart
from aos_gcs.mission.command_order import CommandOrder
from aos_gcs.mission.fleet.bounds import FlightBounds
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
    bounds: FlightBounds
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

    def flight_context(self, settings: MissionSettings, limits: SafetyLimits | None = None) -> FlightContext:
        """Return the context of a flight by these settings, and by limits that are known already, if any."""
        bounds = FlightBounds(settings.flight.arrival_radius_m, limits)
        flight = FlightControl(
            self.roster, self.clock, self.journal, settings.flight, settings.deadlines, bounds=bounds
        )
        return FlightContext(
            settings=settings,
            clock=self.clock,
            roster=self.roster,
            journal=self.journal,
            bounds=bounds,
            flight=flight,
            imaging=self.imaging,
        )
