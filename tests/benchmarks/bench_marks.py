"""What the detector marks of persons in rendered flights, beside what rays let ``aos-gcs lab search`` reckon with.

    python tests/benchmarks/bench_marks.py --flights 30 --seed 290100
    python tests/benchmarks/bench_marks.py --flights 30 --seed 294000 --postures sitting,lying

Planned flights over 4 ha at 300 and 500 trees/ha, by one, three and ten vehicles in turn; each takes about ten seconds.
Flights for persons who sit or lie, who are seen sooner, are planned for less. Persons of several postures are in the
same places.
Written are, by the pixels that frames show of the person, the share of frames that mark anything and how much of them
is marked; and how many flights notice the person, by images, by rays, and as predicted.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.groundmap.detection import Posture
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.detectability.study import BANDS, marked_cells
from aos_gcs.lab.search import study
from aos_gcs.lab.search.model import Conditions, Method
from aos_gcs.lab.search.persons import person_anywhere
from aos_gcs.lab.walk import free_place
from aos_gcs.lab.worlds import Target, WorldParameters, build_world
from aos_gcs.planning.settings import DetectionSettings

HECTARES = 4.0
DENSITIES = (300.0, 500.0)
VEHICLES = (1, 3, 10)
WANTED = {Posture.STANDING: (0.6, 0.9), Posture.SITTING: (0.35, 0.6), Posture.LYING: (0.35, 0.6)}
"""Probabilities of detection of a standing person for which flights are planned, in turn."""
EDGES_PX = (0.0, 1.0, 2.0, 4.0, 6.0, 10.0, 15.0, 25.0, 50.0, math.inf)


@dataclass(frozen=True)
class Flown:
    """What one flight shows and marks of the person."""

    trees_per_ha: float
    posture: Posture
    pixels: NDArray[np.float64]
    """Pixels that each frame shows of the person, shape (n,)."""
    marked_pixels: NDArray[np.float64]
    """Area that each frame marks, in its pixels, shape (n,)."""
    by_images: bool
    by_rays: bool
    predicted: float


def fly(seed: int, trees_per_ha: float, posture: Posture) -> Flown | None:
    """Render the planned flight past the person of a seed, as ``aos-gcs lab search`` places the person."""
    rng = np.random.default_rng([seed, round(trees_per_ha), 16])
    world = build_world(WorldParameters(seed=seed, trees_per_ha=trees_per_ha, side_m=study._PATCH_M))
    place_m = free_place(rng, world.area_enu_m.mean(axis=0), study._PLACES_M, world.trunks_enu_m)
    target = Target((float(place_m[0]), float(place_m[1])), float(rng.uniform(0.0, math.tau)), posture)
    watch = study._Watch(world, target, person_anywhere(HECTARES, rng), seed, renders=False)
    wanted, vehicles = WANTED[posture][seed // len(VEHICLES) % 2], VEHICLES[seed % len(VEHICLES)]
    flight = study.search_flight(wanted, Conditions(trees_per_ha, vehicles, HECTARES), Method.PLANNED)
    camera = study._camera()
    if flight is None:
        return None
    _, cameras_m = watch._near(flight, 1.1 * camera.width_px / 2.0 / camera.fx_px)
    if not len(cameras_m):
        return None
    poses = [nadir_pose(one) for one in cameras_m]
    shown = world.view_target(poses, camera, target)
    images = world.render(poses, camera, target, np.random.default_rng(len(poses)))
    marks = [
        marked_cells(Frame(1, image, BANDS, pose, camera), shown, view, ImagingSettings())
        for view, (image, pose) in enumerate(zip(images, poses, strict=True))
    ]
    cell_m2, pixels_m2 = shown.resolution_m**2, (cameras_m[:, 2] / camera.fx_px) ** 2
    return Flown(
        trees_per_ha,
        posture,
        shown.seen.sum(axis=(1, 2)) * cell_m2 / pixels_m2,
        np.array([len(one) for one in marks]) * cell_m2 / pixels_m2,
        by_images=len(set().union(*marks)) * cell_m2 >= DetectionSettings().threshold_m2,
        by_rays=watch.noticed_s(flight, single=False) is not None,
        predicted=watch.predicted(flight, trees_per_ha, posture)[1],
    )


def rows(flights: list[Flown], posture: Posture) -> Iterator[str]:
    """Return the lines of the report about persons of a posture."""
    flights = [one for one in flights if one.posture is posture]
    if not flights:
        return
    pixels = np.concatenate([one.pixels for one in flights])
    marked = np.concatenate([one.marked_pixels for one in flights])
    yield f"{posture}, pixels shown: frames, share that marks any, pixels marked there, over the pixels shown"
    for low, high in zip((-1.0, *EDGES_PX), EDGES_PX, strict=False):
        here = (pixels > low) & (pixels <= high)
        marks = here & (marked > 0.0)
        if marks.any():
            share = f"{marked[marks].sum() / pixels[marks].sum():.2f}" if high > 0.0 else "-"
            frames = f"{here.sum()}, {marks.sum() / here.sum():.2f}"
            yield f"{max(low, 0.0):g} to {high:g}: {frames}, {marked[marks].mean():.1f}, {share}"
    for trees_per_ha in DENSITIES:
        of = [one for one in flights if one.trees_per_ha == trees_per_ha]
        if not of:
            continue
        images, rays = (sum(getattr(one, name) for one in of) for name in ("by_images", "by_rays"))
        predicted = np.mean([one.predicted for one in of])
        noticed = f"{len(of)} flights notice {images} by images, {rays} by rays"
        yield f"{trees_per_ha:g} trees/ha: {noticed}; predicted {predicted:.2f}"


def main() -> None:
    """Render the flights and print the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--flights", type=int, default=30, help="Flights at each density.")
    parser.add_argument("--seed", type=int, default=290_100)
    parser.add_argument("--postures", default="standing", help="standing, sitting and lying, separated by commas.")
    options = parser.parse_args()
    postures = [Posture(name) for name in options.postures.split(",")]
    seeds = range(options.seed, options.seed + options.flights)
    keys = [(seed, density, posture) for seed in seeds for density in DENSITIES for posture in postures]
    flights = [flown for key in keys if (flown := fly(*key)) is not None]
    for posture in postures:
        print("\n".join(rows(flights, posture)))


if __name__ == "__main__":
    main()
