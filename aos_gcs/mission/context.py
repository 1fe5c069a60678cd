"""What the procedures of a mission share."""

from __future__ import annotations

from dataclasses import dataclass, field

from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.model import Outcome, PreflightCheck
from aos_gcs.mission.search.cameras import CameraLog
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Clock


@dataclass(slots=True, kw_only=True)
class FlightContext:
    """What it takes to fly vehicles and to watch over them, with the little state that several procedures touch."""

    settings: MissionSettings
    clock: Clock
    roster: Roster
    journal: Journal
    flight: FlightControl
    message: str = ""
    """What the mission is doing or waiting for, in one sentence."""
    outcome: Outcome = Outcome.OPEN


@dataclass(slots=True, kw_only=True)
class MissionContext(FlightContext):
    """One mission's parts: those of a flight, and what records and checks it."""

    recorder: Recorder
    loop_monitor: LoopMonitor
    preflight: tuple[PreflightCheck, ...] = ()
    cameras: CameraLog = field(default_factory=CameraLog)
