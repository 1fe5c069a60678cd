"""Whole missions of the real driver with simulated autopilots over a radio with faults, in virtual time."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_drivers.frames.files.fetching import Download, ImageFetcher
from aos_drivers.mavlink.service import MavlinkFleet, open_mavlink
from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, PreflightSettings
from aos_gcs.ports import DriverContext
from aos_sim.camera.image import ImageSource
from aos_sim.camera.server import ImageServer
from aos_sim.clock import Pacer
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from aos_sim.world.relief import Relief
from tests.fakes.air import GCS, Air, targets
from tests.fakes.frozen import StationLoop, station
from tests.fakes.mission_flight import InlineExecutor, MemoryRecorder, settings
from tests.fakes.sim_errors import POSITIONS_ERR

IMAGE_SIZE_PX = 96
STEP_TICKS = 5
"""Steps of the dynamics as a demo at five times the speed has them; single ones take three times the work."""
SEPARATION_M = UNLIMITED.separation_m
TARGET_ENU_M = (2.0, 30.0)
_TARGET_RADIUS_M, _SKIN_RADIUS_M = 0.7, 0.3
AREA_ENU_M = ((-8.0, 10.0), (8.0, 10.0), (8.0, 45.0), (-8.0, 45.0))


class WarmSpot:
    """Cool ground with one warm disc, whose middle is warmer."""

    def view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:
        """Return what a camera that looks straight down sees; the ground's pattern differs from image to image."""
        rng = np.random.default_rng([round(1e3 * at_s), *pose.position_enu_m.astype(np.float64).view(np.uint64)])
        shape = camera.height_px, camera.width_px
        rows, columns = np.indices(shape)
        rays = np.stack([(columns - camera.cx_px) / camera.fx_px, (rows - camera.cy_px) / camera.fy_px], axis=-1)
        rays_enu = np.dstack([rays, np.ones(shape)]) @ pose.R_cam2enu.T
        ground_m = pose.position_enu_m[:2] - rays_enu[..., :2] * (pose.position_enu_m[2] / rays_enu[..., 2:])
        distance_m = np.hypot(*np.moveaxis(ground_m - np.array(TARGET_ENU_M), -1, 0))
        warm = distance_m < _TARGET_RADIUS_M
        rgb = rng.normal([70.0, 90.0, 50.0], 6.0, (*shape, 3))
        rgb[warm] = [200.0, 40.0, 160.0]
        thermal = rng.normal(12.0, 0.5, shape)
        thermal[warm] = 28.0
        thermal[distance_m < _SKIN_RADIUS_M] = 33.0
        return np.dstack([rgb, thermal]).astype(np.float32)


@dataclass
class AirFlight:
    """A mission and the world it flies in."""

    mission: Coordinator
    swarm: SimulatedSwarm
    air: Air
    recorder: MemoryRecorder
    clock: LoopClock
    run: asyncio.Task[Outcome]
    images: dict[str, bytes]
    station: StationLoop
    fleet: MavlinkFleet

    def texts(self) -> list[str]:
        """Return all notices so far."""
        return [event.data.text for event in self.recorder.events if event.kind == "notice"]

    def assert_nobody_was_endangered(self) -> None:
        """Look at the true distances, and at whom everything sent to each vehicle's address was meant for."""
        smallest_m = self.swarm.report().min_separation_m
        assert smallest_m is not None
        assert smallest_m >= SEPARATION_M
        for index, datagrams in self.air.sent_to.items():
            assert targets(datagrams) <= {0, self.swarm.vehicles[index].system_id}

    def task(self, vehicle_id: int) -> Task:
        """Return what a vehicle is doing, as the mission sees it."""
        return {v.telemetry.vehicle_id: v.task for v in self.mission.view.snapshot().vehicles}[vehicle_id]

    def can_be_asked(self, vehicle_id: int) -> bool:
        """Whether a vehicle is heard and ready to be armed."""
        states = {v.telemetry.vehicle_id: v.telemetry for v in self.mission.view.snapshot().vehicles}
        return vehicle_id in states and bool(states[vehicle_id].ready_to_arm)

    async def kill_and_restart(self) -> Coordinator:
        """End the mission without a word to any vehicle, and return the one that takes it up by its record."""
        former = FormerFlight(self.mission.view.snapshot(), None, self.clock.utc_s())
        self.air.on_datagram = lambda data, sender, _receiver: None if sender == GCS else data
        self.run.cancel()
        with suppress(asyncio.CancelledError):
            await self.run
        self.air.on_datagram = None
        return Coordinator(
            "again",
            self.mission.sortie.context.settings,
            fleet=self.fleet,
            clock=self.clock,
            journal=Journal(self.clock),
            recorder=MemoryRecorder(),
            loop_monitor=LoopMonitor(period_s=0.5),
            former=former,
        )

    async def until(self, condition: Callable[[], bool], timeout_s: float = 300.0) -> None:
        """Wait in virtual time."""
        async with self.clock.timeout_at(self.clock.now_s() + timeout_s):
            while not condition():
                await self.clock.sleep(0.05)

    async def until_step(self, number: int) -> None:
        """Wait for the end of a step."""
        await self.until(lambda: len(self.mission.view.steps()) >= number)


@asynccontextmanager
async def simulated(
    monkeypatch: pytest.MonkeyPatch,
    air: Air,
    context: DriverContext,
    images: dict[str, bytes],
    *,
    scene: ImageSource | None = None,
    image_size_px: int = IMAGE_SIZE_PX,
    relief: Relief | None = None,
    **options: object,
) -> AsyncIterator[tuple[MavlinkFleet, SimulatedSwarm]]:
    """Open the driver, and a simulated swarm with ``options``, both over ``air``; files of images go to ``images``.

    Its cameras see ``scene``, or else a warm spot; it stands on ``relief``, or else on level ground.
    """
    loop = asyncio.get_running_loop()
    air.install(loop)
    loop.set_default_executor(InlineExecutor(1))
    publish = ImageServer.publish

    def remember(server: ImageServer, system_id: int, index: int, data: bytes) -> str:
        url = publish(server, system_id, index, data)
        images[url] = data
        return url

    async def download(_fetcher: ImageFetcher, url: str, _host: str, _deadline_s: float) -> Download:
        return Download(images[url], None)

    monkeypatch.setattr(ImageServer, "publish", remember)
    monkeypatch.setattr(ImageFetcher, "download", download)
    monkeypatch.setattr("aos_sim.camera.darkroom.ThreadPoolExecutor", InlineExecutor)
    # Virtual time has a resolution of its own, below which it would stand still.
    delay_s = Pacer.delay_s
    monkeypatch.setattr(Pacer, "delay_s", lambda pacer, real_s: delay_s(pacer, real_s) + 1e-4)
    swarm_options = SwarmOptions(
        links=(f"udpout://{GCS[0]}:{GCS[1]}",),
        image_size_px=image_size_px,
        start_up_s=1.0,
        **({"step_ticks": STEP_TICKS} | options),  # type: ignore[arg-type]
    )
    async with AsyncExitStack() as stack:
        with station():
            fleet = await stack.enter_async_context(open_mavlink([f"udpin://{GCS[0]}:{GCS[1]}"], context))
        swarm = await stack.enter_async_context(SimulatedSwarm(swarm_options, scene or WarmSpot(), relief))
        yield fleet, swarm


@asynccontextmanager
async def flying_over(
    monkeypatch: pytest.MonkeyPatch,
    air: Air,
    vehicles: int = 3,
    autopilot: str = "arducopter",
    late_vehicles: int = 0,
    **changes: object,
) -> AsyncIterator[AirFlight]:
    """Fly a mission over ``air``; it has been started when this yields, and is over when it ends.

    ``late_vehicles`` more stand beside the others and are not heard until they are taken out of ``air.cut``.
    """
    images: dict[str, bytes] = {}
    air.cut |= set(range(vehicles, vehicles + late_vehicles))
    options = {
        "vehicles": vehicles + late_vehicles,
        "autopilot": autopilot,
        "parameters": changes.pop("parameters", {}),
        "errors": changes.pop("errors", POSITIONS_ERR),
        "scene": changes.pop("scene", None),
        "image_size_px": changes.pop("image_size_px", IMAGE_SIZE_PX),
        "relief": changes.pop("relief", None),
    }
    clock, loop = LoopClock(), StationLoop(asyncio.get_running_loop())
    journal, recorder, pulse = Journal(clock), MemoryRecorder(), LoopMonitor(period_s=0.5)
    context = DriverContext(clock=clock, is_healthy=pulse.is_healthy, notify=journal.take)
    async with (
        simulated(monkeypatch, air, context, images, **options) as (fleet, swarm),
        journal.recorded(recorder),
        asyncio.TaskGroup() as group,
    ):
        mission = Coordinator(
            "m",
            settings(
                vehicles,
                **{
                    "area_enu_m": AREA_ENU_M,
                    "origin": swarm.options.origin,
                    "deadlines": Deadlines(preflight_s=120.0, capture_s=8.0),
                    # Faults of the way up and down are what counts here; uploads have tests of their own.
                    "preflight": PreflightSettings(overrides={"geofence": "nothing flies near it"}),
                    **changes,
                },
            ),
            fleet=fleet,
            clock=clock,
            journal=journal,
            recorder=recorder,
            loop_monitor=pulse,
            pictures=False,
        )
        with station():
            run = group.create_task(mission.run())
        yield AirFlight(mission, swarm, air, recorder, clock, run, images, loop, fleet)
