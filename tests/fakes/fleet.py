"""A fleet without any link: vehicles that fly straight lines on the mission's clock and see a warm spot below."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import astuple, dataclass, field, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import CaptureError, CommandRefusedError, CommandTimeoutError, NoIntervalError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.ports import (
    Arm,
    Capture,
    Clock,
    Command,
    Disarm,
    FlightMode,
    Geofence,
    Goto,
    Hold,
    Land,
    LandedState,
    LinkQuality,
    ReturnToLaunch,
    Takeoff,
    VehicleFacts,
    VehicleState,
)
from tests.fakes.good_facts import GOOD_FACTS
from tests.fakes.ground import look_down
from tests.fakes.interval import FakeInterval
from tests.fakes.position_errors import FakeErrors

ORIGIN = GeodeticPosition(48.3, 14.3, 260.0)
FRAME = LocalFrame(ORIGIN)
CAMERA = CameraModel.from_fov(96, 96, math.radians(50.0))
BANDS = ("red", "green", "blue", "thermal")
SILENCE_S = 5.0
"""Age of the last message after which only commands that make a flight safer are sent."""
MAX_FENCE_POINTS = 100
_ALWAYS_SENT = (Hold, ReturnToLaunch, Land)
_POLL_S = 0.2
_TIME_RESOLUTION_S = 1e-6


@lru_cache(maxsize=256)
def _home(east_m: float, north_m: float, up_m: float) -> GeodeticPosition:
    return FRAME.to_geodetic((east_m, north_m, up_m))


@dataclass
class FakeVehicle:
    """Flies instantly accelerating straight lines; ``state`` is computed from the clock, so it owns no task."""

    vehicle_id: int
    clock: Clock
    home_enu_m: NDArray[np.float64]
    target_enu_m: NDArray[np.float64] | None
    start_enu_m: NDArray[np.float64] = field(init=False)
    goal_enu_m: NDArray[np.float64] = field(init=False)
    started_s: float = 0.0
    speed_mps: float = 10.0
    heading_rad: float = 0.0  # it turns at once, to north or south
    turns: bool = True
    errors: FakeErrors = field(default_factory=partial(FakeErrors, 0))
    gps_fix: int = 6
    horizontal_accuracy_m: float | None = 0.015
    vertical_accuracy_m: float | None = 0.03
    altitude_test_ratio: float | None = None
    armed: bool = False
    mode: FlightMode = FlightMode.GUIDED
    battery_fraction: float = 0.9
    silent_since_s: float | None = None
    heartbeat_silent_since_s: float | None = None
    camera_works: bool = True
    camera_delay_s: float = 0.0
    has_interval: bool = False
    """Whether its camera takes images by itself."""
    least_period_s: float = 0.0
    """Least time between two of those."""
    running: FakeInterval | None = None
    """Interval in which the camera takes images by itself, while it does."""
    reported_north_m: float = 0.0
    reported_landed: LandedState | None = None
    """What it says about standing on the ground, where that is not the truth."""
    refuses: frozenset[type] = frozenset()
    commands: list[Command] = field(default_factory=list)
    images: int = 0
    fence: Geofence | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    """Fields of its facts that differ from good ones."""
    return_height_m: float = 30.0
    keeps_return_height: bool = False
    battery_silent_since_s: float | None = None
    estimator_problem: str = ""
    vibration_mps2: float | None = None
    clock_drift: float | None = None
    taken_over: str = ""
    has_pilot: bool = False
    failsafe: str = ""
    others: tuple[tuple[float, float, float], ...] = ()
    """Other things that its camera sees: east, north, degrees Celsius."""
    bands: tuple[str, ...] = BANDS
    """Bands of its camera, some of ``BANDS``."""
    inspections: int = 0
    uploads: int = 0
    _newest: Command | None = None
    _generation: int = 0
    _computed: tuple[float, VehicleState] | None = None
    """State and its time, until anything about the vehicle changes."""

    def __post_init__(self) -> None:
        self.start_enu_m = self.goal_enu_m = self.home_enu_m

    def true_enu_m(self) -> NDArray[np.float64]:
        """Return where the vehicle is, whatever it believes."""
        return self.position_enu_m() - self.errors.estimate_enu_m(self.clock.now_s())

    def position_enu_m(self) -> NDArray[np.float64]:
        """Return where the vehicle believes to be."""
        now_s = self.clock.now_s() if self.silent_since_s is None else self.silent_since_s
        way_m = self.goal_enu_m - self.start_enu_m
        length_m = math.hypot(*way_m.tolist())
        flown_m = self.speed_mps * (now_s - self.started_s)
        # There to the last bit: who misses it by a rounding error would never arrive.
        return self.goal_enu_m if flown_m >= length_m else self.start_enu_m + way_m * flown_m / length_m

    def is_moving(self) -> bool:
        return self.position_enu_m() is not self.goal_enu_m

    def fly_to(self, goal_enu_m: NDArray[np.float64]) -> None:
        self.start_enu_m, self.started_s = self.position_enu_m(), self.clock.now_s()
        self.goal_enu_m = np.asarray(goal_enu_m, dtype=np.float64)

    @property
    def state(self) -> VehicleState:
        """State at the present time. The mission reads it many times per moment, so it is computed once for each."""
        computed, now_s = self._computed, self.clock.now_s()
        if computed is None or computed[0] != now_s:
            computed = self._computed = (now_s, self._compute_state())
        return computed[1]

    def __setattr__(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)
        if name != "_computed":
            object.__setattr__(self, "_computed", None)

    def _compute_state(self) -> VehicleState:
        now_s, position_enu_m = self.clock.now_s(), self.position_enu_m()
        up_m, home_up_m = float(position_enu_m[2]), float(self.home_enu_m[2])
        true_up_m, on_ground = up_m - self.errors.estimate_up_m(now_s), up_m <= home_up_m + 0.01
        if on_ground and self.mode in {FlightMode.LAND, FlightMode.RETURN}:
            self.armed = False
        heard_at_s = now_s if self.silent_since_s is None else self.silent_since_s
        east_m, north_m, rise_m = (self.goal_enu_m - self.start_enu_m).tolist()
        is_there = position_enu_m is self.goal_enu_m
        share = 0.0 if is_there else self.speed_mps / math.hypot(east_m, north_m, rise_m)
        return VehicleState(
            vehicle_id=self.vehicle_id,
            autopilot="arducopter",
            mode=self.mode,
            mode_name=self.mode.upper(),
            armed=self.armed,
            armed_at_s=heard_at_s if self.heartbeat_silent_since_s is None else self.heartbeat_silent_since_s,
            landed=self.reported_landed or (LandedState.ON_GROUND if on_ground else LandedState.IN_AIR),
            landed_at_s=heard_at_s,
            ready_to_arm=True,
            position=FRAME.to_geodetic(position_enu_m + np.array([0.0, self.reported_north_m, 0.0])),
            position_at_s=heard_at_s,
            position_jumps_m=(0.0, self.reported_north_m),
            height_above_home_m=up_m - home_up_m,
            velocity_enu_mps=(east_m * share, north_m * share, rise_m * share),
            heading_rad=self.heading_rad,
            home=_home(*self.home_enu_m.tolist()),
            battery_fraction=self.battery_fraction,
            battery_at_s=heard_at_s if self.battery_silent_since_s is None else self.battery_silent_since_s,
            gps_fix=self.gps_fix,
            estimator_problem=self.estimator_problem,
            vibration_mps2=self.vibration_mps2,
            link=None if self.clock_drift is None else LinkQuality("a", clock_drift=self.clock_drift),
            satellites=12,
            heard_at_s=heard_at_s,
            taken_over=self.taken_over,
            has_pilot=self.has_pilot,
            failsafe=self.failsafe,
            horizontal_accuracy_m=self.horizontal_accuracy_m,
            vertical_accuracy_m=self.vertical_accuracy_m,
            altitude_test_ratio=self.altitude_test_ratio,
            gps_altitude_amsl_m=ORIGIN.altitude_amsl_m + true_up_m + self.errors.receiver_up_m(now_s),
            pressure_hpa=1013.25 * (1.0 - (ORIGIN.altitude_amsl_m + true_up_m) / 44330.77) ** 5.25588,
            board_id=f"{self.vehicle_id:08x}",
        )

    def reclaim(self) -> None:
        self.taken_over, self.has_pilot = "", False

    async def execute(self, command: Command, deadline_s: float) -> None:
        self.commands.append(command)
        self._check_silence(command)
        self._check_sense(command)
        self._newest, self._generation = command, self._generation + 1
        generation = self._generation

        def check() -> None:
            self._check_silence(command)
            if self._generation != generation:
                raise self._refusal(f"{type(command).__name__} is superseded by {type(self._newest).__name__}")

        await self._wait(self._is_heard, deadline_s, check)
        if type(command) in self.refuses:
            raise CommandRefusedError(f"{type(command).__name__} denied")
        self._obey(command)
        if isinstance(command, Takeoff):
            await self._wait(lambda: self._is_heard() and not self.is_moving(), deadline_s, check)

    def _check_silence(self, command: Command) -> None:
        silence_s = 0.0 if self.silent_since_s is None else self.clock.now_s() - self.silent_since_s
        if silence_s > SILENCE_S and not isinstance(command, _ALWAYS_SENT):
            raise self._refusal(f"has been silent for {silence_s:.0f} s: only hold, return and land are sent to it")

    def _check_sense(self, command: Command) -> None:
        state = self.state
        is_grounded = not state.armed or state.landed is LandedState.ON_GROUND
        match command:
            case Arm() | Takeoff() | Goto() if self.taken_over:
                raise self._refusal(f"was taken over: {self.taken_over}. Resume it first")
            case Arm() | Takeoff() | Goto() | Hold() if self.failsafe:
                raise self._refusal(f"is in a failsafe ({self.failsafe}): only return and land are sent to it")
            case Disarm() if state.landed is not LandedState.ON_GROUND:
                raise self._refusal("does not report that it is on the ground: land it before disarming")
            case Takeoff() if not state.armed:
                raise self._refusal("is not armed: arm it before takeoff")
            case Goto(position) if not all(map(math.isfinite, astuple(position))):
                raise self._refusal(f"cannot go there: the position {astuple(position)} is not finite")
            case Goto(heading_rad=float(heading_rad)) if not math.isfinite(heading_rad):
                raise self._refusal(f"cannot turn to a heading of {heading_rad} rad")
            case Goto() if is_grounded:
                raise self._refusal("cannot go there: it is not flying, take off first")

    def _refusal(self, reason: str) -> CommandRefusedError:
        return CommandRefusedError(f"vehicle {self.vehicle_id} {reason}")

    def _is_heard(self) -> bool:
        return self.silent_since_s is None

    async def _wait(
        self, is_done: Callable[[], bool], deadline_s: float, check: Callable[[], None] = lambda: None
    ) -> None:
        """Return when it is done; ``check`` raises when it must not go on.

        Raises:
            CommandTimeoutError: not done by ``deadline_s``.
        """
        while not is_done():
            check()
            left_s = deadline_s - self.clock.now_s()
            if left_s <= _TIME_RESOLUTION_S:
                raise CommandTimeoutError(f"vehicle {self.vehicle_id} does not answer in time: check link and vehicle")
            await self.clock.sleep(min(_POLL_S, left_s))
        check()

    def _obey(self, command: Command) -> None:
        position_enu_m = self.position_enu_m()
        match command:
            case Arm():
                self.mode, self.armed = FlightMode.GUIDED, True
                self.home_enu_m = position_enu_m
            case Disarm():
                self.armed = False
            case Takeoff(height_above_home_m):
                self.mode = FlightMode.GUIDED
                self.fly_to(self.home_enu_m + np.array([0.0, 0.0, height_above_home_m]))
            case Goto(position, speed_mps, heading_rad):
                self.fly_to(FRAME.to_enu(position))
                self.mode, self.speed_mps = FlightMode.GUIDED, speed_mps
                if heading_rad is not None and self.turns:
                    self.heading_rad = heading_rad
            case Hold():
                self.mode = FlightMode.HOLD
                self.fly_to(position_enu_m)
            case ReturnToLaunch():
                self.mode = FlightMode.RETURN
                self.fly_to(self.home_enu_m)
            case Land():
                self.mode = FlightMode.LAND
                self.fly_to(np.array([*position_enu_m[:2], self.home_enu_m[2]]))

    async def inspect(self, deadline_s: float) -> VehicleFacts:
        await self._wait(self._is_heard, deadline_s)
        self.inspections += 1
        own = {
            "board_id": self.state.board_id,
            "fence": self.fence,
            "return_height_m": self.return_height_m,
            "return_settings": {"RTL_ALT": 100.0 * self.return_height_m},
        }
        return replace(GOOD_FACTS, **own | self.facts)

    async def upload_fence(self, fence: Geofence, deadline_s: float) -> None:
        await self._wait(self._is_heard, deadline_s)
        points = sum(map(len, (fence.inclusion_deg, *fence.exclusions_deg)))
        if Geofence in self.refuses or points > MAX_FENCE_POINTS:
            raise self._refusal(f"refuses a geofence of {points} points: no space")
        self.uploads += 1
        self.fence = fence

    async def set_return_height(self, height_above_home_m: float, deadline_s: float) -> None:
        if not (math.isfinite(height_above_home_m) and height_above_home_m > 0.0):
            raise CommandRefusedError(f"a return height of {height_above_home_m} m is impossible")
        await self.restore_return({"RTL_ALT": 100.0 * height_above_home_m}, deadline_s)

    async def restore_return(self, settings: Mapping[str, float], deadline_s: float) -> None:
        await self._wait(self._is_heard, deadline_s)
        if strange := settings.keys() - {"RTL_ALT"}:
            raise CommandRefusedError(f"{min(strange)} is not a return setting of vehicle {self.vehicle_id}")
        if self.state.armed:
            raise CommandRefusedError(f"vehicle {self.vehicle_id} is armed: its return settings stay")
        if self.keeps_return_height:
            raise CommandRefusedError("it keeps RTL_ALT")
        self.return_height_m = settings["RTL_ALT"] / 100.0

    async def capture(self, deadline_s: float) -> Capture:
        if self.running is not None:
            raise CaptureError(f"vehicle {self.vehicle_id} is already taking an image")
        await self._wait_for_camera(deadline_s)
        if self.camera_delay_s:
            await self.clock.sleep(self.camera_delay_s)
        return self._expose()

    @asynccontextmanager
    async def interval(self, period_s: float, deadline_s: float) -> AsyncIterator[FakeInterval]:
        if not self.has_interval:
            raise NoIntervalError("the camera has none")
        await self._wait_for_camera(deadline_s)
        period_s = max(period_s, self.least_period_s)
        self.running = FakeInterval(self.clock, period_s, lambda: self.camera_delay_s, self._expose_if_it_works)
        try:
            yield self.running
        finally:
            self.running = None

    def _answers(self) -> bool:
        return self.camera_works and self.silent_since_s is None

    async def _wait_for_camera(self, deadline_s: float) -> None:
        if not self._answers():
            await self.clock.sleep(max(0.0, deadline_s - self.clock.now_s()))
            raise CaptureError("the camera delivers nothing")

    def _expose_if_it_works(self) -> Capture | None:
        return self._expose() if self._answers() else None

    def _expose(self) -> Capture:
        self.images += 1
        pose = nadir_pose(self.position_enu_m(), self.heading_rad)
        target = [] if self.target_enu_m is None else [(*self.target_enu_m, 28.0)]
        look = look_down(self.vehicle_id, self.images, CAMERA, self.true_enu_m(), [*target, *self.others])
        view = look[..., [BANDS.index(band) for band in self.bands]]
        return Capture(
            vehicle_id=self.vehicle_id,
            image_index=self.images,
            utc_s=self.clock.utc_s(),
            image=view[::-1, ::-1] if math.cos(self.heading_rad) < 0.0 else view,
            bands=self.bands,
            position=FRAME.to_geodetic(pose.position_enu_m),
            R_cam2enu=pose.R_cam2enu,
            camera=CAMERA,
        )


class FakeFleet:
    """Vehicles on a row of launch points 5 m apart, on level ground, each with errors of its own."""

    def __init__(
        self, clock: Clock, n: int, target_enu_m: tuple[float, float] | None, errors: Mapping[str, Any] | None = None
    ) -> None:
        target = None if target_enu_m is None else np.array(target_enu_m)
        self.members = {}
        for i in range(n):
            own = FakeErrors(i + 1, **(errors or {}))
            home_enu_m = np.array([5.0 * (i - (n - 1) / 2), 0.0, 0.0]) + own.estimate_enu_m(0.0)
            self.members[i + 1] = FakeVehicle(i + 1, clock, home_enu_m, target, errors=own)

    def vehicles(self) -> Mapping[int, FakeVehicle]:
        return self.members
