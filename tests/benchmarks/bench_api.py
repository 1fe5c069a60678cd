"""The dashboard's server with a large fleet: what a client costs it, and how old telemetry is at a client's socket.

The service runs as its users start it. This program is everything around it: vehicles that send telemetry by UDP, and
clients of the event stream.

Usage: ``python tests/benchmarks/bench_api.py [VEHICLES] [SECONDS]``, by default 100 vehicles, 10 s per measurement.
"""

from __future__ import annotations

import asyncio
import json
import os
import random
import socket
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.api.convert.mission import MissionConverter
from aos_gcs.api.events.state import MissionState
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from tests.benchmarks.figures import report
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fakes.mission import ScriptedMission
from tests.fakes.program import unused_port

RATE_HZ = 5.0
CLIENTS = 10
SNAPSHOTS = 200
CHANGES = 40
"""Times of one vehicle's position, timed on their way to a client."""
PATIENCE_S = 3.0
CONFIGURATION = """
[link]
urls = ["udpin://127.0.0.1:{link_port}"]
[mission]
vehicles = {expected}
origin_deg = [48.3, 14.3, 260.0]
area_enu_m = [[-50, 0], [50, 0], [50, 100], [-50, 100]]
[api]
port = {api_port}
[deadlines]
connect_s = 3600
[record]
folder = "{folder}"
"""


class Fleet:
    """Vehicles on the ground whose positions waver, one UDP socket each, side by side from west to east."""

    def __init__(self, vehicles: int, link_port: int, spacing_deg: float = 0.0) -> None:
        self._vehicles = [FakeVehicle(system_id) for system_id in range(1, vehicles + 1)]
        for number, vehicle in enumerate(self._vehicles):
            vehicle.longitude_deg += number * spacing_deg
        self._sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in self._vehicles]
        for one in self._sockets:
            one.connect(("127.0.0.1", link_port))
        self._bytes = 0

    async def talk(self) -> None:
        """Send everybody's telemetry at the rate, evenly spread."""
        while True:
            for vehicle, sock in zip(self._vehicles[1:], self._sockets[1:], strict=True):
                vehicle.latitude_deg += random.uniform(-1e-6, 1e-6)
                with suppress(ConnectionRefusedError):  # the service opens its link a little later than its API
                    sock.send(vehicle.telemetry())
                await asyncio.sleep(1.0 / RATE_HZ / len(self._vehicles))

    def move_first(self, latitude_deg: float) -> None:
        """Let the first vehicle, which is silent otherwise, report a position."""
        vehicle = self._vehicles[0]
        vehicle.latitude_deg = latitude_deg
        self._sockets[0].send(vehicle.telemetry())

    def close(self) -> None:
        """Close the sockets."""
        for one in self._sockets:
            one.close()


def cpu_s(pid: int) -> float:
    """Return the processor time of a process and those that it has started, so far."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") + sum(map(cpu_s, map(int, children)))


async def load_percent(pid: int, seconds: float) -> float:
    """Return the share of a core that a service with its processes takes."""
    before_s, start_s = cpu_s(pid), time.monotonic()
    await asyncio.sleep(seconds)
    return 100.0 * (cpu_s(pid) - before_s) / (time.monotonic() - start_s)


async def follow(url: str, sizes: list[int]) -> None:
    """Be a client that keeps up."""
    async with connect(url, max_size=None) as websocket:
        async for message in websocket:
            sizes.append(len(message))


@asynccontextmanager
async def followed(url: str, clients: int) -> AsyncIterator[list[int]]:
    """Have a number of clients; yields the sizes of what they receive."""
    sizes: list[int] = []
    async with asyncio.TaskGroup() as group:
        tasks = [group.create_task(follow(url, sizes)) for _ in range(clients)]
        yield sizes
        for task in tasks:
            task.cancel()


async def latencies_ms(url: str, fleet: Fleet) -> list[float]:
    """Return how long each new position of the first vehicle takes from its sending to a client."""
    found = []
    async with connect(url, max_size=None) as websocket:
        for number in range(CHANGES):
            latitude_deg = round(48.3 + 1e-5 * (number + 1), 7)
            await asyncio.sleep(random.uniform(0.2, 0.6))
            sent_s = time.perf_counter()
            fleet.move_first(latitude_deg)
            with suppress(TimeoutError):  # the packet has found the service's socket full
                async with asyncio.timeout(PATIENCE_S):
                    await until_seen(websocket, latitude_deg)
                    found.append(1e3 * (time.perf_counter() - sent_s))
    return found


async def until_seen(websocket: ClientConnection, latitude_deg: float) -> None:
    """Read messages until one of them has the first vehicle at this latitude."""
    async for text in websocket:
        message = json.loads(text)
        for vehicle in message.get("vehicles", []):
            position = vehicle.get("position")
            if vehicle["vehicle_id"] == 1 and position and abs(position["latitude_deg"] - latitude_deg) < 1e-6:
                return


async def measure(vehicles: int, seconds: float, folder: Path) -> None:
    """Print the figures."""
    link_port, api_port = unused_port(), unused_port(socket.SOCK_STREAM)
    file = folder / "mission.toml"
    # It waits for one more: preflight would ask these vehicles for what they cannot answer.
    settings = {"link_port": link_port, "expected": vehicles + 1, "api_port": api_port, "folder": folder}
    file.write_text(CONFIGURATION.format(**settings), encoding="utf-8")
    url = f"ws://127.0.0.1:{api_port}/api/events"
    service = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "aos_gcs", "--log-level", "error", "run", str(file)), stderr=asyncio.subprocess.DEVNULL
    )
    fleet = Fleet(vehicles, link_port)
    async with AsyncExitStack() as stack:
        stack.callback(fleet.close)
        stack.callback(service.kill)
        await until_listening(api_port)
        async with asyncio.TaskGroup() as group:
            talking = group.create_task(fleet.talk())
            await asyncio.sleep(3.0)
            loads = {}
            for clients in (0, 1, 1 + CLIENTS):
                async with followed(url, clients) as sizes:
                    await asyncio.sleep(2.0)
                    sizes.clear()
                    loads[clients] = await load_percent(service.pid, seconds)
            times_ms = await latencies_ms(url, fleet)
            talking.cancel()
    cost_ms = await snapshot_ms(vehicles)
    print(f"{vehicles} vehicles at {RATE_HZ:g} Hz")
    print(f"a snapshot: {cost_ms:.1f} ms of work for all clients together, {cost_ms * RATE_HZ / 10.0:.1f} % of a core")
    print(f"service without clients: {loads[0]:.1f} % of a core; the first one adds {loads[1] - loads[0]:.1f} %")
    print(f"each further client: {(loads[1 + CLIENTS] - loads[1]) / CLIENTS:.2f} % of a core")
    report("api.client", (loads[1 + CLIENTS] - loads[1]) / CLIENTS)
    if times_ms:
        report("api.latency", float(np.median(times_ms)))
    rate_hz = len(sizes) / seconds / (1 + CLIENTS)
    print(f"messages: median {np.median(sizes) / 1e3:.1f} kB, {rate_hz:.1f} Hz per client (below {RATE_HZ:g}: starved)")
    print(f"from the telemetry's sending to the client: {describe(times_ms)} ({len(times_ms)} of {CHANGES} arrived)")


def describe(times_ms: list[float]) -> str:
    """Return the figures of some times."""
    if not times_ms:
        return "never in time"
    return f"median {np.median(times_ms):.0f} ms, 90th percentile {np.percentile(times_ms, 90):.0f} ms"


async def snapshot_ms(vehicles: int) -> float:
    """Return the processor time of one snapshot on its way to the clients, however many there are.

    All vehicles fly, each telling a new place. Unlike a load it says the same on a machine that is busy otherwise.
    """
    mission, state = ScriptedMission(LoopClock(), vehicles), MissionState()
    converter = MissionConverter(mission.snapshot().origin)
    await mission.act(Action.START, None)
    times_ms = []
    for _ in range(SNAPSHOTS):
        mission.advance(1.0 / RATE_HZ)
        snapshot, start_s = mission.snapshot(), time.process_time()
        state.update(converter.convert(snapshot), 0.0)
        state.message_since(state.revision - 1, 0, 0.0, "")
        times_ms.append(1e3 * (time.process_time() - start_s))
    return float(np.median(times_ms))


async def until_listening(port: int) -> None:
    """Wait until a TCP port answers."""
    async with asyncio.timeout(60.0):
        while True:
            try:
                _, writer = await asyncio.open_connection("127.0.0.1", port)
            except OSError:
                await asyncio.sleep(0.2)
            else:
                writer.close()
                return


def main(arguments: Sequence[str]) -> None:
    """Measure with the numbers of the command line."""
    vehicles, seconds = (*map(float, arguments), *(100.0, 10.0)[len(arguments) :])
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(measure(int(vehicles), seconds, Path(folder)))


if __name__ == "__main__":
    main(sys.argv[1:])
