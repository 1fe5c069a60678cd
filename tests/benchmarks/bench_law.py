"""What the law of detection says of planned flights by rays, and the worth of a view that fits them best.

    python tests/benchmarks/bench_law.py --density 300 --seed 714131 --places 29 --hectares 16 --wanted 0.45,0.75,0.9
    python tests/benchmarks/bench_law.py --density 500 --seed 731042 --places 39 --postures standing,sitting,lying

The flights of ``aos-gcs lab search`` by one, three and ten vehicles for several wanted probabilities past persons in
the same place, four of whom are drawn for each posture: persons differ in how much the detector marks of them. Growing
the forest takes longer than all flights past it.
Written are, for each posture and by the vehicles, the mean prediction and the share noticed, the mean difference of
both by tenths of the prediction, and the worth r0 with which P = 1 - exp(-n r0 (1 - D)) is likeliest.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.groundmap.detection import Posture
from aos_gcs.lab.search import study
from aos_gcs.lab.search.marks import marks, persons_share
from aos_gcs.lab.search.model import Conditions, Method, occlusion_of
from aos_gcs.lab.walk import free_place
from aos_gcs.lab.worlds import Target, WorldParameters, build_world
from aos_gcs.planning.settings import DetectionSettings

VEHICLES = (1, 3, 10)
DRAWN = 4
"""Persons in each place."""
APART = 10_000_000
"""Distance of the seeds of the persons in one place."""


@dataclass(frozen=True)
class Flown:
    """What one flight has shown of a place."""

    posture: Posture
    vehicles: int
    views: int
    predicted: float
    noticed: float
    """Share of the persons drawn in this place who are noticed."""


def fly(seed: int, density: float, postures: list[Posture], hectares: float, wanted: list[float]) -> list[Flown]:
    """Fly past the place of a seed, which is that of ``aos-gcs lab search``."""
    rng = np.random.default_rng([seed, round(density), 16])
    world = build_world(WorldParameters(seed=seed, trees_per_ha=density, side_m=study._PATCH_M))
    place_m = free_place(rng, world.area_enu_m.mean(axis=0), study._PLACES_M, world.trunks_enu_m)
    heading_rad, share = float(rng.uniform(0.0, math.tau)), rng.uniform(-0.5, 0.5, 2)
    flown = []
    for posture in postures:
        target = Target((float(place_m[0]), float(place_m[1])), heading_rad, posture)
        watch = study._Watch(world, target, share * math.sqrt(hectares * 1e4), seed, renders=False)
        for pod in wanted:
            for vehicles in VEHICLES:
                flight = study.search_flight(pod, Conditions(density, vehicles, hectares), Method.PLANNED)
                if flight is not None:
                    views, predicted = watch.predicted(flight, density, posture)
                    half_view = 1.1 * study._camera().width_px / 2.0 / study._camera().fx_px
                    _, cameras_m = watch._near(flight, half_view)
                    noticed = _noticed(world, target, cameras_m, seed)
                    flown.append(Flown(posture, vehicles, views, predicted, noticed))
    return flown


def _noticed(world: study.World, target: Target, cameras_m: NDArray[np.float64], seed: int) -> float:
    """Return which share of the persons drawn in a place frames notice."""
    if not len(cameras_m):
        return 0.0
    camera, threshold_m2 = study._camera(), DetectionSettings().threshold_m2
    shown = world.view_target([nadir_pose(one) for one in cameras_m], camera, target)
    hits = []
    for own in range(seed, seed + DRAWN * APART, APART):
        marked = marks(
            shown.seen,
            (cameras_m[:, 2] / camera.fx_px) ** 2,
            shown.resolution_m,
            posture=target.posture,
            share=persons_share(own, target.posture),
            rng=np.random.default_rng([own, len(cameras_m)]),
        )
        hits.append(marked.any(axis=0).sum() * shown.resolution_m**2 >= threshold_m2)
    return float(np.mean(hits))


def report(flown: list[Flown], density: float) -> str:
    """Return the line about flights past persons of a posture."""
    predicted, noticed = np.array([(one.predicted, one.noticed) for one in flown]).T
    tenth = np.minimum((predicted * 10).astype(int), 9)
    error = sum(abs(float((predicted - noticed)[tenth == one].sum())) for one in np.unique(tenth)) / len(flown)
    seen = np.array([one.views for one in flown]) * (1.0 - occlusion_of(density))

    def loss(worth: float) -> float:
        p = np.clip(1.0 - np.exp(-worth * seen), 1e-4, 1.0 - 1e-4)
        return -float((noticed * np.log(p) + (1.0 - noticed) * np.log(1.0 - p)).sum())

    best = minimize_scalar(loss, bounds=(0.01, 10.0), method="bounded").x
    by_vehicles = ", ".join(
        f"{number}: {predicted[own].mean():.3f}, {noticed[own].mean():.3f}"
        for number in VEHICLES
        if (own := np.array([one.vehicles == number for one in flown])).any()
    )
    return (
        f"{flown[0].posture}, {len(flown)} flights: predicted {predicted.mean():.3f}, noticed {noticed.mean():.3f} "
        f"({by_vehicles}), error {error:.3f}, r0 {best:.3f}"
    )


def main() -> None:
    """Fly and print the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--density", type=float, default=300.0, help="Trees per hectare.")
    parser.add_argument("--seed", type=int, required=True, help="Seed of the first place; the others count up from it.")
    parser.add_argument("--places", type=int, default=40)
    parser.add_argument("--hectares", type=float, default=4.0)
    parser.add_argument("--wanted", default="0.3,0.6,0.9", help="Wanted probabilities, separated by commas.")
    parser.add_argument("--postures", default="standing", help="standing, sitting and lying, separated by commas.")
    options = parser.parse_args()
    postures = [Posture(name) for name in options.postures.split(",")]
    wanted = [float(pod) for pod in options.wanted.split(",")]
    flown: list[Flown] = []
    for seed in range(options.seed, options.seed + options.places):
        flown += fly(seed, options.density, postures, options.hectares, wanted)
    for posture in postures:
        if own := [one for one in flown if one.posture is posture]:
            print(report(own, options.density))


if __name__ == "__main__":
    main()
