"""Autofocus and the statistics of the aperture against what is known: a recorded flight and simulated forests.

Run with ``python tests/benchmarks/bench_autofocus.py``; it takes a minute or two. The recorded flight is left out where
it is absent.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import pixel_rays
from aos_gcs.imaging.aperture import integral_visibility, seen_at_least_once, smallest_spacing_m
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.measure import FocusSignal
from aos_gcs.imaging.focus.region import FocusRegion, GroundRegion, ViewRegion
from aos_gcs.imaging.focus.terrain import find_terrain_focus
from aos_gcs.imaging.integral import integrate
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.dem_files import read_dem
from aos_gcs.imaging.views import perspective_view
from aos_gcs.surveys.images import LazyFrames
from aos_gcs.surveys.poses_file import read_poses
from aos_sim.render.raycaster import RayCaster
from aos_sim.render.renderer import Renderer
from aos_sim.world.scene import SceneParameters, build_scene

RECORDINGS = Path(__file__).resolve().parents[3] / "shared" / "data"
RECORDED, FLIGHT = RECORDINGS / "F0", RECORDINGS / "F0_flight"
FIRST_FRAMES, FRAMES = (12, 33, 55, 76, 98, 119, 141, 162), 30
FOV_DEG, TERRAIN_SHIFT_M = 50.815436217896945, -1.0
WINDOWS = {"three people": (130, 100, 270, 230), "whole view": (0, 0, 511, 511), "no people": (280, 280, 450, 450)}
CAMERA = CameraModel.from_fov(512, 512, np.radians(50.0))
BANDS = ("red", "green", "blue", "thermal")
ALTITUDE_M = 35.0
SPACINGS_M = (0.25, 0.5, 1.0, 2.0, 4.2, 8.0)

CONSOLE = Console()


def sharpness(image: NDArray[np.float32]) -> tuple[float, float, float]:
    """The usual measures of an integral's focus, to compare with: variance, Tenengrad, Laplacian."""
    grey = cv2.GaussianBlur(np.nan_to_num(image), (0, 0), 1.0)
    slopes = cv2.Sobel(grey, cv2.CV_32F, 1, 0) ** 2 + cv2.Sobel(grey, cv2.CV_32F, 0, 1) ** 2
    return float(grey.var()), float(slopes.mean()), float(cv2.Laplacian(grey, cv2.CV_32F).var())


def sharpest(frames: Sequence[Frame], pose: Pose, heights_m: NDArray[np.float64]) -> dict[str, list[float]]:
    """The best height of each window by each of the usual measures."""
    scores: dict[str, list[list[float]]] = {name: [] for name in WINDOWS}
    for height_m in heights_m:
        integral, _ = integrate(frames, perspective_view(frames[0].camera, pose, float(height_m)))
        for name, (left, top, right, bottom) in WINDOWS.items():
            scores[name].append(list(sharpness(integral[top:bottom, left:right, 0])))
    return {name: heights_m[np.argmax(values, axis=0)].tolist() for name, values in scores.items()}


def recorded_flight() -> None:
    if not RECORDED.is_dir():
        CONSOLE.print("The recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository.")
        return
    render = json.loads((RECORDED / "reference" / "renders.json").read_text())["renders"][0]
    M = np.array(render["virtual_pose_world_to_camera_cv"])
    pose = Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)
    fov_rad = np.radians(render["view_fov_deg"])
    survey = read_poses(RECORDED / "poses.json", RECORDED / "images", fov_rad)
    frames = list(LazyFrames(survey.images, survey.bands))
    table = Table("region", "agreement", "confidence", "s", "variance", "tenengrad", "laplacian")
    others = sharpest(frames, pose, np.arange(5.0, 25.5, 1.0))
    for name, window in WINDOWS.items():
        view = ViewRegion(frames[0].camera, pose, window)
        started_s = time.perf_counter()
        result = find_focus(frames, view, 5.0, 25.0)
        took_s = time.perf_counter() - started_s
        height = f"{result.height_m:.2f}" if result.found else "not found"
        row = [f"{best_m:.0f}" for best_m in others[name]]
        table.add_row(name, height, f"{result.confidence:.2f}", f"{took_s:.1f}", *row)
    CONSOLE.print("Recorded flight F0, z from 5 to 25 m; the people lie on z = 18 m. Best z by measure:")
    CONSOLE.print(table)


def recorded_windows() -> None:
    if not (RECORDED.is_dir() and FLIGHT.is_dir()):
        return
    survey = read_poses(FLIGHT / "poses.json", FLIGHT / "images", np.radians(FOV_DEG))
    frames = list(LazyFrames(survey.images, survey.bands))
    given = read_dem(RECORDED / "dem_lr.obj.gz", None, np.eye(3))
    table = Table("first frame", "ground z", "level plane: error m", "CPU s", "terrain: error m", "CPU s")
    for first in FIRST_FRAMES:
        window = frames[first : first + FRAMES]
        middle = window[FRAMES // 2]
        view = ViewRegion.whole(middle.camera, middle.pose)
        ray = pixel_rays(
            [[(middle.camera.width_px - 1) / 2, (middle.camera.height_px - 1) / 2]], middle.camera, middle.pose
        )
        ground_m = float(given.moved(TERRAIN_SHIFT_M).intersect(middle.pose.position_enu_m, ray)[0, 2])
        started_s = time.process_time()
        plane = find_focus(window, view, 5.0, 25.0)
        plane_s = time.process_time() - started_s
        started_s = time.process_time()
        terrain = find_terrain_focus(window, view, given, -5.0, 5.0)
        terrain_s = time.process_time() - started_s
        table.add_row(
            str(first),
            f"{ground_m:.1f}",
            f"{plane.height_m - ground_m:+.2f} ± {plane.sigma_m:.2f}" if plane.found else f"not found: {plane.reason}",
            f"{plane_s:.1f}",
            f"{terrain.offset_m - TERRAIN_SHIFT_M:+.2f} ± {terrain.sigma_m:.2f}",
            f"{terrain_s:.1f}",
        )
    CONSOLE.print(f"Recorded flight, windows of {FRAMES} frames; the ground is the terrain {TERRAIN_SHIFT_M:+g} m:")
    CONSOLE.print(table)


def simulated_focus(worlds: int) -> None:
    table = Table("trees/ha", "range m", "signal", "found", "median error m", "greatest error m")
    for trees_per_ha in (100, 300):
        renderers = [
            Renderer(build_scene(SceneParameters(seed=seed, side_m=60, trees_per_ha=trees_per_ha)))
            for seed in range(1, worlds + 1)
        ]
        steps = [simulated_step(renderer) for renderer in renderers]
        for low_m, high_m in ((-5.0, 5.0), (-5.0, 20.0)):
            for signal in FocusSignal:
                results = [find_focus(frames, region, low_m, high_m, signal=signal) for frames, region in steps]
                errors = [abs(result.height_m) for result in results if result.found] or [np.nan]
                table.add_row(
                    str(trees_per_ha),
                    f"{low_m:g} to {high_m:g}",
                    signal.value,
                    f"{sum(result.found for result in results)} of {worlds}",
                    f"{np.median(errors):.2f}",
                    f"{np.max(errors):.2f}",
                )
    CONSOLE.print("Simulated forests, ten drones about a standing person; the ground is z = 0:")
    CONSOLE.print(table)


def simulated_step(renderer: Renderer) -> tuple[list[Frame], FocusRegion]:
    east, north, _ = renderer.scene.persons[0].position_enu_m
    rng = np.random.default_rng(0)
    places = [(4.2 * (i % 4 - 1.5), 4.2 * (i // 4 - 1.0)) for i in range(10)]
    poses = [nadir_pose([east + x, north + y, ALTITUDE_M + i]) for i, (x, y) in enumerate(places)]
    images = [renderer.render(pose, CAMERA, own) for pose, own in zip(poses, rng.spawn(len(poses)), strict=True)]
    frames = [
        Frame(i, np.dstack((image.rgb.astype(np.float32), image.thermal_celsius)), BANDS, pose, CAMERA)
        for i, (image, pose) in enumerate(zip(images, poses, strict=True))
    ]
    return frames, GroundRegion(east - 5, north - 5, east + 5, north + 5)


def free_rays(
    forest: RayCaster, rng: np.random.Generator, offsets_m: Callable[[int], NDArray[np.float64]], points: int
) -> NDArray[np.bool_]:
    """Whether points on the ground are seen from each of some positions, shape (points, positions)."""
    ground = np.column_stack((rng.uniform(-15, 15, points), rng.uniform(23, 53, points), np.full(points, 0.05)))
    offsets = np.stack([offsets_m(point) for point in range(points)])
    positions = ground[:, np.newaxis, :2] + offsets
    targets = np.broadcast_to(ground[:, np.newaxis], (*positions.shape[:2], 3)).reshape(-1, 3)
    cameras = np.column_stack((positions.reshape(-1, 2), np.full(len(targets), ALTITUDE_M)))
    origins = targets.astype(np.float32)
    return forest.is_free(origins, (cameras - targets).astype(np.float32)).reshape(positions.shape[:2])


def simulated_aperture(worlds: int) -> None:
    forests = [
        RayCaster(build_scene(SceneParameters(seed=seed, side_m=60, trees_per_ha=300)).forest.mesh.triangles_enu_m)
        for seed in range(1, worlds + 1)
    ]
    rng = np.random.default_rng(0)
    free = np.vstack([free_rays(forest, rng, lambda _: rng.uniform(-10, 10, (20, 2)), 1000) for forest in forests])
    occlusion = 1.0 - float(free.mean())
    table = Table("samples", "1 - E(x²): forest", "model", "seen at least once: forest", "model")
    for samples in (1, 2, 3, 5, 10, 20):
        seen = free[:, :samples]
        visibility = 1.0 - float(np.mean((1.0 - seen.mean(axis=1)) ** 2))
        model = integral_visibility(occlusion, samples), seen_at_least_once(occlusion, samples)
        table.add_row(
            str(samples),
            f"{visibility:.3f}",
            f"{model[0]:.3f}",
            f"{seen.any(axis=1).mean():.3f}",
            f"{model[1]:.3f}",
        )
    CONSOLE.print(f"300 trees/ha, {worlds} worlds, cameras anywhere within 20 m: occlusion {occlusion:.3f}")
    CONSOLE.print(table)
    table = Table("spacing m", "correlation", "visibility of 10", "seen at least once by 10", "occluder it suits, m")
    for spacing_m in SPACINGS_M:
        free = np.vstack([free_rays(forest, rng, lambda _, d=spacing_m: lattice(rng, d), 1000) for forest in forests])
        mean = free.mean()
        correlation = float(np.mean((free[:, 0] - mean) * (free[:, 1] - mean)) / (mean * (1 - mean)))
        visibility = 1.0 - float(np.mean((1.0 - free.mean(axis=1)) ** 2))
        size_m = spacing_m / smallest_spacing_m(ALTITUDE_M, 12.0, 1.0)
        table.add_row(
            f"{spacing_m:g}",
            f"{correlation:.2f}",
            f"{visibility:.3f}",
            f"{free.any(axis=1).mean():.3f}",
            f"{size_m:.2f}",
        )
    CONSOLE.print("Ten cameras on a lattice of 4 x 3 places, by spacing (occluders at 12 m height):")
    CONSOLE.print(table)


def lattice(rng: np.random.Generator, spacing_m: float) -> NDArray[np.float64]:
    """Ten of 4 x 3 places at a spacing, turned at random and centred anywhere within 4 m, shape (10, 2)."""
    places = spacing_m * np.array([(i % 4 - 1.5, i // 4 - 1.0) for i in range(10)])
    angle_rad = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle_rad), -np.sin(angle_rad)], [np.sin(angle_rad), np.cos(angle_rad)]])
    return places @ turn.T + rng.uniform(-4, 4, 2)


if __name__ == "__main__":
    recorded_flight()
    recorded_windows()
    simulated_focus(worlds=4)
    simulated_aperture(worlds=8)
