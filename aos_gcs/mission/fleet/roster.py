"""The vehicles of a mission, with the task and the latest command of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.mission.fleet.datum import LaunchGround, same_place_m, standing_altitude_m
from aos_gcs.mission.fleet.layers import AltitudeLayers
from aos_gcs.mission.fleet.member import FLYING, STANDING_MPS, Member
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, Fleet, LandedState

_LAYER_TOLERANCE_M = 1.0
_FRESH_S = 3.0
"""Age up to which a report counts as fresh: three heartbeats."""


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Position of a vehicle that was converted."""

    reported: GeodeticPosition
    offset_m: float
    position_enu_m: NDArray[np.float64]
    """Shape (3,)."""


class Roster:
    """All vehicles heard, in the order of their ids, within one local frame."""

    def __init__(self, fleet: Fleet, clock: Clock) -> None:
        self._fleet = fleet
        self._clock = clock
        self._members: dict[int, Member] = {}
        self._places: dict[int, _Place] = {}
        """Position that was converted last, by vehicle."""
        self.frame: LocalFrame | None = None
        self.ground: LaunchGround | None = None
        """Ground at the launch points, as surveyed by preflight; None: altitudes are taken as they are reported."""
        self.layers = AltitudeLayers()

    def refresh(self) -> list[Member]:
        """Take in vehicles that the fleet has found since the last call, and return them."""
        found = [
            Member(vehicle_id, vehicle)
            for vehicle_id, vehicle in sorted(self._fleet.vehicles().items())
            if vehicle_id not in self._members
        ]
        self._members = dict(sorted((self._members | {member.vehicle_id: member for member in found}).items()))
        return found

    def assign(self, member: Member, task: Task) -> None:
        """Give a vehicle a task.

        Raises:
            TaskTransitionError: the task cannot follow the present one; the vehicle keeps that.
        """
        member._take_up(task)  # noqa: SLF001 - nobody else may

    def move_origin(self, origin: GeodeticPosition) -> None:
        """Set the origin of the mission's frame, also where there was another one."""
        self.frame = LocalFrame(origin)
        self._places.clear()

    def choose(self, vehicle_ids: Iterable[int]) -> None:
        """Set which vehicles fly the mission; those on the ground that do not lose their layers.

        Raises:
            MissionError: an id is unknown.
        """
        chosen = self.select(vehicle_ids)
        for member in self._members.values():
            member.choose(is_chosen=member in chosen)

    def chosen(self, *tasks: Task) -> list[Member]:
        """Return the members chosen to fly the mission, with one of ``tasks`` or any."""
        return [member for member in self.members(*tasks) if member.is_chosen]

    def assign_layers(
        self, members: Sequence[Member], homes_enu_m: Sequence[NDArray[np.float64]], layers_m: Sequence[float]
    ) -> None:
        """Give members their launch points, shape (3,) each, and layers; others that take no part lose a layer."""
        for member in self._members.values():
            if not member.takes_part:
                member.give_up_layer()
        for member, home_enu_m, layer_height_m in zip(members, homes_enu_m, layers_m, strict=True):
            member.take_place(home_enu_m, layer_height_m)

    def settle_altitudes(self) -> None:
        """Take the offset of each vehicle's altitude from its ground, while it stands at its launch point.

        Autopilots move their altitude and their home when they are armed, so this goes on until the take-off. It stays
        in flight, and where a vehicle has landed elsewhere, on other ground.
        """
        if self.ground is None:
            return
        for member in self._members.values():
            if (altitude_m := standing_altitude_m(member.state)) is not None and self._is_at_launch_point(member):
                member.settle_altitude(altitude_m - self.ground.altitude_amsl_m(member.vehicle_id))

    def _is_at_launch_point(self, member: Member) -> bool:
        here_enu_m, home_enu_m = self.position_enu_m(member), member.home_enu_m
        # Armed, a vehicle that does not join anew reports the altitude of the home that it was launched from.
        is_launched_once = member.task is Task.IDLE or (member.state.armed and member.task is not Task.JOINING)
        if is_launched_once or here_enu_m is None or home_enu_m is None:
            return True
        return float(np.hypot(*(here_enu_m - home_enu_m)[:2])) <= same_place_m(member.state)

    def launch_point_enu_m(self, member: Member) -> NDArray[np.float64] | None:
        """Return where a vehicle's home is, shape (3,), on the surveyed ground; None while it is not known."""
        home = member.state.home
        if self.frame is None or home is None:
            return None
        if self.ground is not None:
            home = replace(home, altitude_amsl_m=self.ground.altitude_amsl_m(member.vehicle_id))
        return self.frame.to_enu(home)

    def above_datum(self, member: Member, position: GeodeticPosition) -> GeodeticPosition:
        """Return a position that a vehicle or its camera reports, above the datum that all share."""
        if member.altitude_offset_m == 0.0:
            return position
        altitude_amsl_m = AmslM(position.altitude_amsl_m - member.altitude_offset_m)
        return GeodeticPosition(position.latitude_deg, position.longitude_deg, altitude_amsl_m)

    def members(self, *tasks: Task) -> list[Member]:
        """Return the members with one of ``tasks``, or all of them."""
        return [member for member in self._members.values() if not tasks or member.task in tasks]

    def airborne(self) -> list[Member]:
        """Return the members that fly and are still heard."""
        return [member for member in self._members.values() if member.airborne and member.task is not Task.LOST]

    def commandable(self) -> list[Member]:
        """Return the members to hold, return or land with all others: those that may fly and are heard."""
        return [member for member in self._members.values() if self.may_fly(member) and member.is_reachable]

    def is_landed(self, member: Member) -> bool:
        """Return whether fresh telemetry says: disarmed, on the ground, not moving. Nothing else counts as landed."""
        state = member.state
        is_moving = self.is_fresh(state.position_at_s) and math.hypot(*state.velocity_enu_mps or ()) > STANDING_MPS
        is_down = not state.armed and state.landed is LandedState.ON_GROUND and not is_moving
        return is_down and self.is_fresh(state.armed_at_s) and self.is_fresh(state.landed_at_s)

    def is_fresh(self, reported_at_s: float | None) -> bool:
        """Return whether a report has arrived within the last seconds."""
        return reported_at_s is not None and self._clock.now_s() - reported_at_s <= _FRESH_S

    def may_fly(self, member: Member) -> bool:
        """Return whether a vehicle is airborne, or flies for the mission and does not prove that it has landed."""
        return member.airborne or (member.task in FLYING and not self.is_landed(member))

    def select(self, vehicle_ids: Iterable[int]) -> list[Member]:
        """Return the members of these ids.

        Raises:
            MissionError: an id is unknown.
        """
        wanted = tuple(vehicle_ids)
        unknown = [vehicle_id for vehicle_id in wanted if vehicle_id not in self._members]
        if unknown:
            known = ", ".join(map(str, self._members)) or "none"
            raise MissionError(f"No vehicle {unknown[0]} in this mission; the vehicles are: {known}.")
        return [self._members[vehicle_id] for vehicle_id in dict.fromkeys(wanted)]

    def link_age_s(self, member: Member) -> float | None:
        """Return the seconds since the vehicle's last message."""
        heard_at_s = member.state.heard_at_s
        return None if heard_at_s is None else max(0.0, self._clock.now_s() - heard_at_s)

    def position_age_s(self, member: Member) -> float | None:
        """Return the seconds since the vehicle's last position."""
        position_at_s = member.state.position_at_s
        return None if position_at_s is None else max(0.0, self._clock.now_s() - position_at_s)

    def local_frame(self) -> LocalFrame:
        """Return the mission's frame.

        Raises:
            RuntimeError: preflight has not set it yet; a defect of the caller.
        """
        if self.frame is None:
            raise RuntimeError("the mission's origin is not known yet")
        return self.frame

    def position_enu_m(self, member: Member) -> NDArray[np.float64] | None:
        """Return the last reported position, shape (3,); None before the first one."""
        position = member.state.position
        if self.frame is None or position is None:
            return None
        known = self._places.get(member.vehicle_id)
        offset_m = member.altitude_offset_m
        if known is None or known.reported is not position or known.offset_m != offset_m:
            # Needed many times between two reports, above all by checks of each vehicle against each other.
            place_enu_m = self.frame.to_enu(self.above_datum(member, position))
            place_enu_m.setflags(write=False)
            known = self._places[member.vehicle_id] = _Place(position, offset_m, place_enu_m)
        return known.position_enu_m

    def positions_enu_m(self, members: Iterable[Member]) -> NDArray[np.float64]:
        """Return the last reported positions, shape (n, 3), of those vehicles that have reported one."""
        positions = [self.position_enu_m(member) for member in members]
        return np.array([position for position in positions if position is not None])

    def is_in_layer(self, member: Member) -> bool:
        """Return whether a vehicle is at the height of its altitude layer."""
        position_enu_m, column_enu_m = self.position_enu_m(member), self.own_column_enu_m(member)
        if position_enu_m is None or column_enu_m is None:
            return False
        return abs(float(position_enu_m[2] - column_enu_m[2])) <= _LAYER_TOLERANCE_M

    def own_column_enu_m(self, member: Member) -> NDArray[np.float64] | None:
        """Return the position in its layer straight above or below a vehicle, shape (3,)."""
        return self.layers.at(member, self.position_enu_m(member))

    def geodetic(self, member: Member, position_enu_m: NDArray[np.float64]) -> GeodeticPosition:
        """Return a point of the mission's frame as a vehicle has to be told it, with its own error of altitude."""
        place = self.local_frame().to_geodetic(position_enu_m)
        return replace(place, altitude_amsl_m=AmslM(place.altitude_amsl_m + member.altitude_offset_m))
