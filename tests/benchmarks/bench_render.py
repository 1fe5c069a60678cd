"""Measure the renderer: ``python tests/benchmarks/bench_render.py``."""

# ruff: noqa: T201  a script that prints

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.render import Renderer
from aos_sim.world.scene import Scene, SceneParameters, build_scene

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
VISIBILITY_SEEDS = 8
VIEWS_PER_SEED = 60


def main() -> None:
    """Print medians of the times, and the mean visibility of a person."""
    parameters = SceneParameters()
    scene, renderer = build_scene(parameters), Renderer(build_scene(parameters))
    rng = np.random.default_rng(0)
    poses = views_of_person(scene, 10, rng)
    print(f"world of {len(scene.forest.trunk_enu_m)} trees, {len(scene.forest.mesh):,} triangles")
    print(f"build scene                 {median_s(3, lambda: build_scene(parameters)):.3f} s")
    print(f"build renderer              {median_s(3, lambda: Renderer(scene)):.3f} s")
    print(f"one frame 512 x 512         {median_s(10, lambda: renderer.render(poses[0], CAMERA, rng)):.3f} s")
    print(f"ten frames, two threads     {median_s(5, lambda: renderer.render_many(poses, CAMERA, rng)):.3f} s")
    print(f"masks of a person           {median_s(10, lambda: renderer.person_masks(poses[0], CAMERA)):.3f} s")
    shares = single_view_visibilities()
    print(f"mean single-view visibility {shares.mean():.3f} (by seed {np.round(shares.mean(axis=1), 2).tolist()})")


def median_s(repetitions: int, action: Callable[[], object]) -> float:
    """Median time of an action."""
    durations = []
    for _ in range(repetitions):
        start = time.perf_counter()
        action()
        durations.append(time.perf_counter() - start)
    return statistics.median(durations)


def views_of_person(scene: Scene, count: int, rng: np.random.Generator) -> list[Pose]:
    """Nadir views from 35-44 m, spread evenly over a disc of 12 m round the first person."""
    radius = 12.0 * np.sqrt(rng.uniform(size=count))
    angle = rng.uniform(0.0, 2 * np.pi, count)
    height = rng.uniform(35.0, 44.0, count)
    offset = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    return [nadir_pose(position) for position in scene.persons[0].position_enu_m + offset]


def single_view_visibilities() -> np.ndarray:
    """Visibility of a standing person at 300 trees/ha, shape (seeds, views)."""
    shares = []
    for seed in range(1, VISIBILITY_SEEDS + 1):
        scene = build_scene(SceneParameters(seed=seed, side_m=60.0))
        renderer = Renderer(scene)
        views = views_of_person(scene, VIEWS_PER_SEED, np.random.default_rng(seed))
        shares.append([renderer.person_visibility(view, CAMERA) or 0.0 for view in views])
    return np.array(shares)


if __name__ == "__main__":
    main()
