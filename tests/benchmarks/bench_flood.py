"""Gap between heartbeats at a vehicle while ten other addresses flood the driver's UDP port.

Run: python tests/benchmarks/bench_flood.py [--noise markers|random] [--size 1400] [--megabytes 10] [--seconds 12]
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import os
import socket
import sys
import time
from multiprocessing.queues import Queue
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import itertools

from aos_drivers.mavlink import open_mavlink
from aos_gcs.clock import LoopClock
from aos_gcs.ports import DriverContext
from tests.benchmarks.figures import report
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fakes.program import unused_port

HOST = "127.0.0.1"
ATTACKERS = 10
PERIOD_S = 0.1
SETTLE_S = 1.5


def flood(port: int, noise: str, size: int, bytes_per_s: float) -> None:
    """Send noise from ten sockets until killed."""
    links = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(ATTACKERS)]
    data = b"\xfe" * size if noise == "markers" else os.urandom(size)
    start_s, sent = time.perf_counter(), 0
    while True:
        for link in links:
            link.sendto(data, (HOST, port))
            sent += size
        time.sleep(max(0.0, start_s + sent / bytes_per_s - time.perf_counter()))


class FlyingVehicle:
    """An armed vehicle on one socket: its id belongs to the address that it has been heard from."""

    def __init__(self, port: int) -> None:
        self._vehicle = FakeVehicle(1)
        self._vehicle.armed = True
        self._link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._link.connect((HOST, port))
        self._link.settimeout(PERIOD_S)

    def gaps_s(self, duration_s: float) -> list[float]:
        """Report for a while, and return the gaps between the heartbeats that arrive."""
        vehicle, heard_s = self._vehicle, []
        start_s = due_s = time.perf_counter()
        while time.perf_counter() < start_s + duration_s:
            if time.perf_counter() >= due_s:
                due_s += PERIOD_S
                vehicle.boot_ms += 100
                self._link.send(vehicle.heartbeat() + vehicle.position())
            heartbeats = vehicle.heard_heartbeats
            try:
                vehicle.hear(self._link.recv(4096))
            except TimeoutError:
                continue
            if vehicle.heard_heartbeats > heartbeats:
                heard_s.append(time.perf_counter())
        return [later_s - earlier_s for earlier_s, later_s in itertools.pairwise(heard_s)]


def fly(port: int, duration_s: float, gaps_s: Queue[list[float]]) -> None:
    """Tell the gaps between heartbeats at an armed vehicle."""
    gaps_s.put(FlyingVehicle(port).gaps_s(duration_s))


async def main(noise: str, size: int, bytes_per_s: float, duration_s: float) -> None:
    port = unused_port()
    context = DriverContext(LoopClock(), lambda: True, lambda notice: print(notice.text))
    async with open_mavlink([f"udpin://{HOST}:{port}"], context) as fleet:
        gaps_s: Queue[list[float]] = multiprocessing.Queue()
        vehicle = multiprocessing.Process(target=fly, args=(port, duration_s, gaps_s))
        attacker = multiprocessing.Process(target=flood, args=(port, noise, size, bytes_per_s), daemon=True)
        vehicle.start()
        await asyncio.sleep(SETTLE_S)
        attacker.start()
        ages_s = []
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        while vehicle.is_alive() and gaps_s.empty():
            await asyncio.sleep(0.05)
            heard_at_s = fleet.vehicles()[1].state.heard_at_s or 0.0
            ages_s.append(context.clock.now_s() - heard_at_s)
        wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
        attacker.kill()
        largest_s = max(await asyncio.to_thread(gaps_s.get))
    report("flood.gap", largest_s)
    report("flood.age", max(ages_s))
    print(f"CPU of the driver       {100 * cpu_s / wall_s:.0f} % of one core")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--noise", choices=["markers", "random"], default="markers")
    parser.add_argument("--size", type=int, default=1400)
    parser.add_argument("--megabytes", type=float, default=10.0)
    parser.add_argument("--seconds", type=float, default=12.0)
    arguments = parser.parse_args()
    asyncio.run(main(arguments.noise, arguments.size, 1e6 * arguments.megabytes, arguments.seconds))
