"""Videos of the wall: what one costs, and what the imaging step notices of it.

    python tests/benchmarks/bench_video.py [--seconds 60] [--turns 8] [--parts cost step]

A record of six cameras with two frames per second each, colour and thermal; the video has all twelve tiles.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import os
import statistics
import tempfile
import time
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.notations import Notation
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.runtime.processes.workers import ANALYSIS
from aos_gcs.runtime.wall.video_maker import REST_IN_FLIGHT, VideoMaker
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.wall.video import VideoPhase, VideoState
from aos_gcs.workers.process import open_worker
from tests.benchmarks.bench_wall import BANDS, CAMERAS, FRAME_INTERVAL_S, SIZE_PX, Cameras, image

START_UTC_S = 1.7e9
STEP_PAUSE_S = 0.2
PARTS = ("cost", "step")


async def record(parent: Path, seconds: float) -> Path:
    """Return the folder of a mission of six cameras."""
    async with MissionRecorder.create(parent, "bench", {}, notify=print) as recorder:
        cameras = Cameras(recorder)
        for number in range(int(seconds / FRAME_INTERVAL_S)):
            for vehicle_id in range(1, CAMERAS + 1):
                utc_s = START_UTC_S + number * FRAME_INTERVAL_S
                await recorder.record_frame(1, cameras.capture(vehicle_id, utc_s))
        return recorder.folder


@contextlib.asynccontextmanager
async def opened(folder: Path, rest: float) -> AsyncIterator[VideoMaker]:
    """Run what makes videos."""
    maker = VideoMaker(lambda: folder, rest)
    running = asyncio.create_task(maker.run())
    yield maker
    running.cancel()
    await asyncio.wait([running])


async def ended(maker: VideoMaker) -> VideoState:
    """Return the state when nothing is being made any more."""
    while maker.state().phase is VideoPhase.MAKING:  # noqa: ASYNC110 - it tells nobody
        await asyncio.sleep(0.05)
    return maker.state()


async def measure_cost(folder: Path, seconds: float) -> None:
    """Make a video without rests and one with them."""
    for rest in (0.0, REST_IN_FLIGHT):
        async with opened(folder, rest) as maker:
            before, began_s = os.times(), time.perf_counter()
            maker.begin([], Notation.DECIMAL)
            state = await ended(maker)
            taken_s, after = time.perf_counter() - began_s, os.times()
        spent_s = after.children_user + after.children_system - before.children_user - before.children_system
        print(
            f"rest {rest:g}: {state.phase} {state.reason}, {taken_s:.1f} s for {seconds:.0f} s of mission, "
            f"{spent_s:.1f} s of processor ({spent_s / taken_s:.2f} of a core), {state.bytes / 1e6:.1f} MB"
        )


async def measure_step(folder: Path, turns: int) -> None:
    """Time the analysis of steps without and with a video being made, in turns."""
    first = Frame(1, image(1), BANDS, nadir_pose([0.0, 0.0, 35.0]), CameraModel.from_fov(SIZE_PX, SIZE_PX, 0.87))
    frames = [
        replace(first, vehicle_id=number, pose=nadir_pose([3.0 * number, 0.0, 35.0 + number])) for number in range(10)
    ]
    times_s: dict[bool, list[float]] = {False: [], True: []}
    async with open_worker(ANALYSIS) as worker, opened(folder, REST_IN_FLIGHT) as maker:
        await worker.ready()
        for turn in range(2 * turns):
            is_making = turn % 2 == 1
            if is_making:
                maker.begin([], Notation.DECIMAL)
            until_s = time.perf_counter() + 8.0
            while time.perf_counter() < until_s and is_making is (maker.state().phase is VideoPhase.MAKING):
                began_s = time.perf_counter()
                await worker.run(analyse_step, frames, ImagingSettings())
                times_s[is_making].append(time.perf_counter() - began_s)
                await asyncio.sleep(STEP_PAUSE_S)
            maker.give_up()
    without_s, with_s = (statistics.median(times_s[is_making]) for is_making in (False, True))
    count = f"{len(times_s[False])} and {len(times_s[True])} steps"
    print(f"imaging step: {1000 * without_s:.1f} ms without, {1000 * with_s:.1f} ms beside a video ({count})")


async def measure(options: argparse.Namespace) -> None:
    """Measure all."""
    with tempfile.TemporaryDirectory() as parent:
        folder = await record(Path(parent), options.seconds)
        if "cost" in options.parts:
            await measure_cost(folder, options.seconds)
        if "step" in options.parts:
            await measure_step(folder, options.turns)


def main() -> None:
    """Read the options and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--turns", type=int, default=8, help="Turns without and with a video, 8 s each.")
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=PARTS)
    asyncio.run(measure(parser.parse_args()))


if __name__ == "__main__":
    main()
