"""The world of one mission: simulated vehicles, the air, and the station that flies them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator
from contextlib import AsyncExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_drivers.frames.errors import LateFrameError, TornFrameError
from aos_drivers.frames.files.fetching import Download, ImageFetcher
from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.clock import LoopClock
from aos_gcs.planning.settings import MissionSettings
from aos_sim.camera.server import ImageServer
from aos_sim.clock import Pacer, SimTime
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.campaign.airspace import EVERY, AirspaceWatch
from tests.campaign.imaging import FaultyWorker
from tests.campaign.oracle import Oracle
from tests.campaign.station import Station
from tests.fakes.air import GCS, HOST, Address, Air
from tests.fakes.air_flight import WarmSpot
from tests.fakes.frozen import StationLoop
from tests.fakes.mission_flight import InlineExecutor

START_UTC_S = 1_750_000_000.0
"""Time of day at which the vehicles are switched on: that of the machine would make missions differ."""

IMAGE_PORT = 8090
_THAWED_S = 1.0
"""Time that a service has between its standing still and its end: a task that never ran keeps no record."""
"""Port in the addresses of images; nothing listens there."""

Middleman = Callable[[bytes, Address, Address], bytes | None]


@dataclass
class _WatchedAir(Air):
    """An air that shows the oracle what the station sends."""

    on_sent: Callable[[bytes, Address], None] | None = None

    def carry(self, data: bytes, sender: Address, receiver: Address) -> None:
        if sender == GCS and self.on_sent is not None:
            self.on_sent(data, receiver)
        super().carry(data, sender, receiver)


class World:
    """Everything in one mission; entered, the vehicles are switched on, and no station is there yet.

    Args:
        options: the simulated swarm.
        settings: the mission.
        folder: for the records.
        seed: of the air's chances.
        can_freeze: whether the station's event loop can be blocked, which makes everything slower.
    """

    def __init__(
        self,
        options: SwarmOptions,
        settings: MissionSettings,
        folder: Path,
        seed: int,
        *,
        can_freeze: bool,
    ) -> None:
        self._options = options
        self._settings = settings
        self._folder = folder
        self._can_freeze = can_freeze
        self._is_dying = False
        self._stations = 0
        self._stack = AsyncExitStack()
        self._images: dict[str, bytes] = {}
        self._middlemen: list[Middleman] = []
        self._ids: dict[int, int] = {}
        """System ids of the vehicles by their index."""
        self.camera_faults: dict[int, str] = {}
        self.camera_delays_s: dict[int, tuple[float, float]] = {}
        """Shortest and longest time until an image arrives, by vehicle."""
        self.imaging = FaultyWorker()
        self._delays = np.random.default_rng([seed, 0xCA3])
        self.loop: StationLoop | None = None
        """Blocks the station's event loop."""
        self.launched_at_s = 0.0
        self.station: Station | None = None
        self.clock = LoopClock()
        self.air = _WatchedAir(seed=seed, on_datagram=self._pass_on, on_sent=self._look_at_sent)
        self.swarm: SimulatedSwarm
        separation_m = settings.safety.applied_to(UNLIMITED).separation_m
        self.oracle = Oracle(separation_m, self.now_s, self._landed_ids)
        self.oracle.on_step = self._look_at_airspace
        self._airspace = AirspaceWatch(self.oracle.report)
        self._steps = 0

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            patches = stack.enter_context(pytest.MonkeyPatch.context())
            self._patch(patches)
            loop = asyncio.get_running_loop()
            self.loop = StationLoop(loop) if self._can_freeze else None
            self.air.install(loop)
            loop.set_default_executor(InlineExecutor(1))
            loop.set_exception_handler(self._on_exception)
            logging.getLogger().addHandler(self.oracle)
            stack.callback(logging.getLogger().removeHandler, self.oracle)
            self.swarm = SimulatedSwarm(self._options, WarmSpot())
            self.swarm.now = SimTime(0, round(START_UTC_S * 1e6))
            self.swarm._separation = self.oracle  # type: ignore[assignment]
            self._ids = {index: vehicle.system_id for index, vehicle in enumerate(self.swarm.vehicles)}
            await stack.enter_async_context(self.swarm)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        await self._close_station()
        await self._stack.aclose()

    # --- for faults ---------------------------------------------------------------------------------------------------

    def now_s(self) -> float:
        """Return the time since the launch."""
        return self.clock.now_s() - self.launched_at_s

    async def sleep(self, duration_s: float) -> None:
        await self.clock.sleep(duration_s)

    def index(self, vehicle_id: int) -> int:
        return vehicle_id - self._options.first_system_id

    def all_down(self) -> bool:
        """Whether all vehicles are on the ground with motors that stand still."""
        return self.swarm.report().landed == len(self.swarm.vehicles)

    @contextmanager
    def middleman(self, pass_on: Middleman) -> Iterator[None]:
        """Have somebody see, change or drop each datagram."""
        self._middlemen.append(pass_on)
        try:
            yield
        finally:
            self._middlemen.remove(pass_on)

    @contextmanager
    def held_telemetry(self) -> Iterator[None]:
        """Keep what is sent to the station, as its sockets do while it stands still, and deliver it afterwards."""
        waiting: list[tuple[bytes, Address, Address]] = []

        def keep(data: bytes, sender: Address, receiver: Address) -> bytes | None:
            if receiver != GCS:
                return data
            waiting.append((data, sender, receiver))
            return None

        try:
            with self.middleman(keep):
                yield
        finally:
            for datagram in waiting:
                self.air.carry(*datagram)

    async def start_station(self) -> None:
        """Start the service, unless it runs."""
        if self.station is None:
            self._stations += 1
            is_first = self._stations == 1
            settings = self._settings if is_first else _by_hand(self._settings)
            station = Station(settings, self._folder, self._stations, START_UTC_S, imaging=self.imaging)
            self.station = await station.__aenter__()

    async def kill_station(self) -> None:
        """End the service without a farewell."""

        def drop(data: bytes, sender: Address, receiver: Address) -> bytes | None:
            return None if GCS in (sender, receiver) else data

        if self.station is not None:
            self.station.die()
        self._is_dying = True
        with self.middleman(drop):
            await self._close_station(killed=True)
        self._is_dying = False

    async def _close_station(self, *, killed: bool = False) -> None:
        if self.station is not None and self.loop is not None and self.loop.is_frozen:
            self.loop.thaw()
            await self.sleep(_THAWED_S)
        station, self.station = self.station, None
        if station is None:
            return
        await station.__aexit__(None, None, None)
        if (error := station.failure()) is not None:
            self.oracle.report("exception", repr(error))
        if (lost := station.lost_records()) and not killed:
            self.oracle.report("records lost", lost)

    # --- inside -------------------------------------------------------------------------------------------------------

    def _pass_on(self, data: bytes, sender: Address, receiver: Address) -> bytes | None:
        seen: bytes | None = data
        for middleman in self._middlemen:
            if seen is not None:
                seen = middleman(seen, sender, receiver)
        return seen

    def _look_at_sent(self, data: bytes, receiver: Address) -> None:
        # What the tasks of a killed service still send while they end reaches nobody.
        if not self._is_dying:
            self.oracle.sent(data, receiver, self._ids)

    def _look_at_airspace(self, position_enu_m: NDArray[np.float64]) -> None:
        self._steps += 1
        if self._steps % EVERY:
            return
        if self.station is not None:
            self._airspace.set_limits(self.station.mission.sortie.context.bounds.limits)
        rows = zip(self.swarm.vehicles, position_enu_m.tolist(), self.swarm._kinematics, strict=True)
        for vehicle, true_enu_m, kinematics in rows:
            vehicle_id, flight = vehicle.system_id, vehicle.autopilot.flight
            is_taken = self.oracle.is_piloted(vehicle_id) or self.oracle.has_fallen(vehicle_id)
            self._airspace.look(
                vehicle_id,
                true_enu_m,
                kinematics.position_enu_m,
                flight.manoeuvre,
                is_ours=flight.armed and not is_taken,
            )

    def _landed_ids(self) -> list[int]:
        return [] if self.station is None else self.station.landed_ids()

    def _on_exception(self, _loop: asyncio.AbstractEventLoop, context: dict[str, object]) -> None:
        self.oracle.report("exception", f"{context.get('message')} {context.get('exception')!r}")

    def _patch(self, patches: pytest.MonkeyPatch) -> None:
        """Have images pass beside the air, and work run where it is asked for."""
        world = self

        def publish(_server: ImageServer, system_id: int, index: int, data: bytes) -> str:
            url = f"http://{HOST}:{IMAGE_PORT}/{system_id}/{index}.tiff"
            world._images[url] = data
            return url

        async def serve_nothing(server: ImageServer, *_: object) -> ImageServer:
            return server

        async def download(_fetcher: ImageFetcher, url: str, host: str, deadline_s: float) -> Download:
            return await world._download(url, host, deadline_s)

        # A tick that is due by a rounding error only would be waited for without time passing.
        delay_s = Pacer.delay_s
        patches.setattr(Pacer, "delay_s", lambda pacer, real_s: delay_s(pacer, real_s) + 1e-5)
        patches.setattr(ImageServer, "publish", publish)
        patches.setattr(ImageServer, "__aenter__", serve_nothing)
        patches.setattr(ImageServer, "__aexit__", serve_nothing)
        patches.setattr(ImageFetcher, "download", download)
        patches.setattr("aos_sim.camera.darkroom.ThreadPoolExecutor", InlineExecutor)
        patches.setattr("aos_gcs.store.recorder.ThreadPoolExecutor", InlineExecutor)

    async def _download(self, url: str, _host: str, deadline_s: float) -> Download:
        data = self._images[url]
        vehicle_id = int(url.split("/")[-2])
        fault = self.camera_faults.get(vehicle_id)
        assert self.station is not None
        left_s = max(0.0, deadline_s - self.station.clock.now_s())
        if (late_s := self._delays.uniform(*self.camera_delays_s.get(vehicle_id, (0.0, 0.0)))) > left_s:
            fault = "nothing"
        elif late_s > 0.0:
            await self.sleep(late_s)
            left_s -= late_s
        match fault:
            case "nothing":
                await self.sleep(left_s)
                raise LateFrameError(f"{url} did not arrive in time")
            case "late":
                await self.sleep(min(2.0, left_s))
            case "torn":
                raise TornFrameError(f"{url} cannot be fetched whole")
            case "half":
                return Download(data[: len(data) // 2], None)
        return Download(data, None)


def _by_hand(settings: MissionSettings) -> MissionSettings:
    """Return the settings of a service that is started again: it launches nobody by itself."""
    return replace(settings, auto_start=False)
