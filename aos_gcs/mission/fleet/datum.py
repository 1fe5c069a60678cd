"""The datum of heights that all vehicles share.

Autopilots report altitudes above mean sea level that err by metres, each by its own constant, and restart from the
receiver's when they are armed. What they know well is the height above the ground they stood on. All heights of a
mission are therefore that height plus the height of the ground at the launch point, above a datum that is the same for
all: measured, where every vehicle has an RTK fix; otherwise the ground at the launch site counts as level.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median

from aos_gcs.airspace.accuracy import CONFIDENCE
from aos_gcs.geometry.heights import AmslM, home_below_m
from aos_gcs.ports import Command, LandedState, Takeoff, VehicleState

RTK_FIXED = 6
"""MAVLink's GPS_FIX_TYPE of positions that are known to centimetres."""
RTK_FLOAT = 5
"""The same of positions that corrections have improved to decimetres."""
_SAME_PLACE_M = 1.0
"""Horizontal distance within which an exactly reported position is at a launch point."""
_MOST_ERROR_M = 3.0
"""Largest error of a reported position that is allowed for beyond that."""
_STANDING_M = 3.0
"""Height above or below home up to which a vehicle with running motors can stand where it was armed."""


@dataclass(frozen=True, slots=True)
class LaunchGround:
    """Altitudes of the ground below the launch points, above one datum."""

    level_amsl_m: AmslM
    """Altitude of the launch site: the middle one of those that the vehicles report."""
    measured_level_amsl_m: AmslM | None = None
    """The same by the receivers, where all have an RTK fix; None: the ground counts as level."""
    relief_m: Mapping[int, float] = field(default_factory=dict)
    """Height of the ground at each launch point above the level, by vehicle; 0 where there is none."""

    def altitude_amsl_m(self, vehicle_id: int) -> AmslM:
        """Return the altitude of the ground at a vehicle's launch point."""
        return AmslM(self.level_amsl_m + self.relief_m.get(vehicle_id, 0.0))

    def with_vehicle(self, state: VehicleState) -> LaunchGround:
        """Return the same ground with the launch point of one more vehicle, which stands there."""
        ground_m = measured_ground_m(state)
        if self.measured_level_amsl_m is None or ground_m is None:
            return self
        return self.with_relief(state.vehicle_id, ground_m - self.measured_level_amsl_m)

    def with_relief(self, vehicle_id: int, relief_m: float) -> LaunchGround:
        """Return the same ground with the launch point of one vehicle so much above the level."""
        return replace(self, relief_m={**self.relief_m, vehicle_id: relief_m})

    def measured_as(self, other: LaunchGround | None) -> LaunchGround:
        """Return the same ground, comparable with what is measured later, where another survey of it was measured."""
        if other is None or self.measured_level_amsl_m is not None:
            return self
        return replace(self, measured_level_amsl_m=other.measured_level_amsl_m)


def home_altitude_m(state: VehicleState) -> AmslM | None:
    """Return the altitude above mean sea level that a vehicle takes its home for; None before it has one.

    Altitude and height of the same packet belong together, also right after an autopilot has moved its home.
    """
    if state.home is None:
        return None
    if state.position is None or state.height_above_home_m is None:
        return state.home.altitude_amsl_m
    return home_below_m(state.position.altitude_amsl_m, state.height_above_home_m)


def standing_altitude_m(state: VehicleState) -> AmslM | None:
    """Return the altitude that a vehicle on the ground reports for the place below it; None in flight, or unknown.

    Before its motors start that is not its home's: autopilots move their home to where they are armed.
    """
    if not is_grounded(state):
        return None
    return home_altitude_m(state) if state.armed or state.position is None else state.position.altitude_amsl_m


def same_place_m(state: VehicleState) -> float:
    """Return the horizontal distance from its launch point at which a vehicle may be said to stand there."""
    return _SAME_PLACE_M + min(CONFIDENCE * (state.horizontal_accuracy_m or 0.0), _MOST_ERROR_M)


def survey_ground(states: Sequence[VehicleState]) -> LaunchGround | None:
    """Return the ground at the launch points of vehicles that stand on it; None while the home of one is not known."""
    homes_m = [home_m for state in states if (home_m := home_altitude_m(state)) is not None]
    if not homes_m or len(homes_m) < len(states):
        return None
    level = LaunchGround(AmslM(median(homes_m)))
    measured_m = [ground_m for state in states if (ground_m := measured_ground_m(state)) is not None]
    if len(measured_m) < len(states):
        return level
    ground = replace(level, measured_level_amsl_m=AmslM(median(measured_m)))
    for state in states:
        ground = ground.with_vehicle(state)
    return ground


def measured_ground_m(state: VehicleState) -> AmslM | None:
    """Return the altitude of the ground below a vehicle that stands there, where it is measured by RTK."""
    return state.gps_altitude_amsl_m if state.gps_fix == RTK_FIXED and is_grounded(state) else None


def is_grounded(state: VehicleState) -> bool:
    """Whether a vehicle is known to stand on the ground; its motors may run."""
    return state.landed is LandedState.ON_GROUND or (not state.armed and state.landed is LandedState.UNKNOWN)


def stands(state: VehicleState, last_command: Command | None) -> bool:
    """Whether a vehicle stands on the ground and is not about to leave it.

    Over a bad link a vehicle climbs for seconds before it reports that it has left the ground, and landing detectors
    are wrong at times: with running motors, one that is far above or below its home has not been launched from there.
    """
    height_m = state.height_above_home_m
    is_away = state.armed and height_m is not None and abs(height_m) > _STANDING_M
    return is_grounded(state) and not is_away and not isinstance(last_command, Takeoff)
