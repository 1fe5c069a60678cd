"""Searches that outlast the batteries: six vehicles and two that take turns with them, against endless batteries.

    python -m tests.benchmarks.bench_relay --missions 20

Whole missions in virtual time over level ground, with errors of RTK and small images without anything to see; some are
flown again with endless batteries. The monitor looks three times per second instead of ten times, which makes nothing
easier for it. Written are the figures of each and
of all together: the longest time below five vehicles in the line, the share of the area that was in a frame, the lowest
charge in the air, and the smallest true distance of two vehicles.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.fleet import monitor
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings, MissionSettings, PreflightSettings, RelaySettings
from aos_gcs.runtime.simulated import virtual_mission
from aos_gcs.runtime.simulated.virtual_mission import StepTrace
from aos_sim.errors.model import error_model
from aos_sim.flights.world import SimulatedFlight
from aos_sim.vehicle.battery import Battery, capacity_mah
from aos_sim.world.scene import SceneParameters, build_scene

VEHICLES, SPARES = 6, 2
FLIGHT_S = 600.0
"""Time in flight that a full battery lasts."""
SWAP_S = 20.0
RATE_HZ = 0.5
SEARCH_MPS = 2.0
IMAGE_PX = 24
_SEARCHING = frozenset({Phase.LINE, Phase.SCAN, Phase.CONVERGE, Phase.FOUND})


class BlankFlight(SimulatedFlight):
    """A flight above ground without anything to see."""

    def _view(self, pose: Pose, camera: CameraModel, at_s: float) -> NDArray[np.float32]:  # noqa: ARG002
        image = np.full((camera.height_px, camera.width_px, 4), 80.0, dtype=np.float32)
        image[..., 3] = 12.0
        return image


@dataclass
class Watch(StepTrace):
    """Recorder of what the figures need."""

    below_s: float = 0.0
    """Time in a row below five vehicles in the line."""
    longest_below_s: float = 0.0
    lowest_battery: float = math.inf
    """Lowest charge of a vehicle in the air."""
    least_line: int = 99
    takes_off: int = 0
    notices: list[str] = field(default_factory=list)
    _last_s: float | None = None
    _airborne: set[int] = field(default_factory=set)

    async def record_event(self, event: Event) -> None:
        """Take the figures from a snapshot."""
        data = event.data
        if not isinstance(data, MissionSnapshot):
            if hasattr(data, "text"):
                self.notices.append(f"{data.elapsed_s:7.1f} {data.vehicle_id or '':>2} {data.text}")
            return
        airborne = {
            one.telemetry.vehicle_id for one in data.vehicles if (one.telemetry.height_above_home_m or 0.0) > 1.0
        }
        self.takes_off += len(airborne - self._airborne)
        self._airborne = airborne
        for one in data.vehicles:
            if one.telemetry.vehicle_id in airborne:
                self.lowest_battery = min(self.lowest_battery, one.telemetry.battery_fraction or 0.0)
        step_s = 0.0 if self._last_s is None else data.elapsed_s - self._last_s
        self._last_s = data.elapsed_s
        if data.phase in _SEARCHING:
            line = sum(one.task is Task.SWARM for one in data.vehicles)
            self.least_line = min(self.least_line, line)
            self.below_s = self.below_s + step_s if line < VEHICLES - 1 else 0.0
            self.longest_below_s = max(self.longest_below_s, self.below_s)
        else:
            self.below_s = 0.0


@dataclass(frozen=True)
class Figures:
    """Figures of one search."""

    search_s: float
    lives: float
    """Search time over that which one full battery lasts down to its reserve."""
    covered: float
    left_out: bool
    takes_off: int
    least_line: int
    longest_below_s: float
    lowest_battery: float
    min_separation_m: float
    landed: int
    wall_s: float


def settings_of(
    flight: SimulatedFlight, seed: int, side_m: tuple[float, float], *, is_relayed: bool
) -> MissionSettings:
    """Return the settings of a search of a rectangle north of the launch site."""
    east_m, north_m = side_m
    west_m = -0.5 * east_m
    return MissionSettings(
        vehicles=VEHICLES,
        any_vehicles=True,
        area_enu_m=((west_m, 10.0), (-west_m, 10.0), (-west_m, 10.0 + north_m), (west_m, 10.0 + north_m)),
        imaging=replace(ImagingSettings(), rate_hz=RATE_HZ),
        origin=flight.origin,
        seed=seed,
        flight=replace(FlightSettings(), lowest_layer_m=15.0, layer_spacing_m=2.5, search_speed_mps=SEARCH_MPS),
        relay=RelaySettings(enabled=is_relayed, swap_s=SWAP_S),
        deadlines=replace(Deadlines(), search_s=7200.0),
        preflight=PreflightSettings(upload_fence=True, set_return_height=True),
        auto_start=True,
        auto_return=True,
    )


def fly(seed: int, *, is_relayed: bool) -> tuple[Figures, list[str]]:
    """Fly one search and return its figures and notices."""
    rng = np.random.default_rng(seed)
    side_m = (float(rng.uniform(280.0, 320.0)), float(rng.uniform(280.0, 320.0)))
    scene = build_scene(SceneParameters(seed=seed, trees_per_ha=0.0, side_m=20.0, persons=0))
    battery = Battery(capacity_mah(FLIGHT_S), swap_s=SWAP_S) if is_relayed else Battery(1e9)
    count = VEHICLES + (SPARES if is_relayed else 0)
    flight = BlankFlight(scene, error_model("rtk"), count, IMAGE_PX, seed, battery=battery)
    begin_s = time.perf_counter()
    settings = settings_of(flight, seed, side_m, is_relayed=is_relayed)
    watch = Watch()
    snapshot = virtual_mission.fly(flight, settings, watch).snapshot
    figures = Figures(
        search_s=snapshot.elapsed_s,
        lives=snapshot.elapsed_s / (FLIGHT_S * (1.0 - UNLIMITED.min_battery_fraction)),
        covered=snapshot.covered_fraction or 0.0,
        left_out=not any("the whole area was scanned" in text for text in watch.notices),
        takes_off=watch.takes_off,
        least_line=watch.least_line,
        longest_below_s=watch.longest_below_s,
        lowest_battery=watch.lowest_battery,
        min_separation_m=flight.min_separation_m or math.inf,
        landed=flight.landed,
        wall_s=time.perf_counter() - begin_s,
    )
    return figures, watch.notices


def main() -> None:
    """Fly the searches and write their figures."""
    monitor._PERIOD_S = 0.3
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--missions", type=int, default=20)
    parser.add_argument("--seed", type=int, default=70_000)
    parser.add_argument("--endless", type=int, default=0, help="Fly so many of them with endless batteries, too.")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--notices", action="store_true", help="Print the notices of each relayed search.")
    options = parser.parse_args()
    rows = []
    for seed in range(options.seed, options.seed + options.missions):
        relayed, notices = fly(seed, is_relayed=True)
        row = {"seed": seed, "relayed": asdict(relayed)}
        if seed < options.seed + options.endless:
            row["endless"] = asdict(fly(seed, is_relayed=False)[0])
        rows.append(row)
        print(json.dumps(rows[-1]), flush=True)
        if options.notices:
            print("\n".join(notices), flush=True)
        if options.out is not None:
            options.out.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    reports = [row["relayed"] for row in rows]
    print(f"{len(rows)} searches of {min(one['lives'] for one in reports):.1f} lives and more:")
    print(f"  longest below {VEHICLES - 1} vehicles: {max(one['longest_below_s'] for one in reports):.0f} s")
    print(f"  share of the area that was in a frame: {min(one['covered'] for one in reports):.1%} at least")
    if paired := [row for row in rows if "endless" in row]:
        shares = [row["relayed"]["covered"] / row["endless"]["covered"] for row in paired]
        times = [row["relayed"]["search_s"] / row["endless"]["search_s"] for row in paired]
        print(f"  over that of endless batteries: {min(shares):.1%} at least (n = {len(paired)})")
        print(
            f"  time over that with endless batteries: {np.median(times):.2f} in the median, {max(times):.2f} at most"
        )
    print(f"  lowest charge in the air: {min(one['lowest_battery'] for one in reports):.1%}")
    print(f"  smallest separation: {min(one['min_separation_m'] for one in reports):.2f} m")


if __name__ == "__main__":
    main()
