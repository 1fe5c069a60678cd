"""Ten vehicles with simulated autopilots over hills of 60 m, in virtual time: python -m tests.campaign.relief --help.

Service and driver are the real ones, the autopilots are simulated and speak MAVLink; cameras see bare ground, and the
whole area is searched. Each flight is judged by the true heights above the ground and the true distances.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, PreflightSettings
from aos_gcs.runtime.simulated.demo_terrain import FLOOR_ABOVE_GROUND_M, above_ground
from aos_gcs.runtime.simulated.virtual_time import run
from aos_sim.swarm import SwarmOptions
from aos_sim.world.relief import Relief
from aos_sim.world.terrain import make_relief
from aos_sim.world.terrain_file import write_geotiff
from tests.fakes.air import Air
from tests.fakes.air_flight import flying_over
from tests.fakes.mission_flight import settings

RELIEF_M = 60.0
"""Least difference between the lowest and the highest ground of the search area."""
AREA_ENU_M = ((-75.0, 15.0), (75.0, 15.0), (75.0, 165.0), (-75.0, 165.0))
_BEYOND_M = 120.0
_AUTOPILOTS = ("arducopter", "px4")
_IMAGE_SIZE_PX = 32
_OVERRIDES = {"climb of the return": "simulated vehicles", "geofence": "nothing flies near it"}


class BareGround:
    """Ground on which nothing stands out."""

    def view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:  # noqa: ARG002
        """Return one colour and one temperature."""
        image = np.empty((camera.height_px, camera.width_px, 4), dtype=np.float32)
        image[:] = 70.0, 90.0, 50.0, 12.0
        return image


@dataclass(frozen=True, slots=True)
class ReliefVerdict:
    """What a flight over hills has come to, by the truth."""

    autopilot: str
    seed: int
    follow: bool
    outcome: str
    relief_m: float
    height_m: float | None
    """Smallest height of a vehicle above the ground, away from its launch point."""
    separation_m: float | None
    landed: int
    duration_s: float
    processor_s: float
    message: str
    """What the mission says last."""

    @property
    def is_refused(self) -> bool:
        """Whether preflight has not let it take off, which is no problem: it is said why."""
        return self.outcome == Outcome.FAILED and self.height_m is None

    def problems(self, vehicles: int) -> Iterator[str]:
        """Yield what must not be."""
        if self.outcome != Outcome.NOT_FOUND:
            yield f"the outcome is {self.outcome}"
        if self.relief_m < RELIEF_M:
            yield f"only {self.relief_m:.1f} m of relief"
        if self.height_m is None or self.height_m < FLOOR_ABOVE_GROUND_M - 1.0:
            yield f"a vehicle came to {self.height_m} m above the ground (floor: {FLOOR_ABOVE_GROUND_M:g} m)"
        if self.separation_m is None or self.separation_m < UNLIMITED.separation_m:
            yield f"two vehicles came within {self.separation_m} m (limit: {UNLIMITED.separation_m:g} m)"
        if self.landed != vehicles:
            yield f"{self.landed} of {vehicles} landed"


def hills(seed: int) -> tuple[Relief, float]:
    """Return the simulator's hills of a seed, as much higher as the search area needs; and its relief."""
    corners_m = np.array(AREA_ENU_M)
    box_m = (*(corners_m.min(axis=0) - _BEYOND_M), *(corners_m.max(axis=0) + _BEYOND_M))
    relief = make_relief("hills", seed, tuple(map(float, box_m)), level_north_m=0.0, origin=None)  # type: ignore[arg-type]
    assert relief is not None
    (west_m, south_m), (east_m, north_m) = corners_m.min(axis=0), corners_m.max(axis=0)
    east, north = np.meshgrid(np.arange(west_m, east_m + 1.0, 2.0), np.arange(south_m, north_m + 1.0, 2.0))
    own_m = float(np.ptp(relief.height_m(east, north)))
    factor = max(1.0, (RELIEF_M + 0.5) / own_m)
    return replace(relief, heights_m=relief.heights_m * factor), own_m * factor


def fly_over_hills(seed: int, autopilot: str, *, follow: bool, vehicles: int = 10) -> ReliefVerdict:
    """Fly a search of the whole area in virtual time."""
    return run(_fly(seed, autopilot, follow=follow, vehicles=vehicles))


async def _fly(seed: int, autopilot: str, *, follow: bool, vehicles: int) -> ReliefVerdict:
    begin_s = time.process_time()
    relief, relief_m = hills(seed)
    origin = SwarmOptions(links=("udpout://127.0.0.1:1",)).origin
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        file = Path(folder) / "ground.tif"
        write_geotiff(file, relief, origin)
        planned = above_ground(settings(vehicles, area_enu_m=AREA_ENU_M, origin=origin), file, follow=follow)
        async with flying_over(
            patch,
            Air(seed=seed),
            vehicles=vehicles,
            autopilot=autopilot,
            relief=relief,
            scene=BareGround(),
            image_size_px=_IMAGE_SIZE_PX,
            area_enu_m=AREA_ENU_M,
            terrain=planned.terrain,
            flight=planned.flight,
            search=SearchSettings(SearchMode.CONTINUOUS),
            deadlines=Deadlines(preflight_s=120.0, capture_s=8.0),
            preflight=PreflightSettings(upload_fence=True, set_return_height=True, overrides=_OVERRIDES),
        ) as flight:
            outcome = await flight.run
            report = flight.swarm.report()
            return ReliefVerdict(
                autopilot=autopilot,
                seed=seed,
                follow=follow,
                outcome=str(outcome),
                relief_m=relief_m,
                height_m=report.min_height_above_ground_m,
                separation_m=report.min_separation_m,
                landed=report.landed,
                duration_s=flight.clock.now_s(),
                processor_s=time.process_time() - begin_s,
                message=flight.mission.view.snapshot().message,
            )


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly the seeds with each autopilot; return 1 if a flight has a problem, or none took off."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign.relief", description=__doc__)
    parser.add_argument("--first", type=int, default=1, help="first seed")
    parser.add_argument("--seeds", type=int, default=10, help="number of seeds")
    parser.add_argument("--vehicles", type=int, default=10)
    parser.add_argument("--autopilots", nargs="+", choices=_AUTOPILOTS, default=list(_AUTOPILOTS))
    parser.add_argument("--follow-ground", action="store_true", help="let the layers follow the ground")
    options = parser.parse_args(arguments)
    failed = flown = 0
    for seed in range(options.first, options.first + options.seeds):
        for autopilot in options.autopilots:
            found = fly_over_hills(seed, autopilot, follow=options.follow_ground, vehicles=options.vehicles)
            problems = [] if found.is_refused else list(found.problems(options.vehicles))
            flown += not found.is_refused
            failed += bool(problems)
            print(found, *problems, sep="\n  ", flush=True)  # noqa: T201
    print(f"{flown} flown, {failed} with problems")  # noqa: T201
    return 1 if failed or not flown else 0


if __name__ == "__main__":
    sys.exit(main())
