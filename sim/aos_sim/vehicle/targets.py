"""SET_POSITION_TARGET_LOCAL_NED and SET_POSITION_TARGET_GLOBAL_INT, read as ArduCopter and as PX4 read them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_sim.vehicle.commands import AMSL_FRAMES, RELATIVE_FRAMES, TERRAIN_FRAMES
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.flight import FREE, Axes, Motion
from aos_sim.vehicle.kinematics import EnuPoint, Kinematics
from aos_sim.world.relief import Relief

BODY_FRAMES = (mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED)
OFFSET_FRAMES = (mavlink.MAV_FRAME_LOCAL_OFFSET_NED, *BODY_FRAMES)
_FIRST_POSITION_BIT = 0
_FIRST_VELOCITY_BIT = 3
_FIRST_ACCELERATION_BIT = 6


class UnsupportedTargetError(ValueError):
    """The autopilot does not fly such a target."""


@dataclass(frozen=True, slots=True)
class TargetRequest:
    """A target that another program asks for."""

    is_global: bool
    frame: int
    type_mask: int
    position: tuple[float, float, float]
    """Metres north, east, down; degrees and metres up where ``is_global``."""
    velocity_ned_mps: tuple[float, float, float]
    yaw_rad: float

    @classmethod
    def of(cls, message: mavlink.MAVLink_message) -> TargetRequest:
        """Read either message."""
        is_global = message.get_type() == "SET_POSITION_TARGET_GLOBAL_INT"
        if is_global:
            position = (message.lat_int / 1e7, message.lon_int / 1e7, message.alt)
        else:
            position = (message.x, message.y, message.z)
        velocity = (message.vx, message.vy, message.vz)
        return cls(is_global, message.coordinate_frame, message.type_mask, position, velocity, message.yaw)

    def ignores(self, first_bit: int, axis: int) -> bool:
        """Whether one of three neighbouring values is not meant."""
        return bool(self.type_mask >> (first_bit + axis) & 1)

    def ignores_any(self, first_bit: int) -> bool:
        """Whether at least one of three neighbouring values is not meant."""
        return any(self.ignores(first_bit, axis) for axis in range(3))

    def ignores_all(self, first_bit: int) -> bool:
        """Whether none of three neighbouring values is meant."""
        return all(self.ignores(first_bit, axis) for axis in range(3))

    @property
    def heading_rad(self) -> float | None:
        """Wanted heading, None where it is not meant."""
        return None if self.type_mask & mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE else self.yaw_rad

    @property
    def is_forced(self) -> bool:
        """Whether the accelerations are forces."""
        return bool(self.type_mask & mavlink.POSITION_TARGET_TYPEMASK_FORCE_SET)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Points of reference of a target."""

    frame: LocalFrame
    home_enu_m: EnuPoint
    kinematics: Kinematics
    relief: Relief | None = None
    """Shape of the ground; None: the plane z = 0."""

    @classmethod
    def of(cls, identity: VehicleIdentity, home_enu_m: EnuPoint, kinematics: Kinematics) -> Surroundings:
        """Return those of a vehicle."""
        return cls(identity.frame, home_enu_m, kinematics, identity.relief)

    def ground_amsl_m(self, latitude_deg: float, longitude_deg: float) -> float:
        """Return the altitude of the ground at a place."""
        origin_amsl_m = self.frame.origin.altitude_amsl_m
        if self.relief is None:
            return origin_amsl_m
        east_m, north_m, _ = self.frame.to_enu(GeodeticPosition(latitude_deg, longitude_deg, origin_amsl_m))
        return origin_amsl_m + float(self.relief.height_m(east_m, north_m))


def copter_motion(request: TargetRequest, around: Surroundings) -> Motion:
    """Return the motion that ArduCopter makes of a target in GUIDED.

    One ignored axis of the position or of the velocity leaves out all three. Accelerations alone are not simulated.

    Raises:
        UnsupportedTargetError: ArduCopter stops.
    """
    has_position = not request.ignores_any(_FIRST_POSITION_BIT)
    has_velocity = not request.ignores_any(_FIRST_VELOCITY_BIT)
    has_acceleration = not request.ignores_any(_FIRST_ACCELERATION_BIT)
    if not (has_position or has_velocity) or (has_position and not has_velocity and has_acceleration):
        raise UnsupportedTargetError
    if request.is_forced and has_acceleration:
        raise UnsupportedTargetError
    if not request.is_global and request.frame not in (mavlink.MAV_FRAME_LOCAL_NED, *OFFSET_FRAMES):
        raise UnsupportedTargetError
    turn_rad = around.kinematics.heading_rad if request.frame in BODY_FRAMES else 0.0
    heading_rad = request.heading_rad
    return Motion(
        _place(request, around, turn_rad) if has_position else FREE,
        _turned_enu(request.velocity_ned_mps, turn_rad) if has_velocity else FREE,
        None if heading_rad is None else heading_rad + turn_rad,
    )


def px4_motion(request: TargetRequest, around: Surroundings) -> Motion:
    """Return the motion that PX4 makes of a target in OFFBOARD, axis by axis. Accelerations are not simulated.

    Raises:
        UnsupportedTargetError: PX4 does not count it as a target.
    """
    has_acceleration = not request.ignores_all(_FIRST_ACCELERATION_BIT)
    if has_acceleration and request.is_forced:
        raise UnsupportedTargetError
    if not request.is_global and request.frame not in (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_NED):
        raise UnsupportedTargetError
    in_body = not request.is_global and request.frame == mavlink.MAV_FRAME_BODY_NED
    position, velocity = FREE, FREE
    if in_body:
        if not request.ignores_any(_FIRST_VELOCITY_BIT):
            velocity = _turned_enu(request.velocity_ned_mps, around.kinematics.heading_rad)
    else:
        velocity = _meant(request, _FIRST_VELOCITY_BIT, _turned_enu(request.velocity_ned_mps, 0.0))
        if not request.is_global or not request.ignores_any(_FIRST_POSITION_BIT):
            position = _meant(request, _FIRST_POSITION_BIT, _place(request, around, 0.0))
    if position == FREE and velocity == FREE and not has_acceleration:
        raise UnsupportedTargetError
    return Motion(position, velocity, request.heading_rad)


def _meant(request: TargetRequest, first_bit: int, enu: Sequence[float | None]) -> Axes:
    """Return a vector without its ignored axes; the bits are in the order north, east, down."""
    east, north, up = enu
    return (
        None if request.ignores(first_bit, 1) else east,
        None if request.ignores(first_bit, 0) else north,
        None if request.ignores(first_bit, 2) else up,
    )


def _turned_enu(north_east_down: tuple[float, float, float], turn_rad: float) -> tuple[float, float, float]:
    north, east, down = north_east_down
    sine, cosine = math.sin(turn_rad), math.cos(turn_rad)
    return sine * north + cosine * east, cosine * north - sine * east, -down


def _place(request: TargetRequest, around: Surroundings, turn_rad: float) -> EnuPoint:
    if request.is_global:
        return _global_place(request, around)
    here = around.kinematics.position_enu_m if request.frame in OFFSET_FRAMES else around.home_enu_m
    offset = _turned_enu(request.position, turn_rad)
    return here[0] + offset[0], here[1] + offset[1], here[2] + offset[2]


def _global_place(request: TargetRequest, around: Surroundings) -> EnuPoint:
    latitude_deg, longitude_deg, altitude_m = request.position
    if request.frame in RELATIVE_FRAMES:
        altitude_m += around.frame.origin.altitude_amsl_m + around.home_enu_m[2]
    elif request.frame in TERRAIN_FRAMES:
        altitude_m += around.ground_amsl_m(latitude_deg, longitude_deg)
    elif request.frame not in AMSL_FRAMES:
        raise UnsupportedTargetError
    east_m, north_m, up_m = around.frame.to_enu(GeodeticPosition(latitude_deg, longitude_deg, AmslM(altitude_m)))
    return float(east_m), float(north_m), float(up_m)
