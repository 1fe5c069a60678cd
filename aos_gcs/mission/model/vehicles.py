"""Vehicles of a mission, with their tasks and cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from aos_gcs.geometry.geodesy import EnuPoint
from aos_gcs.geometry.heights import AboveGroundM
from aos_gcs.ports import VehicleState


class Task(StrEnum):
    """Task of a vehicle in the mission."""

    IDLE = "idle"
    JOINING = "joining"
    """Climbs in mid-mission and flies to the swarm."""
    SWARM = "swarm"
    HELD = "held"
    RETURNING = "returning"
    LANDING = "landing"
    LANDED = "landed"
    LOST = "lost"
    """Silent for longer than the link-loss limit; its own failsafe flies it."""


TASK_NAMES: Mapping[Task, str] = MappingProxyType(
    {
        Task.IDLE: "standing by",
        Task.JOINING: "joining",
        Task.SWARM: "in the swarm",
        Task.HELD: "holding",
        Task.RETURNING: "returning",
        Task.LANDING: "landing",
        Task.LANDED: "landed",
        Task.LOST: "link lost",
    }
)
"""Names for operators, as what a vehicle is doing."""


@dataclass(frozen=True, slots=True)
class SettingsRecord:
    """Settings of a vehicle that the mission changes for its time."""

    utc_s: float
    vehicle_id: int
    purpose: str
    former: Mapping[str, float]
    """Values before the mission, by the autopilot's own names."""
    is_restored: bool = False
    """False: the mission is about to write others; True: the vehicle has these again."""


@dataclass(frozen=True, slots=True)
class CameraSnapshot:
    """Frames that a vehicle's camera has delivered in this mission."""

    frames: int = 0
    """Number of usable frames."""
    failures: int = 0
    """Steps that went on without its frame."""
    last_step: int | None = None
    """Step of its latest frame."""
    footprint_enu_m: tuple[tuple[float, float], ...] = ()
    """Outline of that frame on the focal plane; empty before the first one, and where it sees the horizon."""
    failure: str | None = None
    """Why its frame is missing in the latest step; None if it is not."""


@dataclass(frozen=True, slots=True)
class VehicleSnapshot:
    """One vehicle in the mission."""

    telemetry: VehicleState
    task: Task
    layer_height_m: float | None
    """The altitude layer it flies in, metres above the origin."""
    position_enu_m: EnuPoint | None
    link_age_s: float | None
    """Seconds since its autopilot's last message; None if never heard."""
    waypoint_enu_m: EnuPoint | None
    """Position that it was last sent to."""
    refusal: str | None
    """Why its last planned waypoint was shortened or held, or why it is left alone; None if nothing is in the way."""
    camera: CameraSnapshot | None = None
    """None in older records."""
    takes_part: bool = True
    """Whether it flies the mission; a vehicle that does not is never armed."""
    home_enu_m: EnuPoint | None = None
    """Launch point; None before it is known, and in older records."""
    altitude_offset_m: float = 0.0
    """Altitude that it reports minus the one above the datum that all share."""
    height_above_ground_m: AboveGroundM | None = None
    """Height above the highest ground about it, by the elevation model; None without one, and in older records."""
    leaves_in_s: float | None = None
    """Time until it is to leave for home by its battery; None while that is not known, and in older records."""
    is_ready: bool | None = None
    """Whether it is confirmed to take off for the relay; None where there is none, in the air, and in older records."""
