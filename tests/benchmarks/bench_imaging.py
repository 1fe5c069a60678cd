"""Medians of the imaging step: ten RGB+thermal frames of 512 x 512, beside a plain reference where there is one.

Run with ``python tests/benchmarks/bench_imaging.py``.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.focal_plane import choose_grid
from aos_gcs.imaging.integral import integrate_on_grid
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.pictures import render_pictures
from aos_gcs.imaging.rx import rx_scores
from aos_gcs.imaging.step import ImagingSettings, analyse_step
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
    ]
    table = Table("work", "wall ms", "CPU ms", "note")
    for name, cost, note in rows:
        table.add_row(name, f"{cost.wall_ms:.1f}", f"{cost.cpu_ms:.1f}", note)
    Console().print(table)


if __name__ == "__main__":
    main()
