"""The vehicles of a mission, with the task and the latest command of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import MissionError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AboveGroundM, AmslM
from aos_gcs.mission.fleet.datum import LaunchGround, same_place_m, standing_altitude_m
from aos_gcs.mission.fleet.energy import BatteryMeter
from aos_gcs.mission.fleet.layers import AltitudeLayers
from aos_gcs.mission.fleet.tasks import check_task, task_when_heard_again
from aos_gcs.mission.fleet.turn import Turn
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Clock, Command, Fleet, FlightMode, Hold, LandedState, Takeoff, Vehicle, VehicleState

_FOLLOWS_US = frozenset({FlightMode.GUIDED, FlightMode.HOLD, FlightMode.TAKEOFF})

_COMING_DOWN = frozenset({FlightMode.RETURN, FlightMode.LAND})
_LAYER_TOLERANCE_M = 1.0

_IN_AIR = frozenset({LandedState.TAKING_OFF, LandedState.IN_AIR, LandedState.LANDING})
_FRESH_S = 3.0
"""Age up to which a report counts as fresh: three heartbeats."""
_STANDING_MPS = 1.0
"""Speed above which a vehicle has not landed, whatever else it reports."""
_HIGH_M = 5.0
"""Height above its home above which a vehicle with running motors hovers rather than stands."""

FLYING = frozenset({Task.JOINING, Task.SWARM, Task.HELD, Task.RETURNING, Task.LANDING})
"""Tasks of vehicles whose motors we have started and which are still heard."""


@dataclass(slots=True)
class Member:
    """One vehicle in the mission."""

    vehicle_id: int
    vehicle: Vehicle
    _task: Task = field(default=Task.IDLE, init=False)
    _next_task: Task = field(default=Task.IDLE, init=False)
    is_chosen: bool = False
    """Whether it was chosen to fly the mission; ``Roster.choose`` sets it."""
    layer_height_m: float | None = None
    """Height of its altitude layer above the reference surface of all layers."""
    home_enu_m: NDArray[np.float64] | None = None
    """Launch point, where its autopilot returns to."""
    altitude_offset_m: float = 0.0
    """Altitude that it reports minus the one above the datum that all share; as taken on the ground."""
    altitude_doubt_m: float = 0.0
    """Error of its height that was found in flight; 0 while there is none."""
    position_doubt_m: float = 0.0
    """Horizontal distance by which its reports jumped: it may be at either place. 0 while they have not."""
    position_problem: str = ""
    """Lasting problem of its sensors that puts its position in doubt as a whole; empty while there is none."""
    is_inaccurate: bool = False
    """Whether its altitude was found less accurate in flight than the altitude layers bear."""
    height_above_ground_m: AboveGroundM | None = None
    """Height above the highest ground about it, by the elevation model; None where that is not known."""
    former_takeover: str = ""
    """What showed that it was taken over before its flight was taken up; empty once it is ours again."""
    former_has_pilot: bool = False
    """Whether that was a pilot or another station."""
    landing_enu_m: NDArray[np.float64] | None = None
    """Place where it lands; None: at home."""
    waypoint_enu_m: NDArray[np.float64] | None = None
    waypoint_task: Task | None = None
    """Task for which this station has sent it to its waypoint."""
    turn: Turn = field(default_factory=Turn)
    refusal: str | None = None
    last_command: Command | None = None
    """Latest command handed to the link and not refused; telemetry shows its effect up to seconds later."""
    safety_hold: Hold | None = None
    """Latest hold because safety kept it from being sent on; any other hold is somebody's order."""
    sent_at_s: float = -math.inf
    """Time of the latest command to move."""
    battery: BatteryMeter = field(default_factory=BatteryMeter)
    left_for_battery: str = ""
    """Problem of its battery for which it last had to leave the swarm; empty while it has none there."""
    is_ready: bool | None = None
    """Whether it is confirmed that it may take off for the relay; None: nobody has said so, and it has not flown."""
    leaves_in_s: float | None = None
    """Time until it is to leave for home by its battery; None while that is not known, or it stays to the end."""
    heard_again_at_s: float | None = None
    """Time since which the link of a lost vehicle is good, with its mode known; None while it is not."""

    @property
    def task(self) -> Task:
        """Present task of the vehicle; only ``Roster.assign`` changes it."""
        return self._task

    @property
    def is_held_by_order(self) -> bool:
        """Whether its latest command is a hold that safety alone did not cause."""
        return isinstance(self.last_command, Hold) and self.last_command is not self.safety_hold

    @property
    def task_when_heard_again(self) -> Task:
        """Task that the vehicle resumes when it is lost and heard again."""
        return self._next_task

    def _take_up(self, task: Task) -> None:
        check_task(self.vehicle_id, self._task, task)
        if task is Task.LOST and self._task is not Task.LOST:
            self._next_task = task_when_heard_again(self._task)
        if task in {Task.JOINING, Task.SWARM}:
            self.former_takeover, self.former_has_pilot = "", False
        self._task = task

    @property
    def is_reachable(self) -> bool:
        """Whether commands reach it: it is not lost, or it is heard again, though not for long enough yet."""
        return self._task is not Task.LOST or self.heard_again_at_s is not None

    @property
    def takes_part(self) -> bool:
        """Whether procedures for the whole swarm concern it: it was chosen, or has been given a task since."""
        return self.is_chosen or self._task is not Task.IDLE

    @property
    def state(self) -> VehicleState:
        """Latest telemetry."""
        return self.vehicle.state

    @property
    def airborne(self) -> bool:
        """True unless the vehicle is known to be on the ground and to stay there; in doubt it flies.

        While its motors run, one that moves, or is high and has not been coming down, is not believed to be there.
        """
        state, is_told_to_climb = self.state, isinstance(self.last_command, Takeoff)
        if not state.armed:
            return state.landed in _IN_AIR
        if is_told_to_climb or state.landed is not LandedState.ON_GROUND:
            return True
        is_high = state.height_above_home_m is not None and state.height_above_home_m > _HIGH_M
        is_moving = math.hypot(*state.velocity_enu_mps or ()) > _STANDING_MPS
        return is_moving or (is_high and state.mode not in _COMING_DOWN)

    @property
    def taken_over(self) -> str:
        """What shows that others fly it against our commands, also those of the station before; empty if none.

        A vehicle that its pilot has landed stays the pilot's until it counts as landed.
        """
        state = self.state
        if state.has_pilot and not state.armed and (self._task in FLYING or self.airborne):
            return "its pilot has stopped its motors"
        return state.taken_over or self.former_takeover

    @property
    def follows_us(self) -> bool:
        """False when a pilot, another station or the vehicle's own failsafe has taken over."""
        return self.follows_us_once_reclaimed and not self.taken_over

    @property
    def follows_us_once_reclaimed(self) -> bool:
        """Whether the vehicle hovers or flies in a mode from which an operator can give it back to this station."""
        return self.state.mode in _FOLLOWS_US and not self.state.failsafe

    @property
    def obeys_return(self) -> bool:
        """Whether the vehicle flies in a mode of ours, also in a failsafe: it returns and lands when told."""
        return self.state.mode in _FOLLOWS_US and not self.taken_over

    @property
    def has_pilot(self) -> bool:
        """Whether a pilot or another station flies the vehicle, or lands it, so that only commands by name reach it."""
        state = self.state
        had_pilot = state.has_pilot or (self.former_has_pilot and self.last_command is None)
        is_left_alone = had_pilot or state.mode not in _COMING_DOWN
        is_steered = self.airborne and state.mode is FlightMode.MANUAL
        return is_steered or (bool(self.taken_over) and is_left_alone)

    @property
    def why_not_ours(self) -> Refusal | None:
        """Reason why the vehicle does not follow us, as a clause; None while it does."""
        state, mode = self.state, self.state.mode_name or self.state.mode
        if self.follows_us:
            return None
        if state.failsafe:
            text = f"its failsafe is active ({state.failsafe}, mode {mode}): only return and land are sent to it"
            return Refusal(text)
        return Refusal(f"{self.taken_over or f'its mode changed to {mode}'}, not by this station")


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
            member.is_chosen = member in chosen
            if not member.takes_part:
                member.layer_height_m = None

    def chosen(self, *tasks: Task) -> list[Member]:
        """Return the members chosen to fly the mission, with one of ``tasks`` or any."""
        return [member for member in self.members(*tasks) if member.is_chosen]

    def assign_layers(
        self, members: Sequence[Member], homes_enu_m: Sequence[NDArray[np.float64]], layers_m: Sequence[float]
    ) -> None:
        """Give members their launch points, shape (3,) each, and layers; others that take no part lose a layer."""
        for member in self._members.values():
            member.layer_height_m = member.layer_height_m if member.takes_part else None
        for member, home_enu_m, layer_height_m in zip(members, homes_enu_m, layers_m, strict=True):
            member.home_enu_m, member.layer_height_m = home_enu_m, layer_height_m

    def settle_altitudes(self) -> None:
        """Take the offset of each vehicle's altitude from its ground, while it stands at its launch point.

        Autopilots move their altitude and their home when they are armed, so this goes on until the take-off. It stays
        in flight, and where a vehicle has landed elsewhere, on other ground.
        """
        if self.ground is None:
            return
        for member in self._members.values():
            if (altitude_m := standing_altitude_m(member.state)) is not None and self._is_at_launch_point(member):
                member.altitude_offset_m = altitude_m - self.ground.altitude_amsl_m(member.vehicle_id)

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
        is_moving = self.is_fresh(state.position_at_s) and math.hypot(*state.velocity_enu_mps or ()) > _STANDING_MPS
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
