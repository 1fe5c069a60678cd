"""The decision of a step."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.airspace.waypoints import WaypointRecord
from aos_gcs.mission.model.phase import Phase
from aos_gcs.swarm.model import Diagnostics


@dataclass(frozen=True, slots=True)
class Decision:
    """Decision of a step."""

    following: Phase
    diagnostics: Diagnostics
    waypoints: tuple[WaypointRecord, ...]
    """Vetted, not sent yet."""
    is_sweep: bool = False
    """Whether the swarm flies on along the leg, so that nobody waits for its arrival."""
