"""The flight controller of one vehicle: manoeuvres in, position set-points out. It knows nothing of MAVLink."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import TypeAlias

from aos_gcs.geometry.heights import AboveHomeM
from aos_sim.vehicle.kinematics import EnuPoint, Kinematics

BRAKING_MPS2 = 2.5
"""Deceleration assumed for the point where a vehicle stops when told to hold."""

ARRIVED_M = 0.3
LANDING_DETECTION_S = 1.0
LANDING_LOOKAHEAD_M = 3.0
"""A landing aims this far below the vehicle: deep enough for the full rate, near enough to hold the place in wind."""

FACE_TARGET_BEYOND_M = 2.0

FOLLOW_GAIN_PER_S = 1.0
"""Speed per metre that a followed position is away."""
LEAD_S = 5.0
LEAD_M = 10.0
"""A velocity is flown towards a point so far ahead that the vehicle never brakes for it."""
LEAST_SPEED_MPS = 1e-6
"""Stands for no speed where a speed limit must not be zero."""

Axes: TypeAlias = tuple[float | None, float | None, float | None]
"""East, north, up; None where an axis is free."""
FREE: Axes = (None, None, None)


@dataclass(frozen=True, slots=True)
class Motion:
    """Position and velocity that another program wants the vehicle to follow."""

    position_enu_m: Axes
    velocity_enu_mps: Axes
    heading_rad: float | None
    """None keeps the heading."""

    @property
    def place_enu_m(self) -> EnuPoint | None:
        """The position, where it is all that is wanted."""
        east_m, north_m, up_m = self.position_enu_m
        if east_m is None or north_m is None or up_m is None or self.velocity_enu_mps != FREE:
            return None
        return east_m, north_m, up_m


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Set-point of one vehicle for the dynamics."""

    lifting: bool
    target_enu_m: EnuPoint
    speed_mps: float
    climb_mps: float
    descent_mps: float
    heading_rad: float


@dataclass(frozen=True, slots=True)
class FlightSettings:
    """Limits and habits, taken from the autopilot's parameters."""

    speed_mps: float
    climb_mps: float
    descent_mps: float
    land_speed_mps: float
    land_slow_below_m: float
    """Height above the ground, which counts as high as home was measured, below which a landing goes slowly."""
    return_height_m: float
    """Least height above home on the way back."""
    return_climb_m: float
    """Least climb before the way back."""
    return_loiter_s: float
    """Pause above home before the landing."""
    disarm_landed_s: float
    """Time from touchdown to disarming."""
    disarm_idle_s: float
    """Time from arming to disarming when no take-off follows; 0: never."""
    face_target: bool
    """Turn towards each new target."""


class Manoeuvre(Enum):
    """Manoeuvre of the vehicle."""

    GROUNDED = auto()
    TAKEOFF = auto()
    POSITION = auto()
    """Flying to, or hovering at, a position."""
    FOLLOW = auto()
    """Following a :class:`Motion`."""
    RETURN_CLIMB = auto()
    RETURN_CRUISE = auto()
    RETURN_LOITER = auto()
    LAND = auto()


class FlightEvent(Enum):
    """Event that no command has caused."""

    TAKEOFF_COMPLETE = auto()
    LANDED = auto()
    DISARMED = auto()


class FlightController:
    """Manoeuvres of one multicopter.

    The caller checks whether a manoeuvre is allowed: this class flies it.
    """

    def __init__(self, settings: FlightSettings, kinematics: Kinematics) -> None:
        self.settings = settings
        self.armed = False
        self.manoeuvre = Manoeuvre.GROUNDED
        self.home_enu_m = kinematics.position_enu_m
        self._home_ground_up_m = kinematics.ground_up_m
        self._target_enu_m = kinematics.position_enu_m
        self._heading_rad = kinematics.heading_rad
        self._speed_override_mps: float | None = None
        self._climb_override_mps: float | None = None
        self._descent_override_mps: float | None = None
        self._motion = Motion(FREE, FREE, None)
        self._motion_lasts_s = math.inf
        self._phase_since_s = 0.0
        self._grounded_since_s: float | None = None
        self.setpoint = self._make_setpoint(kinematics)

    @property
    def target_enu_m(self) -> EnuPoint:
        """Position that the vehicle flies to or hovers at."""
        return self._target_enu_m

    @property
    def airborne(self) -> bool:
        """Whether the rotors carry the vehicle, or are about to."""
        return self.manoeuvre is not Manoeuvre.GROUNDED

    def arm(self, kinematics: Kinematics, now_s: float) -> None:
        """Start the motors; home becomes where the vehicle stands."""
        self.armed = True
        self.home_enu_m = kinematics.position_enu_m
        self._home_ground_up_m = kinematics.ground_up_m
        self._hold_here(kinematics)
        self._enter(Manoeuvre.GROUNDED, now_s)

    def disarm(self, kinematics: Kinematics, now_s: float) -> None:
        """Stop the motors at once, also in the air."""
        self.armed = False
        self.restore_speeds()
        self._hold_here(kinematics)
        self._enter(Manoeuvre.GROUNDED, now_s)

    def take_off(self, height_above_home_m: AboveHomeM, kinematics: Kinematics, now_s: float) -> None:
        """Climb straight up."""
        east_m, north_m, _ = kinematics.position_enu_m
        self._target_enu_m = (east_m, north_m, self.home_enu_m[2] + height_above_home_m)
        self._enter(Manoeuvre.TAKEOFF, now_s)

    def fly_to(
        self,
        target_enu_m: EnuPoint,
        kinematics: Kinematics,
        now_s: float,
        speed_mps: float | None = None,
        heading_rad: float | None = None,
    ) -> None:
        """Fly straight to a position and hover there; ``None`` keeps the speed or the heading rule."""
        if speed_mps is not None:
            self._speed_override_mps = speed_mps
        self._target_enu_m = target_enu_m
        if heading_rad is not None:
            self._heading_rad = heading_rad % (2 * math.pi)
        elif self.settings.face_target:
            self._face(target_enu_m, kinematics)
        self._enter(Manoeuvre.POSITION, now_s)

    def turn_to(self, heading_rad: float) -> None:
        """Turn to a heading, wherever it flies."""
        self._heading_rad = heading_rad % (2 * math.pi)

    def follow(self, motion: Motion, kinematics: Kinematics, now_s: float, lasts_s: float = math.inf) -> None:
        """Follow a motion, and stop unless another one comes within ``lasts_s``."""
        place_enu_m = motion.place_enu_m
        if place_enu_m is not None:
            self.fly_to(place_enu_m, kinematics, now_s, heading_rad=motion.heading_rad)
            return
        self._motion, self._motion_lasts_s = motion, lasts_s
        if motion.heading_rad is not None:
            self._heading_rad = motion.heading_rad % (2 * math.pi)
        self._enter(Manoeuvre.FOLLOW, now_s)

    def hold(self, kinematics: Kinematics, now_s: float) -> None:
        """Stop as soon as possible and hover."""
        velocity = kinematics.velocity_enu_mps
        # Beside and above it brakes on its own, as autopilots do: a fast climb forward ends where a slow one does.
        along_s, up_s = (math.hypot(*part) / (2 * BRAKING_MPS2) for part in (velocity[:2], velocity[2:]))
        east, north, up = kinematics.position_enu_m
        self._target_enu_m = (east + velocity[0] * along_s, north + velocity[1] * along_s, up + velocity[2] * up_s)
        self._enter(Manoeuvre.POSITION, now_s)

    def return_home(self, kinematics: Kinematics, now_s: float) -> None:
        """Climb to the return height if below it, by the least climb anyway, fly home at that height, land, disarm."""
        self.hold(kinematics, now_s)
        east_m, north_m, up_m = self._target_enu_m
        height_m = max(self.home_enu_m[2] + self.settings.return_height_m, up_m + self.settings.return_climb_m)
        self._target_enu_m = (east_m, north_m, height_m)
        self._enter(Manoeuvre.RETURN_CLIMB, now_s)

    def land(self, kinematics: Kinematics, now_s: float) -> None:
        """Descend where the vehicle is and disarm on the ground."""
        self.hold(kinematics, now_s)
        self._enter(Manoeuvre.LAND, now_s)

    def change_speed(
        self, speed_mps: float | None = None, climb_mps: float | None = None, descent_mps: float | None = None
    ) -> None:
        """Replace the speeds of the settings until they are restored, at the latest by disarming."""
        self._speed_override_mps = speed_mps or self._speed_override_mps
        self._climb_override_mps = climb_mps or self._climb_override_mps
        self._descent_override_mps = descent_mps or self._descent_override_mps

    def restore_speeds(self) -> None:
        """Go back to the speeds of the settings."""
        self._speed_override_mps = self._climb_override_mps = self._descent_override_mps = None

    def update(self, kinematics: Kinematics, now_s: float) -> list[FlightEvent]:
        """Advance the manoeuvre and the set-point; return what happened."""
        events = self._advance(kinematics, now_s) if self.armed else []
        self.setpoint = self._make_setpoint(kinematics)
        return events

    def _advance(self, kinematics: Kinematics, now_s: float) -> list[FlightEvent]:
        match self.manoeuvre:
            case Manoeuvre.TAKEOFF if self._distance_m(kinematics) < ARRIVED_M:
                self._enter(Manoeuvre.POSITION, now_s)
                return [FlightEvent.TAKEOFF_COMPLETE]
            case Manoeuvre.RETURN_CLIMB if self._distance_m(kinematics) < ARRIVED_M:
                self._target_enu_m = (*self.home_enu_m[:2], self._target_enu_m[2])
                if self.settings.face_target:
                    self._face(self._target_enu_m, kinematics)
                self._enter(Manoeuvre.RETURN_CRUISE, now_s)
            case Manoeuvre.RETURN_CRUISE if self._distance_m(kinematics) < ARRIVED_M:
                self._enter(Manoeuvre.RETURN_LOITER, now_s)
            case Manoeuvre.RETURN_LOITER if now_s - self._phase_since_s >= self.settings.return_loiter_s:
                self._enter(Manoeuvre.LAND, now_s)
            case Manoeuvre.FOLLOW if now_s - self._phase_since_s > self._motion_lasts_s:
                self.hold(kinematics, now_s)
            case Manoeuvre.LAND:
                return self._advance_landing(kinematics, now_s)
            case Manoeuvre.GROUNDED:
                idle_s = self.settings.disarm_idle_s
                if 0.0 < idle_s <= now_s - self._phase_since_s:
                    self.disarm(kinematics, now_s)
                    return [FlightEvent.DISARMED]
        return []

    def _advance_landing(self, kinematics: Kinematics, now_s: float) -> list[FlightEvent]:
        if not kinematics.on_ground:
            self._grounded_since_s = None
            return []
        if self._grounded_since_s is None:
            self._grounded_since_s = now_s
        if now_s - self._grounded_since_s < LANDING_DETECTION_S + self.settings.disarm_landed_s:
            return []
        self.disarm(kinematics, now_s)
        return [FlightEvent.LANDED, FlightEvent.DISARMED]

    def _enter(self, manoeuvre: Manoeuvre, now_s: float) -> None:
        self.manoeuvre = manoeuvre
        self._phase_since_s = now_s
        self._grounded_since_s = None

    def _hold_here(self, kinematics: Kinematics) -> None:
        self._target_enu_m = kinematics.position_enu_m
        self._heading_rad = kinematics.heading_rad

    def _distance_m(self, kinematics: Kinematics) -> float:
        return math.dist(self._target_enu_m, kinematics.position_enu_m)

    def _face(self, target_enu_m: EnuPoint, kinematics: Kinematics) -> None:
        east_m = target_enu_m[0] - kinematics.position_enu_m[0]
        north_m = target_enu_m[1] - kinematics.position_enu_m[1]
        if math.hypot(east_m, north_m) > FACE_TARGET_BEYOND_M:
            self._heading_rad = math.atan2(east_m, north_m) % (2 * math.pi)

    def _make_setpoint(self, kinematics: Kinematics) -> Setpoint:
        settings = self.settings
        if self.manoeuvre is Manoeuvre.FOLLOW:
            return self._following(kinematics)
        setpoint = Setpoint(
            lifting=self.armed and self.airborne,
            target_enu_m=self._target_enu_m,
            speed_mps=self._speed_override_mps or settings.speed_mps,
            climb_mps=self._climb_override_mps or settings.climb_mps,
            descent_mps=self._descent_override_mps or settings.descent_mps,
            heading_rad=self._heading_rad,
        )
        return self._landing(setpoint, kinematics) if self.manoeuvre is Manoeuvre.LAND else setpoint

    def _landing(self, setpoint: Setpoint, kinematics: Kinematics) -> Setpoint:
        """Return the set-point of a landing: straight down, slowly at the end."""
        rise_m = kinematics.ground_up_m - self._home_ground_up_m
        height_m = kinematics.position_enu_m[2] - self.home_enu_m[2] - rise_m
        slow = height_m < self.settings.land_slow_below_m
        east_m, north_m, _ = self._target_enu_m
        return replace(
            setpoint,
            target_enu_m=(east_m, north_m, kinematics.position_enu_m[2] - LANDING_LOOKAHEAD_M),
            descent_mps=self.settings.land_speed_mps if slow else setpoint.descent_mps,
        )

    def _following(self, kinematics: Kinematics) -> Setpoint:
        """Return the set-point of a motion: a point far ahead, at the motion's speed."""
        here_enu_m = kinematics.position_enu_m
        wanted_enu_mps = [
            (velocity_mps or 0.0) + (0.0 if place_m is None else FOLLOW_GAIN_PER_S * (place_m - here_m))
            for place_m, velocity_mps, here_m in zip(
                self._motion.position_enu_m, self._motion.velocity_enu_mps, here_enu_m, strict=True
            )
        ]
        speed_mps = max(math.hypot(*wanted_enu_mps), LEAST_SPEED_MPS)
        east_m, north_m, up_m = (
            here_m + (LEAD_S + LEAD_M / speed_mps) * wanted_mps if speed_mps > LEAST_SPEED_MPS else here_m
            for here_m, wanted_mps in zip(here_enu_m, wanted_enu_mps, strict=True)
        )
        self._target_enu_m = here_enu_m
        return Setpoint(
            lifting=self.armed,
            target_enu_m=(east_m, north_m, up_m),
            speed_mps=max(math.hypot(*wanted_enu_mps[:2]), LEAST_SPEED_MPS),
            climb_mps=max(wanted_enu_mps[2], LEAST_SPEED_MPS),
            descent_mps=max(-wanted_enu_mps[2], LEAST_SPEED_MPS),
            heading_rad=self._heading_rad,
        )
