"""Time that a jump of a replay takes: to any time of a long mission, until the whole state for the clients is made.

Usage: ``python tests/benchmarks/bench_replay.py [VEHICLES] [SECONDS]``, by default 20 vehicles for 600 s.
"""

from __future__ import annotations

import asyncio
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.api.events.hub import EventHub
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay
from tests.benchmarks.figures import report
from tests.fakes.recording import record

JUMPS = 60


def ms_since(start_s: float) -> float:
    """Return the milliseconds since a reading of the clock."""
    return 1e3 * (time.perf_counter() - start_s)


async def measure(vehicles: int, length_s: int, folder: Path) -> None:
    """Print the figures."""
    await record(folder, length_s, vehicles)
    start_s = time.perf_counter()
    with MissionReader(folder) as reader:
        replay = MissionReplay(reader, LoopClock())
        print(f"{vehicles} vehicles, {length_s} s, {len(replay.timeline().steps)} steps: opened in", end=" ")
        print(f"{ms_since(start_s):.0f} ms")
        hub = EventHub(replay, replay=replay)
        random.seed(1)
        jumps_ms, hellos_ms = [], []
        for _ in range(JUMPS):
            start_s = time.perf_counter()
            replay.seek(time_s=random.uniform(0.0, length_s))
            jumps_ms.append(ms_since(start_s))
            hub.hello().model_dump_json()
            replay.picture(PictureKind.INTEGRAL)
            hellos_ms.append(ms_since(start_s))
    report("replay.jump", float(np.median(hellos_ms)))
    for what, times_ms in (("jump", jumps_ms), ("jump and state for the clients", hellos_ms)):
        print(f"{what}: median {np.median(times_ms):.0f} ms, worst {max(times_ms):.0f} ms")


def main(arguments: Sequence[str]) -> None:
    """Measure with the numbers of the command line."""
    vehicles, length_s = (*map(int, arguments), *(20, 600)[len(arguments) :])
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(measure(vehicles, length_s, Path(folder) / "mission"))


if __name__ == "__main__":
    main(sys.argv[1:])
