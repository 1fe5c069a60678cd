"""One vehicle of a mission: its task, its place in the swarm, and what was found out about it.

What several modules change, or what changes together, is changed by methods; every other field has one module that
sets it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.heights import AboveGroundM
from aos_gcs.mission.fleet.energy import BatteryMeter
from aos_gcs.mission.fleet.tasks import check_task, task_when_heard_again
from aos_gcs.mission.fleet.turn import Turn
from aos_gcs.mission.model.actions import Refusal
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.ports import Command, FlightMode, Hold, LandedState, Takeoff, Vehicle, VehicleState

_FOLLOWS_US = frozenset({FlightMode.GUIDED, FlightMode.HOLD, FlightMode.TAKEOFF})
_COMING_DOWN = frozenset({FlightMode.RETURN, FlightMode.LAND})
_IN_AIR = frozenset({LandedState.TAKING_OFF, LandedState.IN_AIR, LandedState.LANDING})
STANDING_MPS = 1.0
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
    """Whether it was chosen to fly the mission."""
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

    def choose(self, *, is_chosen: bool) -> None:
        """Have it fly the mission, or not; where it does not and takes no part either, its layer is free."""
        self.is_chosen = is_chosen
        if not self.takes_part:
            self.give_up_layer()

    def take_place(self, home_enu_m: NDArray[np.float64], layer_height_m: float | None) -> None:
        """Give it its launch point, shape (3,), and its altitude layer."""
        self.home_enu_m, self.layer_height_m = home_enu_m, layer_height_m

    def move_home(self, home_enu_m: NDArray[np.float64] | None) -> None:
        """Set its launch point alone, shape (3,); None: it is not known."""
        self.home_enu_m = home_enu_m

    def give_up_layer(self) -> None:
        """Leave its altitude layer to others."""
        self.layer_height_m = None

    def settle_altitude(self, offset_m: float) -> None:
        """Set by how much the altitude that it reports is above that of the datum that all share."""
        self.altitude_offset_m = offset_m

    def go_on(self, taken_over: str, waypoint_enu_m: NDArray[np.float64] | None, *, has_pilot: bool) -> None:
        """Take up its flight from a station that broke off.

        Args:
            taken_over: what showed there that others fly it; empty if nothing did.
            waypoint_enu_m: its last waypoint there, shape (3,); None if it had none.
            has_pilot: whether these were a pilot or another station.
        """
        self.former_takeover, self.former_has_pilot = taken_over, has_pilot
        if waypoint_enu_m is not None:
            self.waypoint_enu_m = waypoint_enu_m

    def send_to(self, waypoint_enu_m: NDArray[np.float64]) -> None:
        """Note the waypoint, shape (3,), to which it is sent for its present task."""
        self.waypoint_enu_m, self.waypoint_task = waypoint_enu_m, self._task

    def hold_for_safety(self) -> Hold:
        """Return the hold that safety, and nobody's order, has it told."""
        self.safety_hold = Hold()
        return self.safety_hold

    def keep_back(self, reason: str | None) -> None:
        """Note why it is not sent on; None: it is."""
        self.refusal = reason

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
        is_moving = math.hypot(*state.velocity_enu_mps or ()) > STANDING_MPS
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
