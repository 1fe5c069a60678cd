"""The service in a long search by ten vehicles: its processor, its memory, and how soon frames are on the map.

    python -m tests.benchmarks.bench_search_service [--minutes 30] [--folder DIR]

The service runs in this process and in those that it starts, the simulator in one of its own, which does not count:
ten vehicles over 81 ha, cameras of 512 by 512 pixels and four bands that show a chequered ground at 2 Hz. The dashboard
is up, and nobody has its page open. Written are figures of each minute from the first sweep on, and of all together.
The delay is that from the step that has used a frame until the map of searched ground has it. What the vehicles do at
the end is not waited for. Frames are recorded: ``--folder`` names a disk with room for them.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import socket
import statistics
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

from aos_gcs.config.file import parse_config
from aos_gcs.config.model import ServiceConfig
from aos_gcs.groundmap.work import add_frames
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.ground.mapping import GroundMapping, GroundPlace
from aos_gcs.ports import Worker
from aos_gcs.runtime import service
from aos_gcs.runtime.service import open_service
from tests.benchmarks.processes import cpu_s, family, proportional_mb
from tests.fakes.program import unused_port

VEHICLES = 10
AREA_ENU_M = ((-450.0, 30.0), (450.0, 30.0), (450.0, 930.0), (-450.0, 930.0))
_START_S = 180.0
"""Time limit until the vehicles search."""
_MINUTE_S = 60.0


@dataclass
class MapDelays:
    """Delays of frames to the map."""

    seconds: list[float] = field(default_factory=list)
    _offered_s: dict[int, float] = field(default_factory=dict)

    def note_offer(self, frames: Sequence[Frame]) -> None:
        """Note that a step has used frames."""
        self._offered_s |= dict.fromkeys(map(id, frames), time.perf_counter())

    def note_added(self, frames: Sequence[Frame]) -> None:
        """Note that the map has frames."""
        now_s = time.perf_counter()
        self.seconds += [now_s - self._offered_s.pop(id(frame)) for frame in frames]


@dataclass(frozen=True)
class NotingWorker:
    """The map's worker; notes which frames it has added."""

    worker: Worker
    delays: MapDelays

    async def run(self, function: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        """Run a function in the worker's process."""
        result = await self.worker.run(function, *arguments, **options)
        if function is add_frames:
            self.delays.note_added([frame for frame, _, _ in arguments[1]])
        return result


@contextlib.contextmanager
def noted_delays() -> Iterator[MapDelays]:
    """Have every map of searched ground that is opened meanwhile note its delays."""
    delays, offer = MapDelays(), GroundMapping.offer

    def noting_offer(mapping: GroundMapping, step: int, frames: Sequence[Frame], surface: FocalSurface) -> None:
        delays.note_offer(frames)
        offer(mapping, step, frames, surface)

    def noting_place(worker: Worker, folder: Path, **carried: Path | None) -> GroundPlace:
        return GroundPlace(NotingWorker(worker, delays), folder, **carried)

    with patch.object(GroundMapping, "offer", noting_offer), patch.object(service, "GroundPlace", noting_place):
        yield delays


@dataclass(frozen=True)
class Usage:
    """What the service's processes have used until now."""

    at_s: float
    spent_s: dict[int, float]
    mb: float
    own_mb: float
    """Memory of the process that flies."""

    @classmethod
    def now(cls, simulator: int) -> Usage:
        """Return that of this process and all that it has started, but the simulator."""
        simulated = family(simulator)
        pids = [pid for pid in family(os.getpid()) if pid not in simulated]
        spent_s, memory_mb = dict[int, float](), dict[int, float]()
        for pid in pids:
            with contextlib.suppress(OSError):
                spent_s[pid], memory_mb[pid] = cpu_s(pid), proportional_mb(pid)
        return cls(time.perf_counter(), spent_s, sum(memory_mb.values()), memory_mb[os.getpid()])

    def share_since(self, former: Usage, pid: int | None = None) -> float:
        """Return the share of a core since then, of one process or of all."""
        pids = self.spent_s if pid is None else [pid]
        spent_s = sum(self.spent_s[one] - former.spent_s.get(one, 0.0) for one in pids)
        return spent_s / (self.at_s - former.at_s)


def print_figures(name: str, former: Usage, now: Usage, delays_s: Sequence[float]) -> None:
    """Print a line of figures between two times."""
    median = f"{statistics.median(delays_s):.2f} s" if delays_s else "-"
    print(
        f"{name}: {now.share_since(former):.2f} of a core (the flight's process "
        f"{now.share_since(former, os.getpid()):.2f}); {now.mb:.0f} MB ({now.own_mb:.0f}); "
        f"{len(delays_s) / (now.at_s - former.at_s):.1f} frames per second, median to the map {median}",
        flush=True,
    )


def configuration(folder: Path, link_port: int, minutes: int) -> ServiceConfig:
    """Return the configuration of the search."""
    tables = {
        "link": {"urls": [f"udpin://127.0.0.1:{link_port}"]},
        "mission": {
            "vehicles": VEHICLES,
            "any_vehicles": True,
            "origin_deg": (48.3, 14.3, 260.0),
            "area_enu_m": AREA_ENU_M,
            "auto_start": True,
            "auto_return": True,
        },
        "deadlines": {"search_s": _START_S + _MINUTE_S * (minutes + 1)},
        "api": {"port": unused_port(socket.SOCK_STREAM)},
        "preflight": {"upload_fence": True, "set_return_height": True},
        "record": {"folder": folder},
    }
    return parse_config(tables, source="benchmark")


@contextlib.asynccontextmanager
async def simulator(link_port: int) -> AsyncIterator[int]:
    """Run the simulator for as long as the context is entered; its process id."""
    options = ("--vehicles", str(VEHICLES), "--no-render", "--battery-life", "9000", "--launch-spacing", "5")
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "aos_gcs", "--log-level", "warning", "sim", *options),
        *("--link", f"udpout://127.0.0.1:{link_port}", "--exit-with-parent"),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
    )
    try:
        yield process.pid
    finally:
        process.terminate()
        await process.wait()


async def measure(minutes: int, parent: Path | None) -> None:
    """Fly the search, and print its figures minute by minute."""
    link_port = unused_port(socket.SOCK_DGRAM)
    with tempfile.TemporaryDirectory(dir=parent) as name, noted_delays() as delays:
        config = configuration(Path(name), link_port, minutes)
        async with open_service(config) as opened, simulator(link_port) as simulator_pid:
            flight = asyncio.create_task(opened.run())
            try:
                async with asyncio.timeout(_START_S):
                    while opened.mission.phase is not Phase.SCAN:  # noqa: ASYNC110 - vehicles fly by themselves
                        await asyncio.sleep(0.2)
            except TimeoutError:
                raise SystemExit(f"no search after {_START_S:.0f} s, but {opened.mission.phase}") from None
            first = former = Usage.now(simulator_pid)
            delays.seconds.clear()
            seen = 0
            for minute in range(1, minutes + 1):
                await asyncio.wait([flight], timeout=_MINUTE_S)
                if flight.done():
                    break
                now = Usage.now(simulator_pid)
                print_figures(f"minute {minute}", former, now, delays.seconds[seen:])
                former, seen = now, len(delays.seconds)
            print_figures("all", first, former, delays.seconds[:seen])
            flight.cancel()
            await asyncio.wait([flight])


def main() -> None:
    """Read the options and measure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=int, default=30)
    parser.add_argument("--folder", type=Path, help="Folder of the record.")
    options = parser.parse_args()
    asyncio.run(measure(options.minutes, options.folder))


if __name__ == "__main__":
    main()
