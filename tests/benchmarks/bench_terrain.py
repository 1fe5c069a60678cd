"""Times of vetting above ground on a large elevation model: ``python tests/benchmarks/bench_terrain.py``."""

import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyproj
import rasterio  # type: ignore[import-untyped]
from rasterio.transform import Affine  # type: ignore[import-untyped]

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.airspace.limits import UNLIMITED, GroundLimits
from aos_gcs.airspace.traffic import WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.planning.terrain.ground import EnuBounds, ground_within
from tests.benchmarks.bench_swarm import median_ms
from tests.benchmarks.figures import report
from tests.fakes.relief import CRS, ORIGIN, terrain

REACH_M = 5_000.0
VEHICLES = 100
LENGTH_M = 100.0
LIMITS = replace(
    UNLIMITED, above_ground=GroundLimits(floor_m=20.0, ceiling_m=500.0, offsets_m=(0.0, 0.0)), separation_m=2.0
)


def write_hills(path: Path) -> Path:
    """Write a model of 10 x 10 km with cells of 1 m."""
    to_crs = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32633", always_xy=True)
    x, y = to_crs.transform(ORIGIN.longitude_deg, ORIGIN.latitude_deg)
    steps = np.arange(int(2 * REACH_M), dtype=np.float32)
    transform = Affine(1.0, 0.0, x - REACH_M, 0.0, -1.0, y + REACH_M)
    profile = {
        "driver": "GTiff",
        "height": len(steps),
        "width": len(steps),
        "count": 1,
        "dtype": "float32",
        "tiled": True,
    }
    with rasterio.open(path, "w", crs=CRS, transform=transform, **profile) as dataset:
        dataset.write(np.float32(600.0) + np.outer(np.float32(25.0) * np.sin(steps / 90), np.cos(steps / 70)), 1)
    return path


def requests() -> list[WaypointRequest]:
    """Return waypoints at random places, a leg's length away each."""
    rng = np.random.default_rng(1)
    starts_m = np.column_stack([rng.uniform(-4_500.0, 4_500.0, (VEHICLES, 2)), np.full(VEHICLES, 80.0)])
    turns_rad = rng.uniform(0.0, 2.0 * np.pi, VEHICLES)
    ends_m = starts_m + LENGTH_M * np.column_stack([np.cos(turns_rad), np.sin(turns_rad), np.zeros(VEHICLES)])
    return [
        WaypointRequest(
            vehicle_id=number + 1,
            position_enu_m=start_m,
            requested_enu_m=end_m,
            link_age_s=0.0,
            position_age_s=0.0,
            battery_fraction=None,
        )
        for number, (start_m, end_m) in enumerate(zip(starts_m, ends_m, strict=True))
    ]


def main() -> None:
    """Print and keep the figures of a model of 10 x 10 km with cells of 1 m."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_hills(Path(folder) / "hills.tif")
        began_s = time.perf_counter()
        inner = REACH_M - 100.0
        ground = ground_within(terrain(path), ORIGIN, EnuBounds(-inner, -inner, inner, inner))
        loading_s = time.perf_counter() - began_s
    movers = requests()
    level_ms = median_ms(lambda: vet_waypoints(movers, [], replace(LIMITS, above_ground=None)))
    ground_ms = median_ms(lambda: vet_waypoints(movers, [], LIMITS, ground))
    sys.stdout.write(
        f"load 10 x 10 km, 1 m   {loading_s:8.2f} s, {np.prod(ground.shape):,} cells\n"
        f"vet {VEHICLES} waypoints of {LENGTH_M:g} m   {level_ms:8.2f} ms on level ground, {ground_ms:8.2f} ms above "
        "relief\n"
    )
    report("terrain.vetting", ground_ms - level_ms)


if __name__ == "__main__":
    main()
