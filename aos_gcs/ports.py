"""What the core expects of the world outside: vehicles with cameras, links, clocks.

Drivers implement these protocols and the coordinator depends on nothing else, so that simulated, SITL and real
vehicles are flown by the same code. Everything that crosses is frozen data. Times are clock seconds (``Clock.now_s``)
unless a name says ``utc``.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition


class Clock(Protocol):
    """The only source of time. Its seconds may pass faster than real ones when the vehicles are simulated."""

    def now_s(self) -> float:
        """Return monotonic seconds."""
        ...

    def utc_s(self) -> float:
        """Return seconds since the Unix epoch, advancing with ``now_s``."""
        ...

    async def sleep(self, duration_s: float) -> None:
        """Wait for ``duration_s`` clock seconds."""
        ...

    def timeout_at(self, deadline_s: float) -> asyncio.Timeout:
        """Return a context manager that raises ``TimeoutError`` when the clock passes ``deadline_s``."""
        ...


# --- vehicles -------------------------------------------------------------------------------------------------------


class FlightMode(StrEnum):
    """What a vehicle is doing, across autopilots. ``VehicleState.mode_name`` keeps the autopilot's own word."""

    UNKNOWN = "unknown"
    MANUAL = "manual"
    """A pilot's stick mode; the vehicle does not follow us."""
    GUIDED = "guided"
    """Flies to or holds at positions that we send."""
    HOLD = "hold"
    TAKEOFF = "takeoff"
    MISSION = "mission"
    RETURN = "return"
    LAND = "land"


class LandedState(StrEnum):
    """MAVLink's landed state."""

    UNKNOWN = "unknown"
    ON_GROUND = "on_ground"
    TAKING_OFF = "taking_off"
    IN_AIR = "in_air"
    LANDING = "landing"


@dataclass(frozen=True, slots=True)
class LinkQuality:
    """How well a vehicle is reached; its packet loss and age stand in ``VehicleState``."""

    address: str
    """Where it is spoken to now."""
    living_addresses: int = 1
    """At how many addresses, on all links together, it is being heard."""
    round_trip_s: float | None = None
    clock_offset_s: float | None = None
    """The vehicle's clock minus ours; errs by at most half of the round trip."""
    clock_drift: float | None = None
    """Seconds that the vehicle's clock gains on ours per second."""


@dataclass(frozen=True, slots=True)
class CameraState:
    """What has become of the frames of a vehicle's camera since its link was opened."""

    source: str = ""
    """How they come, in the driver's own word, such as ``component``."""
    frames: int = 0
    """That were delivered."""
    refused: int = 0
    """That came, but with a pose or a time that cannot be trusted."""
    late: int = 0
    """That were not there by the deadline."""
    torn: int = 0
    """That were not whole by the deadline."""
    failed: int = 0
    """That failed otherwise: the camera did not expose, or the file cannot be used."""
    problem: str = ""
    """Why the latest one that is missing is missing."""


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The latest values a vehicle has reported; ``None`` means that it never did."""

    vehicle_id: int
    autopilot: str = "unknown"
    """``arducopter``, ``px4``, or ``unknown`` (observed, never commanded)."""
    mode: FlightMode = FlightMode.UNKNOWN
    mode_name: str = ""
    armed: bool = False
    landed: LandedState = LandedState.UNKNOWN
    ready_to_arm: bool | None = None
    position: GeodeticPosition | None = None
    position_at_s: float | None = None
    """When ``position`` arrived."""
    height_above_home_m: float | None = None
    velocity_enu_mps: tuple[float, float, float] | None = None
    heading_rad: float | None = None
    """Clockwise from true north, [0, 2 pi)."""
    home: GeodeticPosition | None = None
    battery_fraction: float | None = None
    battery_voltage_v: float | None = None
    gps_fix: int | None = None
    """MAVLink's GPS_FIX_TYPE; 3 and above is a 3D fix."""
    satellites: int | None = None
    heard_at_s: float | None = None
    """When the last message of the vehicle arrived."""
    packet_loss_fraction: float | None = None
    """Share of the vehicle's messages that never arrived, from gaps in its sequence numbers."""
    link: LinkQuality | None = None
    camera: CameraState | None = None
    text: str = ""
    """The latest status text of severity warning or worse."""
    hdop: float | None = None
    """Horizontal dilution of precision."""
    is_ambiguous: bool = False
    """Two vehicles are heard with this id: neither is commanded."""


@dataclass(frozen=True, slots=True)
class Arm:
    """Arm the motors; done when the vehicle reports them armed."""


@dataclass(frozen=True, slots=True)
class Disarm:
    """Disarm on the ground. Refused by the driver while the vehicle is, or may be, in the air."""


@dataclass(frozen=True, slots=True)
class Takeoff:
    """Climb straight up; done when the height is within 1 m."""

    height_above_home_m: float


@dataclass(frozen=True, slots=True)
class Goto:
    """Fly straight to a position; done when telemetry shows that the vehicle has taken it over, not on arrival."""

    position: GeodeticPosition
    speed_mps: float


@dataclass(frozen=True, slots=True)
class Hold:
    """Stop and hold the position; done when the mode shows it."""


@dataclass(frozen=True, slots=True)
class ReturnToLaunch:
    """Hand over to the autopilot's own return; done when the mode shows it."""


@dataclass(frozen=True, slots=True)
class Land:
    """Land here; done when the mode shows it."""


Command = Arm | Disarm | Takeoff | Goto | Hold | ReturnToLaunch | Land


@dataclass(frozen=True, slots=True, eq=False)
class Capture:
    """One exposure of a vehicle's camera."""

    vehicle_id: int
    image_index: int
    """The camera's own running number."""
    utc_s: float
    """Time of exposure."""
    image: NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]
    """Shape (H, W, C); bands as in ``bands``."""
    bands: tuple[str, ...]
    """Of ``red, green, blue, grey, thermal``, one per channel. Thermal is in degrees Celsius when radiometric."""
    position: GeodeticPosition
    """Projection centre at exposure."""
    R_cam2enu: NDArray[np.float64]
    """Orientation at exposure, shape (3, 3), into the ENU axes at ``position``."""
    camera: CameraModel
    time_sigma_s: float | None = None
    """Standard deviation of the time that the pose is of; None where the source tells none."""


LatLon = tuple[float, float]
"""Latitude and longitude in degrees, WGS84."""

_SAME_PLACE_DEG = 2e-7
"""Autopilots keep integers of 1e-7 degrees, about a centimetre."""
_SAME_HEIGHT_M = 0.1


@dataclass(frozen=True, slots=True)
class Geofence:
    """Where a vehicle may fly, as its own autopilot keeps it."""

    inclusion_deg: tuple[LatLon, ...]
    """Polygon to stay in."""
    exclusions_deg: tuple[tuple[LatLon, ...], ...] = ()
    """Polygons to stay out of."""
    ceiling_above_home_m: float | None = None
    radius_about_home_m: float | None = None
    """Limit of the distance from home; we give none."""
    other_items: int = 0
    """Stored items that belong to none of the polygons above, such as circles; we write none."""

    def is_same_as(self, other: Geofence) -> bool:
        """Whether both limit a flight alike, but for what gets lost in an autopilot's own numbers."""
        rings, other_rings = ((fence.inclusion_deg, *fence.exclusions_deg) for fence in (self, other))
        if [len(ring) for ring in rings] != [len(ring) for ring in other_rings]:
            return False
        return (
            all(
                abs(one - another) <= _SAME_PLACE_DEG
                for ring, other_ring in zip(rings, other_rings, strict=True)
                for vertex, other_vertex in zip(ring, other_ring, strict=True)
                for one, another in zip(vertex, other_vertex, strict=True)
            )
            and _is_same_limit(self.ceiling_above_home_m, other.ceiling_above_home_m)
            and _is_same_limit(self.radius_about_home_m, other.radius_about_home_m)
            and self.other_items == other.other_items
        )


def _is_same_limit(one_m: float | None, other_m: float | None) -> bool:
    if one_m is None or other_m is None:
        return one_m is other_m
    return abs(one_m - other_m) <= _SAME_HEIGHT_M


@dataclass(frozen=True, slots=True)
class Safeguard:
    """What a vehicle does by itself when something goes wrong."""

    is_on: bool
    text: str
    """The action and the setting that says so: ``return after 5 s (FS_GCS_ENABLE = 1)``."""
    remedy: str = ""
    """Which setting to change where it is off."""


@dataclass(frozen=True, slots=True)
class VehicleFacts:
    """How a vehicle is built and set up: read when asked for, unlike telemetry."""

    firmware: str
    """Version; empty when it was not told."""
    board_id: str
    """Of the flight controller, in hexadecimal; empty when it has none."""
    link_loss: Safeguard
    """When our heartbeats are no longer heard."""
    low_battery: Safeguard
    fence: Geofence | None
    """None when no fence is stored."""
    at_fence: Safeguard
    return_height_m: float
    """Height above home to which it climbs, if it is lower, before it returns by itself."""
    return_climb_m: float
    """How far it climbs before that, however high it is."""
    return_settings: Mapping[str, float]
    """The autopilot's own settings that say both, for ``Vehicle.restore_return``."""


class Vehicle(Protocol):
    """One vehicle with a camera."""

    @property
    def state(self) -> VehicleState:
        """The latest telemetry. Policy: latest value, older ones are replaced."""
        ...

    async def execute(self, command: Command, deadline_s: float) -> None:
        """Carry the command out: acknowledged, repeated when lost, and confirmed by telemetry.

        Commands are never queued behind one another: a newer one for the same vehicle supersedes an older one that is
        still waiting for confirmation, and the older call raises ``CommandRefusedError``.

        Raises:
            CommandRefusedError: the autopilot said no, or the driver must not send it.
            CommandTimeoutError: no acknowledgement or no visible effect by ``deadline_s``.
        """
        ...

    async def inspect(self, deadline_s: float) -> VehicleFacts:
        """Ask the vehicle how it is set up. Costs a few dozen messages; nothing is changed.

        Raises:
            CommandRefusedError: the vehicle is not to be asked, or refuses to tell.
            CommandTimeoutError: not all was told by ``deadline_s``.
        """
        ...

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:
        """Replace the vehicle's fence, have it kept, and read back what is stored.

        Raises:
            CommandRefusedError: the vehicle does not take it, or stores another one.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def set_return_height(self, height_above_home_m: float, deadline_s: float) -> None:
        """Have the vehicle climb to this height, and no higher, before it returns by itself; only on the ground.

        A vehicle that is higher returns as high as it is. The vehicle has repeated the new values when this returns.

        Raises:
            CommandRefusedError: its motors run, or it keeps other values.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:
        """Set back ``VehicleFacts.return_settings`` that were read earlier; only on the ground.

        Raises:
            CommandRefusedError: its motors run, it keeps other values, or a setting says nothing of its return.
            CommandTimeoutError: not done by ``deadline_s``.
        """
        ...

    async def capture(self, deadline_s: float) -> Capture:
        """Expose one image now and fetch it.

        Raises:
            CaptureError: the camera refused, or no complete image with a pose arrived by ``deadline_s``.
        """
        ...


# --- links ----------------------------------------------------------------------------------------------------------


class Severity(StrEnum):
    """How much an operator should care."""

    INFO = "info"
    WARNING = "warning"
    NEWS = "news"
    """What the mission is flown for: to be noted before all warnings, though nothing is wrong."""
    CRITICAL = "critical"


@dataclass(frozen=True, slots=True)
class Notice:
    """Something worth telling the operator."""

    severity: Severity
    text: str
    vehicle_id: int | None = None


@dataclass(frozen=True, slots=True)
class DriverContext:
    """What a driver gets from the service that opens it."""

    clock: Clock
    is_healthy: Callable[[], bool]
    """Asked before each of our heartbeats: a coordinator that has stopped must fall silent, so that the vehicles' own
    link-loss failsafe works."""
    notify: Callable[[Notice], None]
    """Returns at once; may be called for every status text."""
    log_folder: Path | None = None
    """Where the driver records its raw traffic, if anywhere."""
    system_id: int = 254
    """Our own MAVLink system id."""
    options: Mapping[str, object] = field(default_factory=dict)
    """Settings of this driver alone."""


class Fleet(Protocol):
    """The vehicles that a driver has found."""

    def vehicles(self) -> Mapping[int, Vehicle]:
        """Return all vehicles ever heard, by id. A silent one stays, with an ageing ``heard_at_s``."""
        ...


class Driver(Protocol):
    """Entry point (group ``aos_gcs.drivers``) of a kind of link."""

    def __call__(self, links: Sequence[str], context: DriverContext) -> AbstractAsyncContextManager[Fleet]:
        """Open the links for as long as the context is entered.

        Raises:
            ConfigurationError: a link's text cannot be understood.
            LinkError: a link cannot be opened (for example, the port is taken).
        """
        ...
