"""Live pictures: delay to the screen, what observers cost, and what the imaging step notices of them.

    python tests/benchmarks/bench_wall.py [--seconds 20] [--observers 20] [--folder DIR] [--parts delay cost] [--raised]

The dashboard runs in its own process, as in missions; frames of six cameras are written into its record by this one.
The delay is that from the arrival of a frame, before it is on the disk, to the frame of the browser after the one that
has painted it. Viewers of the second part are clients in a process of their own.

``--raised`` is for the imaging step on a machine that has other work: the sessions of all processes that are measured
get priorities above those of other programs, at the same distances from one another as before. It needs root, and a
session of its own: ``setsid -w python tests/benchmarks/bench_wall.py --parts step --seconds 40 --raised``.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import multiprocessing
import os
import shutil
import statistics
import struct
import tempfile
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace
from multiprocessing.sharedctypes import Synchronized
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from playwright.async_api import async_playwright
from websockets.asyncio.client import connect

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.ports import Capture
from aos_gcs.radiometry import celsius_from_centikelvin, centikelvin_from_celsius
from aos_gcs.runtime.processes.workers import ANALYSIS
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.workers.lifeline import step_back_as_session
from aos_gcs.workers.process import open_worker
from tests.benchmarks.figures import report
from tests.benchmarks.processes import children, cpu_s, family
from tests.fakes.api_process import Station, station
from tests.fakes.mission import ORIGIN

CAMERAS = 6
SIZE_PX = 512
BANDS = ("red", "green", "blue", "thermal")
FRAME_INTERVAL_S = 0.5
"""Two frames per second and camera, as in a search without stops."""
_KEPT_FRAMES = 24
_VIEWERS_NICENESS = 10
_RAISE = 20
PARTS = ("delay", "cost", "step")
TILES = [f"{vehicle_id}.thermal" for vehicle_id in range(1, CAMERAS + 1)]
_CHROMIUM_ARGUMENTS = ["--headless", "--no-sandbox", "--disable-gpu"]

# Notes for each tile that has changed how old its picture is in the frame of the screen after it was painted.
_WATCH_PAINTING = """() => {
    window.delays = [];
    const former = new Map();
    const look = () => {
        for (const { dataset } of document.querySelectorAll("figure[data-utc]")) {
            if (former.get(dataset.testid) === dataset.utc) continue;
            former.set(dataset.testid, dataset.utc);
            const taken_s = Number(dataset.utc);
            requestAnimationFrame(() => setTimeout(() => window.delays.push(Date.now() / 1000 - taken_s)));
        }
    };
    new MutationObserver(look).observe(document.body, { subtree: true, attributes: true, childList: true });
}"""


@dataclass
class Usage:
    """Processor time of the dashboard's process and of those that it has started."""

    pid: int

    def spent_s(self) -> float:
        """Return it until now."""
        return sum(map(cpu_s, (self.pid, *children(self.pid))))


def raise_sessions() -> None:
    """Put the sessions of this process and of those that it has started before those of other programs."""
    for pid in {os.getsid(pid): pid for pid in family(os.getpid())}.values():
        group = Path(f"/proc/{pid}/autogroup")
        try:
            niceness = int(group.read_text(encoding="ascii").split()[-1])
            if niceness >= 0:
                group.write_text(str(niceness - _RAISE), encoding="ascii")
        except OSError as error:
            raise SystemExit(f"--raised needs root and a kernel that groups processes by sessions: {error}") from error


class Cameras:
    """Six cameras whose frames go into the record of a mission."""

    def __init__(self, recorder: MissionRecorder) -> None:
        self._recorder = recorder
        self._images = [image(seed) for seed in range(4)]
        self._count = 0

    async def run(self) -> None:
        """Take frames, one camera after the other, until cancelled."""
        while True:
            for vehicle_id in range(1, CAMERAS + 1):
                await self._recorder.record_frame(1, self.capture(vehicle_id, time.time()))
                self._forget()
                await asyncio.sleep(FRAME_INTERVAL_S / CAMERAS)

    def _forget(self) -> None:
        """Remove old files, so that a disk in memory has room."""
        newest = self._count - _KEPT_FRAMES
        for path in (self._recorder.folder / "frames").glob(f"*_{newest:05d}.*"):
            path.unlink()

    def capture(self, vehicle_id: int, utc_s: float) -> Capture:
        """Return a frame of a camera."""
        self._count += 1
        pose = nadir_pose([4.0 * vehicle_id, 0.0, 35.0])
        return Capture(
            vehicle_id,
            self._count,
            utc_s,
            self._images[self._count % len(self._images)],
            BANDS,
            LocalFrame(ORIGIN).to_geodetic(pose.position_enu_m),
            pose.R_cam2enu,
            CameraModel.from_fov(SIZE_PX, SIZE_PX, 0.87),
        )


def image(seed: int) -> NDArray[np.float32]:
    """Return a frame with the structure of leaves, and a warm spot."""
    rng = np.random.default_rng(seed)
    coarse = rng.normal(100.0, 25.0, (64, 64, 3)).repeat(8, axis=0).repeat(8, axis=1)
    colour = np.rint(np.clip(coarse + rng.normal(0.0, 8.0, (SIZE_PX, SIZE_PX, 3)), 0, 255))
    thermal = 11.0 + 0.02 * coarse[..., 0] + rng.normal(0.0, 0.1, (SIZE_PX, SIZE_PX))
    thermal[240:256, 100 * seed : 100 * seed + 12] = 30.0
    # As cameras write them, so that they are recorded as cameras' files are.
    whole = celsius_from_centikelvin(centikelvin_from_celsius(thermal.astype(np.float32)))
    return np.dstack([colour, whole]).astype(np.float32)


@contextlib.asynccontextmanager
async def dashboard(parent: Path | None = None) -> AsyncIterator[tuple[Station, Usage]]:
    """Serve a mission whose record grows, for as long as the context is entered."""
    with tempfile.TemporaryDirectory(dir=parent) as name:
        folder = Path(name)
        async with (
            MissionRecorder.create(folder, "m", {}, notify=print) as recorder,
            station(folder) as flown,
        ):
            taking = asyncio.create_task(Cameras(recorder).run())
            yield flown, Usage(await flown.process_id())
            taking.cancel()
            await asyncio.wait([taking])


async def measure_delay(flown: Station, seconds: float, chromium: str) -> None:
    """Watch six tiles in Chromium, and print how late they are."""
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=shutil.which(chromium), args=_CHROMIUM_ARGUMENTS)
        page = await browser.new_page(viewport={"width": 1920, "height": 1080})
        await page.goto(f"{flown.url}#/wall")
        await page.evaluate("tiles => localStorage.setItem('aos-gcs-wall', JSON.stringify(tiles))", TILES)
        await page.reload()
        for tile in TILES:
            await page.locator(f"[data-testid='tile-{tile}'][data-state=live]").wait_for()
        await page.evaluate(_WATCH_PAINTING)
        await asyncio.sleep(seconds)
        delays_s = sorted(await page.evaluate("() => window.delays"))
        await browser.close()
    print(f"{len(delays_s)} pictures of {CAMERAS} tiles in {seconds:.0f} s")
    print(f"arrival to painted: 95th percentile {1000 * delays_s[int(0.95 * len(delays_s))]:.0f} ms")
    report("wall.delay", 1000.0 * statistics.median(delays_s))


def view(url: str, observers: int, ready: Event, count: Synchronized[int]) -> None:
    """Watch the wall so many times, until ended: the main program of the viewers' process.

    Viewers are other machines in the field: what this process takes of the processor is not to slow the station.
    """
    os.nice(_VIEWERS_NICENESS)
    os.setsid()
    step_back_as_session(_VIEWERS_NICENESS)
    seen = 0

    async def one() -> None:
        nonlocal seen
        has_seen = False
        async with connect(url) as stream:
            await stream.send(json.dumps({"kind": "watch", "tiles": TILES}))
            async for message in stream:
                assert isinstance(message, bytes)
                (length,) = struct.unpack("!I", message[:4])
                head = json.loads(message[4 : 4 + length])
                await stream.send(json.dumps({"kind": "shown", "number": head["number"]}))
                count.value += len(head["pictures"])
                if head["pictures"] and not has_seen:
                    has_seen, seen = True, seen + 1
                    if seen == observers:
                        ready.set()

    async def everybody() -> None:
        await asyncio.gather(*(one() for _ in range(observers)))

    asyncio.run(everybody())


@dataclass(frozen=True)
class Viewers:
    """Clients that watch the wall, in a process of their own."""

    pictures: Synchronized[int]
    """Number of pictures that they have got."""
    usage: Usage


@contextlib.asynccontextmanager
async def viewers(flown: Station, observers: int) -> AsyncIterator[Viewers]:
    """Watch the wall for as long as the context is entered."""
    url = f"{flown.url.replace('http', 'ws')}api/wall"
    spawn = multiprocessing.get_context("spawn")
    ready, count = spawn.Event(), spawn.Value("q")
    process = spawn.Process(target=view, args=(url, observers, ready, count), daemon=True)
    process.start()
    if not await asyncio.to_thread(ready.wait, 60.0):
        raise SystemExit("the viewers have seen nothing")
    assert process.pid is not None
    yield Viewers(count, Usage(process.pid))
    process.terminate()
    process.join()
    await asyncio.sleep(1.0)


async def measure_cost(flown: Station, usage: Usage, seconds: float, observers: int) -> None:
    """Print the processor time of the dashboard's processes without viewers, with one and with many."""
    await asyncio.sleep(5.0)  # until the dashboard's process has started
    shares = {}
    for count in (0, 1, observers):
        async with viewers(flown, count) if count else contextlib.nullcontext() as watching:
            before_s, began_s = usage.spent_s(), time.perf_counter()
            former = 0 if watching is None else watching.pictures.value
            await asyncio.sleep(seconds)
            elapsed_s = time.perf_counter() - began_s
            shares[count] = 100.0 * (usage.spent_s() - before_s) / elapsed_s
            rate_hz = 0.0 if watching is None else (watching.pictures.value - former) / elapsed_s / count / CAMERAS
            print(f"{count} viewers: {shares[count]:.1f} % of a core, {rate_hz:.2f} pictures per tile and second")
    report("wall.observers", shares[observers] - shares[0])


async def measure_step(flown: Station, usage: Usage, seconds: float, observers: int, *, is_raised: bool) -> None:
    """Time the analysis of steps without and with viewers, in turns.

    What the viewers' own process takes is printed, too: in the field, viewers are other machines.
    """
    pose = nadir_pose([0.0, 0.0, 35.0])
    camera = CameraModel.from_fov(SIZE_PX, SIZE_PX, 0.87)
    first = Frame(1, image(1), BANDS, pose, camera)
    frames = [
        replace(first, vehicle_id=number, pose=nadir_pose([3.0 * number, 0.0, 35.0 + number])) for number in range(10)
    ]
    times_s: dict[bool, list[float]] = {False: [], True: []}
    spent_s = {"dashboard": 0.0, "viewers": 0.0}
    async with open_worker(ANALYSIS) as worker:
        await worker.ready()
        for turn in range(8):
            has_viewers = turn % 2 == 1
            async with viewers(flown, observers) if has_viewers else contextlib.nullcontext() as watching:
                if is_raised:
                    raise_sessions()
                usages = {} if watching is None else {"dashboard": usage, "viewers": watching.usage}
                before_s = {name: one.spent_s() for name, one in usages.items()}
                until_s = time.perf_counter() + seconds / 4.0
                while time.perf_counter() < until_s:
                    began_s = time.perf_counter()
                    await worker.run(analyse_step, frames, ImagingSettings())
                    times_s[has_viewers].append(time.perf_counter() - began_s)
                    await asyncio.sleep(0.2)
                for name, one in usages.items():
                    spent_s[name] += one.spent_s() - before_s[name]
    shares = (f"{name} {100.0 * one_s / seconds:.1f} %" for name, one_s in spent_s.items())
    print(f"of a core, with viewers: {', '.join(shares)}")
    without_s, with_s = (statistics.median(times_s[has_viewers]) for has_viewers in (False, True))
    counts = " and ".join(str(len(times_s[has_viewers])) for has_viewers in (False, True))
    without, with_viewers = (f"{1000.0 * one_s:.1f} ms" for one_s in (without_s, with_s))
    print(f"imaging step: {without} without, {with_viewers} with {observers} viewers ({counts} steps)")
    report("wall.step", 100.0 * (with_s / without_s - 1.0))


async def measure(options: argparse.Namespace) -> None:
    """Measure what is asked for."""
    async with dashboard(options.folder) as (flown, usage):
        if "delay" in options.parts:
            await measure_delay(flown, options.seconds, options.chromium)
        if "cost" in options.parts:
            await measure_cost(flown, usage, options.seconds, options.observers)
        if "step" in options.parts:
            await measure_step(flown, usage, options.seconds, options.observers, is_raised=options.raised)


def main() -> None:
    """Read the options and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--observers", type=int, default=20)
    parser.add_argument("--folder", type=Path, help="Folder of the record; on a disk in memory no disk is measured.")
    parser.add_argument("--chromium", default="chromium", help="Program of the browser.")
    parser.add_argument("--raised", action="store_true", help="Go before other programs in the imaging step's part.")
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=PARTS)
    asyncio.run(measure(parser.parse_args()))


if __name__ == "__main__":
    main()
