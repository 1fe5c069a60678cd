"""Registration against the truth in simulated forests: what is found, and what it is good for.

Run with ``python tests/benchmarks/bench_registration.py [TREES_PER_HA ...]``; a density takes a minute or two.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane, project_points
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.registration.pose_errors import Registration, apply_sure, register
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_sim.errors.attitude import AttitudeProcess
from aos_sim.errors.model import GNSS, ErrorModel
from aos_sim.errors.position import PositionProcess
from aos_sim.render.renderer import Renderer
from aos_sim.world.scene import SceneParameters, build_scene

CAMERA = CameraModel.from_fov(512, 512, np.radians(50.0))
BANDS = ("red", "green", "blue", "thermal")
VEHICLES = 10
SPACING_M = 4.2
STEPS = 24
SHOWN = (1, 4, 8, 16, 24)
MIN_CONFIDENCE = 0.6
BUDGETS = {
    "positions and headings": replace(GNSS, gimbal=replace(GNSS.gimbal, tilt_rad=0.0, jitter_rad=0.0)),
    "tilts, too": GNSS,
}

CONSOLE = Console()


def places(rng: np.random.Generator) -> NDArray[np.float64]:
    """Places of hovering about a target, step by step: first in a line, then gathered, shape (steps, n, 2)."""
    place_m = np.column_stack((SPACING_M * (np.arange(VEHICLES) - (VEHICLES - 1) / 2), np.zeros(VEHICLES)))
    steps = []
    for step in range(STEPS):
        steps.append(place_m + np.array([0.0, -2.0 * max(0, 6 - step)]))
        if step >= 6:
            place_m = _apart(0.85 * place_m + rng.normal(0.0, 1.0, place_m.shape))
    return np.array(steps)


def _apart(place_m: NDArray[np.float64]) -> NDArray[np.float64]:
    for _ in range(60):
        away_m = place_m[:, np.newaxis] - place_m
        distance_m = np.linalg.norm(away_m, axis=2) + 99.0 * np.eye(len(place_m))
        push = np.maximum(SPACING_M - distance_m, 0.0) / distance_m
        place_m = place_m + 0.25 * np.sum(push[:, :, np.newaxis] * away_m, axis=1)
    return place_m


@dataclass
class Follower:
    """One budget's vehicles: what they report, and what registration makes of it."""

    position_enu_m: NDArray[np.float64]
    """Errors of the positions, shape (n, 3)."""
    turn_rad: NDArray[np.float64]
    """Constant turns about the axes of the cameras, shape (n, 3); the last is the heading's error."""
    jitter_rad: float
    rng: np.random.Generator
    registration: Registration

    @classmethod
    def of(cls, errors: ErrorModel, seed: int) -> Follower:
        rng, gimbal = np.random.default_rng([seed, 2]), errors.gimbal
        turn_rad = rng.standard_normal((VEHICLES, 3)) * np.array([gimbal.tilt_rad, gimbal.tilt_rad, 0.0])
        turn_rad[:, 2] = AttitudeProcess(errors.attitude, VEHICLES, seed).estimate_rad[:, 2]
        position_enu_m = PositionProcess(errors.position, VEHICLES, seed).estimate_enu_m
        return cls(position_enu_m, turn_rad, gimbal.jitter_rad, rng, Registration())

    def report(self, exposures: Sequence[Frame]) -> list[Frame]:
        """The frames with the poses that the vehicles report."""
        frames = []
        for frame, shift_m, turn_rad in zip(exposures, self.position_enu_m, self.turn_rad, strict=True):
            turn = Rotation.from_rotvec(turn_rad + self.rng.standard_normal(3) * self.jitter_rad).as_matrix()
            pose = Pose(frame.pose.position_enu_m + shift_m, frame.pose.R_cam2enu @ turn)
            frames.append(replace(frame, pose=pose))
        return frames

    def left_over(self) -> tuple[float, float]:
        """RMS error of the corrections relative to the fleet: offset per axis in metres, yaw in degrees."""
        corrections = self.registration.corrections().values()
        found = np.array([[c.east_m, c.north_m, c.yaw_rad] for c in corrections])
        true = -np.column_stack((self.position_enu_m[:, :2], self.turn_rad[:, 2]))
        rest = (found - found.mean(axis=0)) - (true - true.mean(axis=0))
        return rms(rest[:, :2]), rms(np.degrees(rest[:, 2]))


def rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(values**2)))


def misalignment_m(true: Sequence[Pose], believed: Sequence[Frame], point_enu_m: NDArray[np.float64]) -> float:
    """Distance of where frames lay a point on the ground from where they lay it on average, RMS per axis."""
    laid_m = [
        intersect_plane(project_points([point_enu_m], CAMERA, pose), CAMERA, frame.pose, 0.0)[0, :2]
        for pose, frame in zip(true, believed, strict=True)
    ]
    seen_m = np.array(laid_m)[np.isfinite(laid_m).all(axis=1)]
    return rms(seen_m - seen_m.mean(axis=0))


def fly(trees_per_ha: int, seed: int) -> dict[tuple[str, int], list[float]]:
    """Return the figures of each budget after each of the shown steps."""
    renderer = Renderer(build_scene(SceneParameters(seed=seed, trees_per_ha=trees_per_ha, side_m=60)))
    person_enu_m = renderer.scene.persons[0].position_enu_m
    rng = np.random.default_rng([seed, 0])
    followers = {name: Follower.of(errors, seed) for name, errors in BUDGETS.items()}
    figures = {}
    for step, place_m in enumerate(places(rng), start=1):
        poses = [nadir_pose([*(person_enu_m[:2] + xy), 35.0 + 2.0 * i]) for i, xy in enumerate(place_m)]
        exposures = [
            Frame(i + 1, np.dstack((image.rgb.astype(np.float32), image.thermal_celsius)), BANDS, pose, CAMERA)
            for i, (pose, own) in enumerate(zip(poses, rng.spawn(len(poses)), strict=True))
            for image in [renderer.render(pose, CAMERA, own)]
        ]
        for name, follower in followers.items():
            reported = follower.report(exposures)
            believed = apply_sure(follower.registration, reported, MIN_CONFIDENCE)
            before, after = (misalignment_m(poses, frames, person_enu_m) for frames in (reported, believed))
            counts = [agreeing(frames) for frames in (reported, believed)]
            started_s = time.perf_counter()
            follower.registration = register(reported, follower.registration, 0.0)
            took_s = time.perf_counter() - started_s
            figures[name, step] = [
                *follower.left_over(),
                follower.registration.confidence,
                before,
                after,
                *counts,
                took_s,
            ]
    return figures


def agreeing(frames: Sequence[Frame]) -> int:
    """Number of frames that agree on one cell of the largest blob."""
    blob = analyse_step(frames, ImagingSettings()).blob
    return 0 if blob is None else blob.max_count


def main(densities: Sequence[int], worlds: int) -> None:
    for trees_per_ha in densities:
        flights = [fly(trees_per_ha, seed) for seed in range(1, worlds + 1)]
        table = Table(
            "budget", "steps", "offset m", "yaw deg", "confidence", "ground m", "corrected", "agree", "corrected", "s"
        )
        for name in BUDGETS:
            earlier = 0
            for step in SHOWN:
                rows = [flight[name, k] for flight in flights for k in range(earlier + 1, step + 1)]
                last = np.mean([flight[name, step] for flight in flights], axis=0)
                between = np.mean(rows, axis=0)
                table.add_row(
                    name,
                    f"{earlier + 1} to {step}",
                    *(f"{v:.2f}" for v in last[:3]),
                    *(f"{v:.2f}" for v in between[3:]),
                )
                earlier = step
        CONSOLE.print(
            f"{trees_per_ha} trees/ha, {worlds} worlds; offset, yaw and confidence after the last of the steps; the "
            "mean over them of the scatter of a ground point, and of the frames that agree on a cell, each as reported "
            "and corrected"
        )
        CONSOLE.print(table)


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [300, 400, 500], worlds=3)
