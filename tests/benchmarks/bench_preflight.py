"""Lateness of the service's event loop while a large fleet is in preflight and answers none of its questions.

The vehicles are a process of their own, each with a socket; they send telemetry and nothing else. One client looks on.

Usage: ``python tests/benchmarks/bench_preflight.py [VEHICLES] [SECONDS] [--profile]``, by default 100 vehicles, 20 s.
"""

from __future__ import annotations

import argparse
import asyncio
import cProfile
import logging
import multiprocessing
import pstats
import socket
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.config.file import parse_config
from aos_gcs.mission.control import MissionView
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.runtime.service import open_service
from tests.benchmarks.bench_api import Fleet, follow
from tests.benchmarks.figures import report
from tests.fakes.program import unused_port

PROBE_S = 0.01
SETTLING_S = 3.0
SPACING_DEG = 8.0 / 74_000.0
LINES = 25


def talk(vehicles: int, port: int) -> None:
    """Be the vehicles, side by side on the ground; the first of a fleet never talks by itself."""
    asyncio.run(Fleet(vehicles + 1, port, SPACING_DEG).talk())


async def probe(lags_ms: list[float], busy_ms: list[float]) -> None:
    """Measure how much later than asked for the loop wakes somebody up, and what it has worked meanwhile."""
    while True:
        due_s, worked_s = time.perf_counter() + PROBE_S, time.thread_time()
        await asyncio.sleep(PROBE_S)
        lags_ms.append(1e3 * (time.perf_counter() - due_s))
        busy_ms.append(1e3 * (time.thread_time() - worked_s))


async def until_preflight(mission: MissionView) -> None:
    """Wait until all vehicles are heard."""
    with mission.subscribe() as events:
        async for event in events:
            if isinstance(event.data, MissionSnapshot) and event.data.phase is Phase.PREFLIGHT:
                return


async def measure(vehicles: int, seconds: float, folder: Path, profile: cProfile.Profile | None) -> None:
    """Print the figures."""
    link_port, api_port = unused_port(), unused_port(socket.SOCK_STREAM)
    config = parse_config(
        {
            "link": {"urls": [f"udpin://127.0.0.1:{link_port}"]},
            "mission": {
                "vehicles": vehicles,
                "origin_deg": [48.3, 14.3, 260.0],
                "area_enu_m": [[-50, 0], [50, 0], [50, 100], [-50, 100]],
            },
            "api": {"port": api_port},
            "record": {"folder": str(folder)},
        }
    )
    fleet = multiprocessing.get_context("spawn").Process(target=talk, args=(vehicles, link_port), daemon=True)
    lags_ms: list[float] = []
    busy_ms: list[float] = []
    async with open_service(config) as service:
        tasks = [
            asyncio.create_task(service.run()),
            asyncio.create_task(probe(lags_ms, busy_ms)),
            asyncio.create_task(follow(f"ws://127.0.0.1:{api_port}/api/events", [])),
        ]
        fleet.start()
        await until_preflight(service.mission.view)
        await asyncio.sleep(SETTLING_S)
        lags_ms.clear()
        busy_ms.clear()
        before_s, start_s = time.process_time(), time.monotonic()
        if profile is not None:
            profile.enable()
        await asyncio.sleep(seconds)
        if profile is not None:
            profile.disable()
        load = (time.process_time() - before_s) / (time.monotonic() - start_s)
        print(f"{vehicles} vehicles that answer nothing, {len(service.mission.view.snapshot().preflight)} checks")
        fleet.terminate()
        for task in tasks:
            task.cancel()
        await asyncio.wait(tasks)
    report("preflight.lag", float(np.median(lags_ms)))
    print(f"the loop is late by {describe(lags_ms)}")
    print(f"its own work before it comes back, whatever else this machine does: {describe(busy_ms)}")
    print(f"load of the service, with a client in the same process: {100.0 * load:.0f} % of a core")


def describe(times_ms: list[float]) -> str:
    """Return the figures of some times."""
    p50_ms, p99_ms, worst_ms = np.percentile(times_ms, [50, 99, 100])
    return f"{p50_ms:.1f} ms (median), {p99_ms:.0f} ms (99th percentile), {worst_ms:.0f} ms (worst)"


def main() -> None:
    """Measure with the numbers of the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vehicles", type=int, nargs="?", default=100)
    parser.add_argument("seconds", type=float, nargs="?", default=20.0)
    parser.add_argument("--profile", action="store_true", help="print where the time goes")
    options = parser.parse_args()
    logging.disable(logging.WARNING)
    profile = cProfile.Profile() if options.profile else None
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(measure(options.vehicles, options.seconds, Path(folder), profile))
    if profile is not None:
        pstats.Stats(profile).sort_stats("tottime").print_stats(LINES)


if __name__ == "__main__":
    main()
