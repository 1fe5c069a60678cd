"""Autofocus of simulated flights of one drone over forest, by the bands of its camera, with spots and without.

Run with ``python tests/benchmarks/bench_focus_flights.py [SEED ...]``; a flight takes about a minute of processor.
"""

from __future__ import annotations

import math
import sys
import time
from unittest.mock import patch

import numpy as np
from rich.console import Console
from rich.table import Table

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.focus import autofocus
from aos_gcs.imaging.focus.autofocus import FocusResult, find_focus
from aos_gcs.imaging.focus.region import GroundRegion
from aos_gcs.imaging.model import Frame
from aos_sim.errors.cameras import ErringCameras, four_bands
from aos_sim.errors.hover import Hover
from aos_sim.errors.model import error_model
from aos_sim.render.renderer import LitForest, Renderer
from aos_sim.world.person import Posture
from aos_sim.world.scene import SceneParameters, build_scene

WORLDS = {
    31: (300, 1, "rtk"),
    32: (300, 0, "rtk"),
    33: (500, 1, "rtk"),
    34: (500, 0, "rtk"),
    35: (300, 2, "rtk"),
    36: (500, 2, "rtk"),
    37: (300, 1, "rtk"),
    38: (500, 1, "rtk"),
    39: (300, 0, "rtk"),
    40: (500, 0, "rtk"),
    51: (300, 1, "rtk"),
    52: (500, 2, "rtk"),
    53: (400, 0, "rtk"),
    54: (600, 1, "rtk"),
    55: (200, 1, "rtk"),
    56: (400, 2, "none"),
}
"""Trees per hectare, lying persons and grade of errors, by seed."""

CAMERA = CameraModel.from_fov(512, 512, math.radians(50.0))
BANDS = ("red", "green", "blue", "thermal")
CAMERAS = {"all four": slice(0, 4), "thermal": slice(3, 4), "red, green, blue": slice(0, 3)}
FRAMES, ALTITUDE_M, HALF_WIDTH_M, LOW_M, HIGH_M = 30, 35.0, 15.0, -5.0, 20.0


def flight(seed: int) -> list[Frame]:
    """Frames at the poses that the drone reports, a metre apart on a line that waves a little."""
    trees_per_ha, persons, grade = WORLDS[seed]
    scene = build_scene(
        SceneParameters(
            seed=seed,
            side_m=90,
            trees_per_ha=float(trees_per_ha),
            persons=persons,
            posture=Posture.LYING,
            stones=4,
            stumps=4,
            animals=1,
        )
    )
    errors, rng = error_model(grade), np.random.default_rng(seed)
    renderer = Renderer(scene, LitForest(scene), errors.wind)
    centre_m = np.array(scene.persons[0].position_enu_m[:2] if persons else (0.0, 0.0)) + rng.uniform(-5.0, 5.0, 2)
    hover, cameras = Hover(errors, 1, seed), ErringCameras(errors, CAMERA, seed)
    turn_rad = rng.uniform(0.0, 2.0 * math.pi)
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    frames = []
    for index in range(FRAMES):
        t = index - (FRAMES - 1) / 2
        place_m = np.array([[cos, -sin], [sin, cos]]) @ [t, 2.0 * math.sin(t / 6.0)] + centre_m
        motion = hover.motion(0, np.array([*place_m, ALTITUDE_M]), 0.0, rng)
        exposed = cameras.expose(
            lambda pose, camera, at_s: renderer.view(pose, camera, at_s, 4),
            motion,
            rng,
            camera_id=0,
            index=index,
            at_s=100.0 + index,
        )
        image = four_bands(exposed).astype(np.float32)
        frames.append(Frame(index, image, BANDS, hover.reported(0, motion), CAMERA))
    return frames


def said(result: FocusResult) -> str:
    return f"{result.height_m:+.2f} ± {result.sigma_m:.2f}" if result.found else "not found"


def main(seeds: list[int]) -> None:
    console = Console()
    table = Table("seed", "trees/ha", "persons", "bands", "texture alone: error m", "with spots: error m", "CPU s")
    for seed in seeds:
        frames = flight(seed)
        x_m, y_m, _ = np.mean([frame.pose.position_enu_m for frame in frames], axis=0)
        region = GroundRegion(x_m - HALF_WIDTH_M, y_m - HALF_WIDTH_M, x_m + HALF_WIDTH_M, y_m + HALF_WIDTH_M)
        for name, bands in CAMERAS.items():
            seen = [Frame(f.vehicle_id, f.image[..., bands], f.bands[bands], f.pose, f.camera) for f in frames]
            with patch.object(autofocus, "find_spots", lambda *_: []):
                alone = find_focus(seen, region, LOW_M, HIGH_M)
            started_s = time.process_time()
            result = find_focus(seen, region, LOW_M, HIGH_M)
            took_s = time.process_time() - started_s
            trees_per_ha, persons, _ = WORLDS[seed]
            table.add_row(str(seed), str(trees_per_ha), str(persons), name, said(alone), said(result), f"{took_s:.1f}")
    console.print("The ground is z = 0; errors are heights:")
    console.print(table)


if __name__ == "__main__":
    main([int(seed) for seed in sys.argv[1:]] or list(WORLDS))
