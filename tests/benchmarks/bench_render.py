"""Measure the renderer: ``python tests/benchmarks/bench_render.py``."""

from __future__ import annotations

import math
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_sim.errors.sensor import RenderedFrame
from aos_sim.render import Renderer
from aos_sim.world.scene import Scene, SceneParameters, build_scene

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.benchmarks.figures import median_durations, report
from tests.fakes.visibility import person_visibility

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
VISIBILITY_SEEDS = 20
VIEWS_PER_SEED = 40


def main() -> None:
    """Print medians of the times, and the mean visibility of a person."""
    parameters = SceneParameters()
    scene = build_scene(parameters)
    renderer = Renderer(scene)
    rng = np.random.default_rng(0)
    poses = views_of_person(scene, 10, rng)
    print(f"world of {len(scene.forest.trunk_enu_m)} trees, {len(scene.forest.mesh):,} triangles")
    print(f"build scene                 {median_durations(3, lambda: build_scene(parameters))}")
    print(f"build renderer              {median_durations(3, lambda: Renderer(scene))}")
    print(f"one frame 512 x 512         {median_durations(10, lambda: renderer.render(poses[0], CAMERA, rng))}")
    print(f"the same, backdrop thinned  {median_durations(10, lambda: renderer.render(poses[0], CAMERA, rng, 2))}")
    with ThreadPoolExecutor(2) as pool:

        def render_all() -> list[RenderedFrame]:
            return list(pool.map(lambda pose, own: renderer.render(pose, CAMERA, own), poses, rng.spawn(len(poses))))

        ten_frames = median_durations(5, render_all)
    print(f"ten frames, two threads     {ten_frames}")
    report("render.ten_frames", ten_frames.wall_s)
    print(f"masks of a person           {median_durations(10, lambda: renderer.person_masks(poses[0], CAMERA))}")
    by_seed = single_view_visibilities().mean(axis=1)
    standard_error = by_seed.std(ddof=1) / math.sqrt(len(by_seed))
    print(f"mean single-view visibility {by_seed.mean():.3f} +- {standard_error:.3f} over {len(by_seed)} worlds")


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
        shares.append([person_visibility(renderer, view, CAMERA) or 0.0 for view in views])
    return np.array(shares)


if __name__ == "__main__":
    main()
