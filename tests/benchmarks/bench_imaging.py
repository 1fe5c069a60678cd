"""Medians of the imaging step: ten RGB+thermal frames of 512 x 512, beside a plain reference where there is one.

Run with ``python tests/benchmarks/bench_imaging.py``.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.integral import integrate, integrate_on_grid
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.pictures import render_pictures
from aos_gcs.imaging.rx import rx_scores
from aos_gcs.imaging.step import ImagingSettings, analyse_step
from aos_gcs.imaging.terrain import Terrain
from aos_gcs.imaging.views import perspective_view
from aos_gcs.imaging.warp import locate, warp_image

FRAMES = 10
ROUNDS = 15
BANDS = ("red", "green", "blue", "thermal")
CAMERA = CameraModel.from_fov(512, 512, np.radians(50.0))


def make_frames(spacing_m: float, dtype: type[np.generic]) -> list[Frame]:
    """Smooth correlated bands with some noise and a warm spot, from ten altitudes."""
    rng = np.random.default_rng(0)
    shades = cv2.GaussianBlur(rng.normal(size=(512, 512, 4)), (0, 0), 4.0) * 150
    image = (120 + shades @ (np.eye(4) + 0.5) + rng.normal(size=(512, 512, 4)) * 3).clip(0, 255)
    image[250:258, 250:254, 3] = 250
    poses = [nadir_pose([(i - 4.5) * spacing_m, rng.normal(), 35.0 + i]) for i in range(FRAMES)]
    return [Frame(i, image.astype(dtype), BANDS, pose, CAMERA) for i, pose in enumerate(poses)]


def plain_rx(image: NDArray[np.float32]) -> NDArray[np.float64]:
    pixels = image.reshape(-1, image.shape[2]).astype(np.float64)
    pixels -= pixels.mean(axis=0)
    inverse = np.linalg.pinv(np.cov(pixels, rowvar=False))
    return np.einsum("ij,jk,ik->i", pixels, inverse, pixels).reshape(image.shape[:2])


@dataclass(frozen=True, slots=True)
class Cost:
    """Medians over the rounds."""

    wall_ms: float
    cpu_ms: float
    """Of all threads; the better measure on a machine that has other work to do."""


def measure(work: Callable[[], object]) -> Cost:
    work()
    wall_s, cpu_s = [], []
    for _ in range(ROUNDS):
        start_s, start_cpu_s = time.perf_counter(), time.process_time()
        work()
        wall_s.append(time.perf_counter() - start_s)
        cpu_s.append(time.process_time() - start_cpu_s)
    return Cost(1e3 * statistics.median(wall_s), 1e3 * statistics.median(cpu_s))


def hills() -> Terrain:
    """Return a rolling hectare."""
    x, y = np.meshgrid(np.linspace(-50, 50, 401), np.linspace(-50, 50, 401))
    return Terrain(-50.0, -50.0, 0.25, np.sin(x / 7) + np.cos(y / 9))


def bare_warps(frames: list[Frame]) -> list[int]:
    """Warp every frame to the view of the first one, as OpenCV does it, and nothing else."""
    from_view = np.linalg.inv(plane_to_image(CAMERA, frames[0].pose, 0.0))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    maps = [plane_to_image(frame.camera, frame.pose, 0.0) @ from_view for frame in frames]
    return [cv2.warpPerspective(f.image, H, (512, 512), flags=flags).size for f, H in zip(frames, maps, strict=True)]


def view_rows(frames: list[Frame], frames_bytes: list[Frame]) -> list[tuple[str, Cost, str]]:
    """Integrals in the view of one of the frames, on a plane and on terrain, beside the bare warps."""
    lens = LensDistortion(LensModel.BROWN_CONRADY, (-0.2, 0.05, 0.0, 0.0, 0.0))
    distorted = [replace(frame, camera=replace(CAMERA, distortion=lens)) for frame in frames]
    plane, terrain = (perspective_view(CAMERA, frames[0].pose, surface) for surface in (0.0, hills()))
    bare = measure(lambda: bare_warps(frames))
    on_plane = measure(lambda: integrate(frames, plane, exact=False))
    bare_bytes = measure(lambda: bare_warps(frames_bytes))
    bytes_on_plane = measure(lambda: integrate(frames_bytes, plane, exact=False))
    on_terrain = measure(lambda: integrate(frames, terrain, exact=False))
    through_lens = measure(lambda: integrate(distorted, plane, exact=False))
    exact = measure(lambda: integrate(frames, plane))
    return [
        ("bare cv2.warpPerspective, ten frames", bare, ""),
        ("plane, fast", on_plane, f"{on_plane.wall_ms / bare.wall_ms:.2f} times the bare warps, goal 1.25"),
        ("bare cv2.warpPerspective, uint8", bare_bytes, ""),
        (
            "plane, fast, uint8",
            bytes_on_plane,
            f"{bytes_on_plane.wall_ms / bare_bytes.wall_ms:.2f} times the bare warps, goal 1.25",
        ),
        ("terrain, fast", on_terrain, f"{on_terrain.wall_ms / on_plane.wall_ms:.2f} times the plane, goal 2"),
        ("plane, fast, distorted lens", through_lens, f"{through_lens.wall_ms / on_plane.wall_ms:.2f} times the plane"),
        ("plane, exact", exact, f"{exact.wall_ms / on_plane.wall_ms:.2f} times the plane"),
        ("terrain's view, once", measure(lambda: perspective_view(CAMERA, frames[0].pose, hills())), ""),
    ]


def main() -> None:
    line, line_bytes, close = make_frames(4.2, np.float32), make_frames(4.2, np.uint8), make_frames(1.0, np.float32)
    grid = choose_grid(line, 0.0)
    patches = [patch for patch in (locate(frame, grid) for frame in line) if patch is not None]
    settings = ImagingSettings()
    analysis = analyse_step(line, settings)
    rx = measure(lambda: rx_scores(line[0].image))
    plain = measure(lambda: plain_rx(line[0].image))
    rows = [
        ("RX, one frame", rx, ""),
        ("RX, one frame, plain float64", plain, f"{plain.cpu_ms / rx.cpu_ms:.1f} times the time"),
        (
            "warp, ten frames",
            measure(lambda: [warp_image(f.image, p)[0].size for f, p in zip(line, patches, strict=True)]),
            "",
        ),
        (
            "integrate_on_grid, ten frames",
            measure(lambda: integrate_on_grid(line, grid)),
            f"{grid.rows} x {grid.columns}",
        ),
        ("analyse_step, line, float32", measure(lambda: analyse_step(line, settings)), "target 60 ms, limit 150 ms"),
        ("analyse_step, line, uint8", measure(lambda: analyse_step(line_bytes, settings)), ""),
        ("analyse_step, converged, float32", measure(lambda: analyse_step(close, settings)), ""),
        ("render_pictures", measure(lambda: render_pictures(analysis, BANDS)), "target 30 ms"),
        *view_rows(close, make_frames(1.0, np.uint8)),
    ]
    table = Table("work", "wall ms", "CPU ms", "note")
    for name, cost, note in rows:
        table.add_row(name, f"{cost.wall_ms:.1f}", f"{cost.cpu_ms:.1f}", note)
    Console().print(table)


if __name__ == "__main__":
    main()
