"""What the procedures of a mission share."""

from __future__ import annotations

from dataclasses import dataclass, field

from aos_gcs.mission.cameras import CameraLog
from aos_gcs.mission.flight import FlightControl
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.model import Outcome, PreflightCheck
from aos_gcs.mission.roster import Roster
from aos_gcs.mission.settings import MissionSettings
from aos_gcs.ports import Clock


@dataclass(slots=True)
class MissionContext:
    """One mission's parts and the little state that several procedures touch."""

    settings: MissionSettings
    clock: Clock
    roster: Roster
    journal: Journal
    flight: FlightControl
    recorder: Recorder
    loop_monitor: LoopMonitor
    message: str = ""
    """What the mission is doing or waiting for, in one sentence."""
    outcome: Outcome = Outcome.OPEN
    preflight: tuple[PreflightCheck, ...] = ()
    cameras: CameraLog = field(default_factory=CameraLog)
