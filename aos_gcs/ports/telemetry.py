"""Telemetry: the latest state of a vehicle, its link and its camera."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AboveHomeM, AmslM


class FlightMode(StrEnum):
    """Flight mode of a vehicle, across autopilots. ``VehicleState.mode_name`` keeps the autopilot's own word."""

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
    """Quality of the link to a vehicle; packet loss and age are in ``VehicleState``."""

    address: str
    """Address to which messages are sent now."""
    living_addresses: int = 1
    """Number of addresses, on all links together, at which the vehicle is heard."""
    round_trip_s: float | None = None
    clock_offset_s: float | None = None
    """The vehicle's clock minus ours; errs by at most half of the round trip."""
    clock_drift: float | None = None
    """Seconds that the vehicle's clock gains on ours per second."""
    telemetry_delay_s: float = 0.0
    """Age that its messages have when they are read, by its own clock; 0 where that is usual or not known."""


@dataclass(frozen=True, slots=True)
class ProvenLink:
    """An address at which a vehicle was proven to be in flight, and what it is known by there and elsewhere."""

    address: str
    """Address, with its link, in the driver's own words."""
    board_id: str = ""
    """Identifier of the flight controller, in hexadecimal; empty when it is not known."""
    since_boot_s: float | None = None
    """Seconds since it was started; None when that is not known."""
    is_signed: bool = False
    """Whether it signs its packets."""


@dataclass(frozen=True, slots=True)
class ComponentLink:
    """Link to a component of a vehicle beside its autopilot, such as a camera or a companion computer."""

    component_id: int
    name: str
    """MAVLink's name of the component, in words."""
    heard_at_s: float
    """Time at which its last message arrived."""


@dataclass(frozen=True, slots=True)
class CameraState:
    """Counts of the frames of a vehicle's camera since its link was opened."""

    source: str = ""
    """Source of the frames, in the driver's own word, such as ``component``."""
    frames: int = 0
    """Frames that were delivered."""
    refused: int = 0
    """Frames that came with a pose or a time that cannot be trusted."""
    late: int = 0
    """Frames that did not come by the deadline."""
    torn: int = 0
    """Frames that were incomplete at the deadline."""
    failed: int = 0
    """Frames that failed otherwise: the camera did not expose, or the file cannot be used."""
    problem: str = ""
    """Reason why the latest missing frame is missing; empty once a frame has been delivered since."""


@dataclass(frozen=True, slots=True)
class VehicleState:
    """The latest values a vehicle has reported; ``None`` means that it never did."""

    vehicle_id: int
    autopilot: str = "unknown"
    """``arducopter``, ``px4``, or ``unknown`` (observed, never commanded)."""
    mode: FlightMode = FlightMode.UNKNOWN
    mode_name: str = ""
    armed: bool = False
    armed_at_s: float | None = None
    """Time at which mode and ``armed`` arrived; None before the first heartbeat since the vehicle has started."""
    landed: LandedState = LandedState.UNKNOWN
    landed_at_s: float | None = None
    """Time at which ``landed`` arrived."""
    ready_to_arm: bool | None = None
    position: GeodeticPosition | None = None
    position_at_s: float | None = None
    """Time at which ``position`` was sent, where the vehicle's clock tells, or else arrived."""
    position_jumps_m: tuple[float, float] = (0.0, 0.0)
    """Sum, east and north, of what the position has jumped by where the velocity does not explain it."""
    height_above_home_m: AboveHomeM | None = None
    velocity_enu_mps: tuple[float, float, float] | None = None
    heading_rad: float | None = None
    """Clockwise from true north, [0, 2 pi)."""
    home: GeodeticPosition | None = None
    battery_fraction: float | None = None
    battery_at_s: float | None = None
    """Time at which ``battery_fraction`` arrived."""
    battery_voltage_v: float | None = None
    gps_fix: int | None = None
    """MAVLink's GPS_FIX_TYPE; 3 and above is a 3D fix."""
    satellites: int | None = None
    heard_at_s: float | None = None
    """Time at which the last message of the autopilot arrived; those of other components do not count."""
    components: tuple[ComponentLink, ...] = ()
    """Other components that have been heard, in the order of their ids."""
    packet_loss_fraction: float | None = None
    """Share of the vehicle's messages that never arrived, from gaps in its sequence numbers."""
    link: LinkQuality | None = None
    camera: CameraState | None = None
    text: str = ""
    """The latest status text of severity warning or worse."""
    hdop: float | None = None
    """Horizontal dilution of precision."""
    horizontal_accuracy_m: float | None = None
    """Standard deviation of the horizontal position, the largest that receiver and estimator report."""
    vertical_accuracy_m: float | None = None
    """Standard deviation of the altitude, the largest that receiver and estimator report."""
    altitude_test_ratio: float | None = None
    """Deviation of the estimated altitude from the sensors, as a share of what the estimator accepts; 1 is refused."""
    gps_altitude_amsl_m: AmslM | None = None
    """Altitude that the satellite receiver measures, before the autopilot fuses it."""
    pressure_hpa: float | None = None
    """Static pressure that the barometer measures."""
    is_ambiguous: bool = False
    """Two vehicles are heard with this id: neither is commanded."""
    estimator_problem: str = ""
    """What is wrong with the estimated position, as a clause; empty while nothing is known to be."""
    vibration_mps2: float | None = None
    """Largest level of vibration of the accelerometers, by the autopilot's own measure."""
    taken_over: str = ""
    """What shows that a pilot, another station or the autopilot itself flies it against our commands; empty if none."""
    has_pilot: bool = False
    """Whether that was ever more than the autopilot's own return or landing, since no command of ours was followed.

    It stays after the motors have stopped, until they run again, a command is sent or the vehicle is reclaimed.
    """
    proven: tuple[ProvenLink, ...] = ()
    """Addresses that its id belongs to while it is armed: others that use the id are strangers."""
    failsafe: str = ""
    """Status of the autopilot's failsafe while it is active, such as "critical": only return and land are sent."""
    board_id: str = ""
    """Identifier of the flight controller, in hexadecimal; empty when it is not known, and in older records."""
