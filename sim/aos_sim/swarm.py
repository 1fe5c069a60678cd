"""The simulated swarm: all vehicles of one process, with their links and images."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Coroutine, Mapping, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_sim.camera.component import CameraComponent, CameraView, Exposure
from aos_sim.camera.darkroom import Darkroom, check_camera_options
from aos_sim.camera.folder import ImageFolder
from aos_sim.camera.image import ImageSource
from aos_sim.camera.server import ImageServer
from aos_sim.camera.shutter import ArduPilotShutter, Px4Shutter, ShutterCamera
from aos_sim.clock import TICK_S, Pacer, SimTime
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.exposure import Motion
from aos_sim.errors.model import RTK, ErrorModel
from aos_sim.errors.position import PositionProcess
from aos_sim.links import Address, Endpoint, LinkAddress, open_endpoint
from aos_sim.report import ClearanceMonitor, SeparationMonitor, SwarmReport
from aos_sim.vehicle.arducopter import ArduCopter
from aos_sim.vehicle.autopilot import SimulatedAutopilot
from aos_sim.vehicle.battery import capacity_mah
from aos_sim.vehicle.configuration import VehicleIdentity
from aos_sim.vehicle.dynamics import AirframeLimits, Guidance, SwarmState, step
from aos_sim.vehicle.kinematics import Kinematics, read_kinematics
from aos_sim.vehicle.px4 import Px4
from aos_sim.vehicle.vehicle import SimulatedVehicle
from aos_sim.world.relief import Relief, ground_below

AUTOPILOTS: Mapping[str, type[SimulatedAutopilot]] = {"arducopter": ArduCopter, "px4": Px4}
SHUTTERS: Mapping[str, type[ShutterCamera]] = {"arducopter": ArduPilotShutter, "px4": Px4Shutter}

STEPS_TICKS = (1, 2, 5)
"""Lengths of a step of the dynamics: the checks of the fence are made at multiples of each."""

MAX_VEHICLES = 100
MAX_SYSTEM_ID = 250
"""Ids above are for ground stations."""

GRID_M = 5.0
MAX_LAUNCH_SPACING_M = 20.0
MAX_ROWS = 5
LEAST_COLUMNS = 10
HEADING_SIGMA_RAD = math.radians(5.0)
"""Vehicles are not put down perfectly aligned."""

DEFAULT_ORIGIN = GeodeticPosition(48.3, 14.3, AmslM(260.0))

MAX_BATTERY_S = 86_400.0
"""Greatest lifetime of a battery, and time on the ground."""
_LOW_BATTERY = 0.15
"""Share of a battery of a given lifetime at which its vehicle returns by itself."""


@dataclass(frozen=True, slots=True)
class SwarmOptions:
    """Settings of a simulated swarm.

    Raises:
        ConfigurationError: a value is out of its range.
    """

    vehicles: int = 10
    links: tuple[str, ...] = ("udpout://127.0.0.1:14550",)
    seed: int = 1
    speed: float = 1.0
    """Simulated seconds per real second; less is reached where the machine cannot keep up."""
    step_ticks: int | None = None
    """Ticks per step of the dynamics, 1, 2 or 5: more cost less and are less exact. No message is sent more often.

    None: as many as the speed has simulated seconds per real one, so that a fast flight fits into the real time."""
    autopilot: str = "arducopter"
    first_system_id: int = 1
    origin: GeodeticPosition = DEFAULT_ORIGIN
    image_size_px: int = 512
    fov_rad: float = math.radians(50.0)
    errors: ErrorModel = RTK
    """Errors of the vehicles and their cameras, and the wind."""
    launch_spacing_m: float = GRID_M
    """Distance of neighbouring launch points."""
    cameras: bool = True
    """Whether the vehicles have cameras of their own."""
    image_folder: Path | None = None
    """Folders for images by system id; the autopilots then trigger the cameras, and there is no camera component."""
    http_port: int = 0
    """Port of the image server; 0: any free one."""
    start_up_s: float | None = None
    """Simulated seconds until the vehicles can be armed; None: what the autopilot usually needs."""
    battery_s: float | None = None
    """Time in flight that a full battery lasts; None: as the autopilot's parameters say."""
    swap_s: float | None = None
    """Time on the ground after a flight until a full battery is in; None: nobody changes batteries."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Autopilot parameters that differ from the simulator's settings."""
    factory_settings: bool = False
    """Failsafes and fence as the manufacturer delivers them (mostly off), not as a careful operator sets them up."""

    def __post_init__(self) -> None:
        _check(1 <= self.vehicles <= MAX_VEHICLES, f"--vehicles must lie within 1 and 100, got {self.vehicles}.")
        _check(self.autopilot in AUTOPILOTS, f"--autopilot must be arducopter or px4, got {self.autopilot}.")
        _check(0.0 < self.speed <= 100.0, f"--speed must lie above 0 and at most 100, got {self.speed}.")
        _check(
            self.step_ticks is None or self.step_ticks in STEPS_TICKS,
            f"step_ticks must be 1, 2 or 5, got {self.step_ticks}.",
        )
        _check(
            1.0 <= self.launch_spacing_m <= MAX_LAUNCH_SPACING_M,
            f"--launch-spacing must lie within 1 and {MAX_LAUNCH_SPACING_M:g}, got {self.launch_spacing_m:g}.",
        )
        for name, value_s in (("--battery-life", self.battery_s), ("--swap", self.swap_s)):
            _check(
                value_s is None or 1.0 <= value_s <= MAX_BATTERY_S,
                f"{name} must lie within 1 and {MAX_BATTERY_S:g} seconds, got {value_s}.",
            )
        _check(self.seed >= 0, f"--seed must be 0 or more, got {self.seed}.")
        check_camera_options(self.image_size_px, self.fov_rad, self.http_port)
        _check(
            self.first_system_id >= 1 and self.first_system_id + self.vehicles - 1 <= MAX_SYSTEM_ID,
            f"System ids must lie within 1 and {MAX_SYSTEM_ID}; lower --first-system-id or --vehicles.",
        )
        _check(
            self.cameras or self.image_folder is None,
            "--image-folder needs cameras on board: leave --no-camera out.",
        )
        _check(bool(self.links), "At least one --link is needed.")

    def ticks_per_step(self) -> int:
        """Return the ticks per step, chosen by the speed where they are not set."""
        if self.step_ticks is not None:
            return self.step_ticks
        return max((ticks for ticks in STEPS_TICKS if ticks <= self.speed), default=STEPS_TICKS[0])


def _publisher(options: SwarmOptions) -> ImageServer | ImageFolder:
    if options.image_folder is None:
        return ImageServer(options.http_port)
    first = options.first_system_id
    return ImageFolder(options.image_folder, range(first, first + options.vehicles))


def _check(valid: bool, message: str) -> None:
    if not valid:
        raise ConfigurationError(message)


def home_positions_enu_m(count: int, relief: Relief | None = None, spacing_m: float = GRID_M) -> NDArray[np.float64]:
    """Return where vehicles stand, shape (count, 3): rows along east, going south from the origin.

    Args:
        count: number of vehicles.
        relief: shape of the ground; None: the plane z = 0.
        spacing_m: distance of neighbours.
    """
    columns = min(count, max(LEAST_COLUMNS, math.ceil(count / MAX_ROWS)))
    index = np.arange(count)
    east_m = (index % columns - (columns - 1) / 2) * spacing_m
    north_m = -(index // columns) * spacing_m
    homes_enu_m = np.column_stack([east_m, north_m, np.zeros(count)])
    homes_enu_m[:, 2] = ground_below(homes_enu_m, relief)
    return homes_enu_m


class SimulatedSwarm:
    """Vehicles that fly and talk for as long as the swarm is entered.

    Args:
        options: settings of the swarm.
        image_source: source of the cameras' images.
        relief: shape of the ground; None: the plane z = 0.

    Raises:
        ConfigurationError: a link or a parameter is unknown.
        LinkError: on entering, a port is taken.
    """

    def __init__(self, options: SwarmOptions, image_source: ImageSource, relief: Relief | None = None) -> None:
        self.options = options
        self._relief = relief
        self.frame = LocalFrame(options.origin)
        self._addresses = [LinkAddress.parse(link) for link in options.links]
        camera = CameraModel.from_fov(options.image_size_px, options.image_size_px, options.fov_rad)
        self._darkroom = Darkroom(image_source, camera, options.errors, options.seed, _publisher(options))
        self._rng = np.random.default_rng(options.seed)
        self._wind = options.errors.wind
        self._limits = AirframeLimits()
        self._step_ticks = options.ticks_per_step()
        self._step_s = self._step_ticks * TICK_S
        homes_enu_m = home_positions_enu_m(options.vehicles, relief, options.launch_spacing_m)
        self.state = SwarmState.at_rest(homes_enu_m, self._rng.normal(0.0, HEADING_SIGMA_RAD, len(homes_enu_m)))
        self.now = SimTime(0, start_utc_us=time.time_ns() // 1000)
        self.errors = PositionProcess(options.errors.position, options.vehicles, options.seed)
        self.attitude_errors = AttitudeProcess(options.errors.attitude, options.vehicles, options.seed)
        self._kinematics = self._read()
        self._homes_enu_m = homes_enu_m
        self.vehicles = [self._make_vehicle(index) for index in range(options.vehicles)]
        self._system_ids = [vehicle.system_id for vehicle in self.vehicles]
        self._separation = SeparationMonitor()
        self._clearance = ClearanceMonitor(homes_enu_m, relief)
        self._endpoints: list[list[Endpoint]] = [[] for _ in self.vehicles]
        self._stack = AsyncExitStack()
        self._group: asyncio.TaskGroup | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def start_utc_s(self) -> float:
        """Time since the Unix epoch, by the simulation's clock, at which the world began."""
        return self.now.start_utc_us / 1e6

    @property
    def homes_enu_m(self) -> dict[int, tuple[float, float, float]]:
        """Return the true launch point of each vehicle by system id."""
        return {
            vehicle.system_id: (east_m, north_m, up_m)
            for vehicle, (east_m, north_m, up_m) in zip(self.vehicles, self._homes_enu_m.tolist(), strict=True)
        }

    def kinematics(self, system_id: int) -> Kinematics:
        """Return the motion of one vehicle, as it is and as its autopilot believes it."""
        return self._kinematics[system_id - self.options.first_system_id]

    def vehicle(self, system_id: int) -> SimulatedVehicle:
        """Return one vehicle."""
        return self.vehicles[system_id - self.options.first_system_id]

    def report(self) -> SwarmReport:
        """Return how the flight went so far."""
        standing = zip(self.vehicles, self._kinematics, strict=True)
        return SwarmReport(
            sim_time_s=self.now.s,
            min_separation_m=self._separation.smallest_m,
            min_separation_pair=self._separation.pair,
            landed=sum(kinematics.on_ground and not vehicle.autopilot.flight.armed for vehicle, kinematics in standing),
            images=sum(vehicle.camera.image_count for vehicle in self.vehicles if vehicle.camera is not None),
            min_height_above_ground_m=self._clearance.smallest_m,
        )

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self._darkroom)
            for index in range(len(self.vehicles)):
                for address in self._addresses:
                    endpoint = await open_endpoint(address.for_vehicle(index), partial(self._receive, index))
                    stack.callback(endpoint.close)
                    self._endpoints[index].append(endpoint)
            self._group = await stack.enter_async_context(asyncio.TaskGroup())
            self._start(self._run())
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        for task in tuple(self._tasks):
            task.cancel()
        # The error of the body is none of the task group's: passed on, it would be wrapped into an ExceptionGroup.
        await self._stack.aclose()

    def _make_vehicle(self, index: int) -> SimulatedVehicle:
        options, kinematics = self.options, self._kinematics[index]
        autopilot = AUTOPILOTS[options.autopilot]
        factory = autopilot.FACTORY if options.factory_settings else {}
        identity = VehicleIdentity(
            system_id=options.first_system_id + index,
            frame=self.frame,
            uid=int(self._rng.integers(1, 2**62)),
            start_up_s=options.start_up_s,
            parameters={**factory, **self._battery_parameters(), **options.parameters},
            speed=options.speed,
            relief=self._relief,
        )
        vehicle = self._with_camera(autopilot(identity, kinematics))
        if options.swap_s is not None:
            vehicle.autopilot.battery.swap_s = options.swap_s
        return vehicle

    def _battery_parameters(self) -> dict[str, float]:
        """Return the parameters of a battery that lasts as long as it is to."""
        if self.options.battery_s is None:
            return {}
        full_mah = capacity_mah(self.options.battery_s)
        if self.options.autopilot == "px4":
            return {"BAT1_CAPACITY": full_mah}
        low_mah = 0.0 if self.options.factory_settings else _LOW_BATTERY * full_mah
        return {"BATT_CAPACITY": full_mah, "BATT_LOW_MAH": low_mah}

    def _with_camera(self, autopilot: SimulatedAutopilot) -> SimulatedVehicle:
        if not self.options.cameras:
            return SimulatedVehicle(autopilot, None)
        if self.options.image_folder is not None:
            return SimulatedVehicle(autopilot, SHUTTERS[self.options.autopilot](autopilot))
        return SimulatedVehicle(autopilot, CameraComponent(autopilot.identity.system_id, self._darkroom.camera))

    async def _run(self) -> None:
        pacer = Pacer(self.options.speed, tick_s=self._step_s)
        loop = asyncio.get_running_loop()
        while True:
            for _ in range(pacer.due_ticks(loop.time())):
                self._tick()
                await asyncio.sleep(0)
            await asyncio.sleep(pacer.delay_s(loop.time()))

    def _tick(self) -> None:
        self.now = self.now.later(self._step_ticks)
        self.errors.advance(self._step_s)
        self.attitude_errors.advance(self._step_s)
        guidance = _guidance(
            [vehicle.autopilot for vehicle in self.vehicles],
            self.errors.steered_enu_m,
            self.attitude_errors.estimate_rad[:, 2],
        )
        self.state = step(
            self.state,
            guidance,
            self._step_s,
            limits=self._limits,
            wind=self._wind,
            rng=self._rng,
            relief=self._relief,
        )
        self._kinematics = self._read()
        self._separation.update(self._system_ids, self.state.position_enu_m)
        self._clearance.update(self.state.position_enu_m)
        for index, vehicle in enumerate(self.vehicles):
            vehicle.update(self._kinematics[index], self.now)
            self._flush(index)

    def _read(self) -> list[Kinematics]:
        return read_kinematics(self.state, self.frame, self.errors, self.attitude_errors, relief=self._relief)

    def _receive(self, index: int, message: mavlink.MAVLink_message, _sender: Address) -> None:
        self.vehicles[index].handle(message, self._kinematics[index], self.now)
        self._flush(index)

    def _flush(self, index: int) -> None:
        vehicle = self.vehicles[index]
        data = vehicle.drain()
        if data:
            for endpoint in self._endpoints[index]:
                endpoint.send(data)
        if vehicle.camera is not None:
            for exposure in vehicle.camera.take_exposures():
                self._start(self._develop(index, vehicle.camera, exposure, self._motion(index), vehicle.view()))

    def _motion(self, index: int) -> Motion:
        state, roll_pitch_heading = self.state, self._kinematics[index].rates_radps
        return Motion(
            position_enu_m=state.position_enu_m[index],
            heading_rad=float(state.attitude_rad[index, 2]),
            velocity_enu_mps=state.velocity_enu_mps[index],
            rates_radps=roll_pitch_heading,
        )

    async def _develop(
        self, index: int, camera: CameraComponent | ShutterCamera, exposure: Exposure, motion: Motion, view: CameraView
    ) -> None:
        """Make the image of an exposure and announce it."""
        url = await self._darkroom.develop(exposure, motion)
        camera.image_ready(exposure, view, url)
        self._flush(index)

    def _start(self, work: Coroutine[None, None, None]) -> None:
        if self._group is None:
            raise RuntimeError("The swarm is not running: enter it as a context manager.")
        task = self._group.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _guidance(
    autopilots: Sequence[SimulatedAutopilot], error_enu_m: NDArray[np.float64], heading_error_rad: NDArray[np.float64]
) -> Guidance:
    """Return the set-points in true positions and headings: an autopilot that errs flies elsewhere."""
    setpoints = [autopilot.setpoint for autopilot in autopilots]
    return Guidance(
        lifting=np.array([setpoint.lifting for setpoint in setpoints]),
        target_enu_m=np.array([setpoint.target_enu_m for setpoint in setpoints]) - error_enu_m,
        speed_mps=np.array([setpoint.speed_mps for setpoint in setpoints]),
        climb_mps=np.array([setpoint.climb_mps for setpoint in setpoints]),
        descent_mps=np.array([setpoint.descent_mps for setpoint in setpoints]),
        heading_rad=np.array([setpoint.heading_rad for setpoint in setpoints]) - heading_error_rad,
    )
