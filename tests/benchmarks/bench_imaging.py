"""Medians of the imaging step on RGB+thermal frames of 512 x 512, beside plain references where there are some.

What is compared is measured in turn, round by round, so that the ratios hold on a machine that has other work to do.
All of it uses the threads it finds: OpenCV's own in the references, ours over bands and frames in the engine.

Run with ``python tests/benchmarks/bench_imaging.py``; with ``--recording DIR`` on ten frames of a recorded flight (a
folder with ``images`` and ``poses.json``) instead of synthetic ones.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from imaging_peer import bare_warps, peer_rx, peer_step
from recorded_frames import recorded_frames
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.detection.rx import rx_scores
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.model import AnomalySource, Detector, Frame
from aos_gcs.imaging.pictures import picture_shape, render_pictures
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.integration import integrate as integrate_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import perspective_view
from tests.benchmarks.figures import report

ROUNDS = 15
BANDS = ("red", "green", "blue", "thermal")
CAMERA = CameraModel.from_fov(512, 512, np.radians(50.0))
LENS = LensDistortion(LensModel.BROWN_CONRADY, (-0.2, 0.05, 0.0, 0.0, 0.0))
SETTINGS = ImagingSettings()


def make_frames(spacing_m: float, dtype: type[np.generic], count: int = 10) -> list[Frame]:
    """Smooth correlated bands with some noise and a warm spot, from ten altitudes; every frame its own memory."""
    rng = np.random.default_rng(0)
    shades = cv2.GaussianBlur(rng.normal(size=(512, 512, 4)), (0, 0), 4.0) * 150
    image = (120 + shades @ (np.eye(4) + 0.5) + rng.normal(size=(512, 512, 4)) * 3).clip(0, 255)
    image[250:258, 250:254, 3] = 250
    poses = [nadir_pose([(i - (count - 1) / 2) * spacing_m, rng.normal(), 35.0 + i % 10]) for i in range(count)]
    return [Frame(i, image.astype(dtype), BANDS, pose, CAMERA) for i, pose in enumerate(poses)]


def hills() -> Terrain:
    """Return a rolling hectare."""
    x, y = np.meshgrid(np.linspace(-50, 50, 401), np.linspace(-50, 50, 401))
    return Terrain(-50.0, -50.0, 0.25, np.sin(x / 7) + np.cos(y / 9))


@dataclass(frozen=True, slots=True)
class Cost:
    """Medians over the rounds."""

    wall_ms: float
    cpu_ms: float
    """Processor time of all threads; the better measure on a machine that has other work to do."""


def measure(*works: Callable[[], object], rounds: int = ROUNDS) -> list[Cost]:
    """Return the cost of each work; the works take turns."""
    wall_s: list[list[float]] = [[] for _ in works]
    cpu_s: list[list[float]] = [[] for _ in works]
    for work in works:
        work()
    for _ in range(rounds):
        for work, wall, cpu in zip(works, wall_s, cpu_s, strict=True):
            start_s, start_cpu_s = time.perf_counter(), time.process_time()
            work()
            wall.append(time.perf_counter() - start_s)
            cpu.append(time.process_time() - start_cpu_s)
    return [
        Cost(1e3 * statistics.median(wall), 1e3 * statistics.median(cpu))
        for wall, cpu in zip(wall_s, cpu_s, strict=True)
    ]


def ratio(cost: Cost, reference: Cost) -> str:
    """Return how much more a work costs than another."""
    return f"{cost.wall_ms / reference.wall_ms:.2f} times (CPU {cost.cpu_ms / reference.cpu_ms:.2f})"


def integral_rows() -> list[tuple[str, Cost, str]]:
    """Integrals of ten frames in the view of one of them, beside the bare warps of the same arrays."""
    frames, whole_bytes = make_frames(1.0, np.float32), make_frames(1.0, np.uint8)
    distorted = [replace(frame, camera=replace(CAMERA, distortion=LENS)) for frame in frames]
    # Turned against each other, frames no longer cover rectangles of the raster.
    turned = [
        replace(frame, pose=nadir_pose(frame.pose.position_enu_m, 0.3 * index)) for index, frame in enumerate(frames)
    ]
    plane, terrain = (perspective_view(CAMERA, frames[0].pose, surface) for surface in (0.0, hills()))
    bare, bare_turned, bare_bytes, on_plane, turned_on_plane, bytes_on_plane, on_terrain, through_lens = measure(
        lambda: bare_warps(frames),
        lambda: bare_warps(turned),
        lambda: bare_warps(whole_bytes),
        lambda: integrate(frames, plane, exact=False),
        lambda: integrate(turned, plane, exact=False),
        lambda: integrate(whole_bytes, plane, exact=False),
        lambda: integrate(frames, terrain, exact=False),
        lambda: integrate(distorted, plane, exact=False),
    )
    report("imaging.integral", on_plane.wall_ms, ratio=on_plane.wall_ms / bare.wall_ms)
    exact, view = measure(lambda: integrate(frames, plane), lambda: perspective_view(CAMERA, frames[0].pose, hills()))
    return [
        ("bare cv2.warpPerspective, ten frames, float32", bare, ""),
        ("plane, fast, float32", on_plane, f"{ratio(on_plane, bare)} the bare warps, goal 1.25"),
        ("bare cv2.warpPerspective, ten turned frames, float32", bare_turned, ""),
        ("plane, fast, float32, turned", turned_on_plane, f"{ratio(turned_on_plane, bare_turned)} the bare warps"),
        ("bare cv2.warpPerspective, ten frames, uint8", bare_bytes, ""),
        (
            "plane, fast, uint8 (warped as float32)",
            bytes_on_plane,
            f"{ratio(bytes_on_plane, bare_bytes)} the warps of bytes, {ratio(bytes_on_plane, bare)} those of floats",
        ),
        ("terrain, fast", on_terrain, f"{ratio(on_terrain, on_plane)} the plane, goal 2"),
        ("plane, fast, distorted lens", through_lens, f"{ratio(through_lens, on_plane)} the plane"),
        ("plane, exact", exact, f"{ratio(exact, on_plane)} the plane"),
        ("terrain's view, once", view, ""),
    ]


def detector_rows() -> list[tuple[str, Cost, str]]:
    """Detectors on one frame, RX beside that of a peer."""
    image = make_frames(1.0, np.float32, 1)[0].image
    gaps = image.copy()
    gaps[:40, :60] = np.nan
    name, rx = peer_rx()
    ours, peer, incomplete = measure(lambda: rx_scores(image), lambda: rx(image), lambda: rx_scores(gaps))
    difference = float(np.abs(rx_scores(image) - rx(image)).max())
    rows = [
        ("RX, one frame", ours, f"{peer.wall_ms / ours.wall_ms:.1f} times as fast as {name}, goal 5"),
        (f"RX, one frame, {name}", peer, f"greatest difference of scores {difference:.1e}"),
        ("RX, one frame with gaps", incomplete, f"{ratio(incomplete, ours)} the whole frame"),
    ]
    frames = make_frames(4.2, np.float32)
    chosen = [replace(SETTINGS, detector=detector) for detector in Detector if detector is not Detector.RX]
    chosen.append(replace(SETTINGS, anomaly_source=AnomalySource.INTEGRAL))
    works = [lambda own=settings: whole_step(frames, own) for settings in chosen]
    costs = measure(*works, rounds=5)
    return rows + [
        (f"step, {settings.detector_of(frames[0].bands)}, {settings.anomaly_source}", cost, "")
        for settings, cost in zip(chosen, costs, strict=True)
    ]


def whole_step(frames: list[Frame], settings: ImagingSettings = SETTINGS) -> None:
    """Analyse a step, and integrate its frames as its pictures ask for."""
    grid = analyse_step(frames, settings).grid
    integrate_step(frames, grid, picture_shape(grid.rows, grid.columns))


def step_rows() -> list[tuple[str, Cost, str]]:
    """Whole steps, and how they grow with the number of frames."""
    line, line_bytes, close = make_frames(4.2, np.float32), make_frames(4.2, np.uint8), make_frames(1.0, np.float32)
    distorted = [replace(frame, camera=replace(CAMERA, distortion=LENS)) for frame in line]
    analysis = analyse_step(line, SETTINGS)
    ours, in_bytes, converged, through_lens = measure(
        lambda: whole_step(line),
        lambda: whole_step(line_bytes),
        lambda: whole_step(close),
        lambda: whole_step(distorted),
    )
    report("imaging.step", ours.wall_ms)
    report("imaging.step_bytes", in_bytes.wall_ms)
    pictures = measure(lambda: render_pictures(line, analysis))[0]
    rows = [
        ("step, line of 10, float32", ours, "target 60 ms on 2 cores"),
        ("step, line of 10, uint8", in_bytes, ""),
        ("step, converged 10, float32", converged, ""),
        ("step, line of 10, distorted lens", through_lens, f"{ratio(through_lens, ours)} the ideal one"),
        ("render_pictures, with the integral", pictures, ""),
    ]
    for count in (10, 30, 100):
        frames = make_frames(0.3, np.uint8, count)
        cost = measure(lambda own=frames: whole_step(own), rounds=7)[0]
        rows.append((f"step, {count} frames close together", cost, f"{cost.wall_ms / count:.2f} ms per frame"))
    return rows


def peer_rows() -> list[tuple[str, Cost, str]]:
    """Steps beside a straightforward pipeline with n x n renders."""
    name, rx = peer_rx()
    rows = []
    for count, rounds in ((10, 5), (30, 2)):
        frames = make_frames(1.0, np.float32, count)
        ours, peer = measure(lambda own=frames: whole_step(own), lambda own=frames: peer_step(own, rx), rounds=rounds)
        if count == 10:
            report("imaging.peer_step", ours.wall_ms, ratio=ours.wall_ms / peer.wall_ms)
        times = f"ours is {peer.wall_ms / ours.wall_ms:.1f} times as fast (CPU {peer.cpu_ms / ours.cpu_ms:.1f})"
        rows.append((f"{count} frames, RX of {name}, {count} x {count} renders", peer, f"{times}, goal 15"))
    return rows


def recording_rows(frames: list[Frame]) -> list[tuple[str, Cost, str]]:
    """Steps of recorded frames in bytes, beside a straightforward pipeline."""
    name, rx = peer_rx()
    floats = [replace(frame, image=frame.image.astype(np.float32)) for frame in frames]
    analysis = analyse_step(frames, SETTINGS)
    marked = int(analysis.anomaly_count.sum())
    others = [replace(SETTINGS, detector=detector) for detector in Detector if detector is not Detector.RX]
    others.append(replace(SETTINGS, anomaly_source=AnomalySource.INTEGRAL))
    ours, in_floats, analysed, peer, pictures = measure(
        lambda: whole_step(frames),
        lambda: whole_step(floats),
        lambda: analyse_step(frames, SETTINGS),
        lambda: peer_step(floats, rx),
        lambda: render_pictures(frames, analysis),
        rounds=7,
    )
    grid = f"grid of {analysis.grid.rows} x {analysis.grid.columns}, {marked} marks"
    times = f"ours is {peer.wall_ms / ours.wall_ms:.1f} times as fast (CPU {peer.cpu_ms / ours.cpu_ms:.1f}), goal 8"
    costs = measure(*[lambda own=settings: whole_step(frames, own) for settings in others], rounds=5)
    return [
        ("recorded step, 10 frames, uint8", ours, f"{grid}; target 60 ms on 2 cores"),
        ("recorded step, 10 frames, float32", in_floats, ""),
        ("its analysis alone", analysed, ""),
        ("render_pictures, with the integral", pictures, "goal 30"),
        (f"10 frames, RX of {name}, 10 x 10 renders", peer, times),
        *(
            (f"recorded step, {settings.detector_of(frames[0].bands)}, {settings.anomaly_source}", cost, "")
            for settings, cost in zip(others, costs, strict=True)
        ),
    ]


MEMORY_PROGRAM = r"""
import re, sys
from pathlib import Path
sys.path.insert(0, {folder!r})
from bench_imaging import make_frames, whole_step
import numpy as np
def memory_mb(field):
    # Not ru_maxrss: a child inherits its parent's.
    return int(re.search(field + r":\s+(\d+) kB", Path("/proc/self/status").read_text())[1]) / 1024
whole_step(make_frames(4.2, np.{dtype}, 1))
imported = memory_mb("VmRSS")
frames = make_frames(4.2, np.{dtype}, 100)
loaded = memory_mb("VmRSS")
whole_step(frames)
print(imported, loaded, memory_mb("VmHWM"))
"""


def memory_lines() -> list[str]:
    """Return the peak of a process of its own that analyses 100 frames in a line."""
    lines = []
    for dtype in ("uint8", "float32"):
        program = MEMORY_PROGRAM.format(folder=str(Path(__file__).resolve().parent), dtype=dtype)
        command = [sys.executable, "-c", program]
        told = subprocess.run(command, capture_output=True, text=True, check=True).stdout  # noqa: S603 - our own text
        imported, loaded, peak = map(float, told.split())
        lines.append(
            f"100 frames of 512 x 512 x 4 {dtype}, at the peak: {loaded - imported:.0f} MB of frames, "
            f"{peak - loaded:.0f} MB for the analysis, {imported:.0f} MB for imports and a step of one frame"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recording", type=Path, metavar="DIR", help="folder with images and poses.json")
    parser.add_argument("--fov", type=float, default=50.815436217896945, help="field of view of the recording, degrees")
    parser.add_argument("--convention", default="z-down", help="meaning of its poses, as of aos-gcs integrate")
    parser.add_argument("--plane-z", type=float, default=-18.0, help="height of the focal plane in its world, metres")
    options = parser.parse_args()
    console = Console(width=160)
    table = Table("work", "wall ms", "CPU ms", "note")
    if options.recording is None:
        rows = [*integral_rows(), *detector_rows(), *step_rows(), *peer_rows()]
    else:
        where = {"fov_deg": options.fov, "convention": options.convention, "plane_z_m": options.plane_z}
        rows = recording_rows(recorded_frames(options.recording, 10, bands=BANDS, **where))
    for name, cost, note in rows:
        table.add_row(name, f"{cost.wall_ms:.1f}", f"{cost.cpu_ms:.1f}", note)
    console.print(table)
    console.print(f"{os.cpu_count()} cores, OpenCV {cv2.__version__} with {cv2.getNumThreads()} threads")
    for line in memory_lines() if options.recording is None else []:
        console.print(line)


if __name__ == "__main__":
    main()
