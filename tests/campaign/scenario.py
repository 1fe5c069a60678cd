"""A mission with its faults, drawn from a seed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.airspace.limits import UNLIMITED, SafetyOverrides
from aos_gcs.airspace.polygon import Polygon
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.search_settings import FEWEST_SCANNING, SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, DetectionSettings, FlightSettings, MissionSettings, PreflightSettings
from aos_sim.errors.model import GRADES, NONE
from aos_sim.swarm import DEFAULT_ORIGIN, SwarmOptions
from tests.campaign.faults import FAULTS, KNOWN_DEFECTS
from tests.campaign.faults.base import Basis, Fault
from tests.fakes.air import GCS

MAX_FAULTS = 5
STEP_TICKS = 5
IMAGE_SIZE_PX = 32
RX_QUANTILE = 0.985
"""The warm spot takes more than a hundredth of such small images."""
LOWEST_LAYER_M = 10.0
AREA_ENU_M = ((-8.0, 8.0), (8.0, 8.0), (8.0, 22.0), (-8.0, 22.0))
"""A short area, without anything to see."""
LONG_AREA_ENU_M = ((-8.0, 8.0), (8.0, 8.0), (8.0, 70.0), (-8.0, 70.0))
"""An area whose leg takes 12 s at the speed of a sweep, with the warm spot of the tests' ground in its middle."""
SEARCH_S, LONG_SEARCH_S = 20.0, 45.0
"""Time from the launch after which all return, by area."""
SPACING_M = {"none": (2.5, 3.0), "rtk": (2.5, 3.0), "gnss": (10.0, 12.0)}
"""Range of the layers' spacing, by the kind of errors."""
LAUNCH_SPACING_M = {"none": 5.0, "rtk": 5.0, "gnss": 15.0}
"""Distance of two launch points, by the kind of errors; preflight refuses less."""
SPLIT_SHARE = 0.12
"""Share of the missions that fly split: without stops, over the long area, for all persons."""
LOOKING = 2
"""Vehicles that look closely in those; at least three scan on."""
QUICK = {
    "arducopter": {"LAND_SPEED": 150.0, "RTL_LOIT_TIME": 500.0, "WPNAV_SPEED_DN": 250.0, "FS_GCS_TIMEOUT": 5.0},
    "px4": {"MPC_LAND_SPEED": 1.5, "MPC_Z_VEL_MAX_DN": 2.5, "COM_DISARM_LAND": 0.5},
}
"""Parameters that shorten a mission."""


@dataclass(frozen=True)
class Scenario:
    """One mission of the campaign."""

    seed: int
    autopilot: str
    vehicles: int
    errors: str
    spacing_m: float
    upload_fence: bool
    faults: tuple[Fault, ...]
    mode: SearchMode = SearchMode.STOPS
    is_long: bool = False
    """Whether the area is the long one."""
    stops_at_first: bool = True
    """Whether the search ends at the first possible person."""
    zones_enu_m: tuple[Polygon, ...] = ()
    """No-go zones."""
    splits: bool = False
    """Whether some vehicles look closely while the others scan on."""

    def without(self, fault: Fault) -> Scenario:
        """Return the scenario without one of its faults."""
        return replace(self, faults=tuple(other for other in self.faults if other is not fault))

    def describe(self) -> str:
        """Return it in a few lines."""
        fence = ", fence uploaded" if self.upload_fence else ""
        area = "long" if self.is_long else "short"
        goal = "" if self.stops_at_first else " for all persons"
        goal += ", split" if self.splits else ""
        zones = "".join(f", no-go zone {zone}" for zone in self.zones_enu_m)
        swarm = f"{self.vehicles} {self.autopilot}, {self.errors} positions, {self.mode} search{goal}, {area} area"
        head = f"SEED={self.seed}: {swarm}, layers {self.spacing_m:.1f} m apart{fence}{zones}"
        return "\n".join([head, *(f"  {fault.describe()}" for fault in self.faults)])

    def swarm_options(self) -> SwarmOptions:
        """Return the simulated swarm."""
        return SwarmOptions(
            vehicles=self.vehicles,
            links=(f"udpout://{GCS[0]}:{GCS[1]}",),
            seed=self.seed,
            autopilot=self.autopilot,
            image_size_px=IMAGE_SIZE_PX,
            start_up_s=1.0,
            parameters=QUICK[self.autopilot],
            errors=replace(NONE, position=GRADES[self.errors].position),
            step_ticks=STEP_TICKS,
            launch_spacing_m=LAUNCH_SPACING_M[self.errors],
        )

    def settings(self) -> MissionSettings:
        """Return the mission."""
        overrides = {} if self.upload_fence else {"geofence": "drawn by the campaign"}
        return MissionSettings(
            vehicles=self.vehicles,
            area_enu_m=LONG_AREA_ENU_M if self.is_long else AREA_ENU_M,
            imaging=ImagingSettings(rx_quantile=RX_QUANTILE),
            vehicle_ids=tuple(range(1, self.vehicles + 1)),
            origin=DEFAULT_ORIGIN,
            seed=self.seed,
            search=SearchSettings(self.mode, split=self.splits, look_vehicles=LOOKING),
            safety=SafetyOverrides(no_go_enu_m=self.zones_enu_m or None),
            flight=FlightSettings(lowest_layer_m=LOWEST_LAYER_M, layer_spacing_m=self.spacing_m),
            deadlines=Deadlines(
                preflight_s=40.0,
                takeoff_s=40.0,
                move_s=10.0,
                transfer_s=40.0,
                capture_s=4.0,
                search_s=LONG_SEARCH_S if self.is_long else SEARCH_S,
                land_s=60.0,
            ),
            detection=DetectionSettings(found_steps=3, hold_steps=1, stop_at_first=self.stops_at_first),
            preflight=PreflightSettings(upload_fence=self.upload_fence, set_return_height=True, overrides=overrides),
            auto_start=True,
            auto_return=True,
        )


def draw(seed: int) -> Scenario:
    """Draw a scenario; the same for the same seed."""
    rng = np.random.default_rng([seed, 0xA05])
    autopilot = str(rng.choice(["arducopter", "px4"]))
    vehicles = int(rng.choice([1, 2, 3, 4], p=[0.1, 0.25, 0.45, 0.2]))
    splitting = np.random.default_rng([seed, 0x5B1])
    if splits := bool(splitting.random() < SPLIT_SHARE):
        # With one more than are needed, those who scan on are close enough together at the height of these flights.
        vehicles = LOOKING + FEWEST_SCANNING + 1
    errors = str(rng.choice(["none", "rtk", "gnss"], p=[0.3, 0.5, 0.2]))
    spacing_m = round(float(rng.uniform(*SPACING_M[errors])), 1)
    basis = Basis(autopilot, tuple(range(1, vehicles + 1)), spacing_m - UNLIMITED.separation_m)
    upload_fence = bool(rng.random() < 0.3)
    kinds = [kind for kind in FAULTS if kind not in KNOWN_DEFECTS]
    weights = np.array([kind.WEIGHT for kind in kinds])
    drawn = rng.choice(len(kinds), size=int(rng.integers(1, MAX_FAULTS + 1)), p=weights / weights.sum())
    faults = sorted((kinds[int(row)].draw(rng, basis) for row in drawn), key=lambda fault: fault.at_s)
    mode = SearchMode(str(rng.choice(list(SearchMode))))
    is_long, stops_at_first = bool(rng.random() < 0.4), bool(rng.random() < 0.5)
    if splits:
        mode, is_long, stops_at_first = SearchMode.CONTINUOUS, True, False
    zones = draw_zones(np.random.default_rng([seed, 0x20E]), LONG_AREA_ENU_M if is_long else AREA_ENU_M)
    return Scenario(
        seed,
        autopilot,
        vehicles,
        errors,
        spacing_m,
        upload_fence,
        tuple(faults),
        mode,
        is_long,
        stops_at_first,
        zones,
        splits,
    )


def draw_zones(rng: np.random.Generator, area_enu_m: Polygon) -> tuple[Polygon, ...]:
    """Draw no-go zones: none in three missions of five, else a rectangle in or beside the search area."""
    if rng.random() < 0.6:
        return ()
    (west_m, south_m), (east_m, north_m) = area_enu_m[0], area_enu_m[2]
    width_m, length_m = rng.uniform(2.0, 12.0), rng.uniform(2.0, 6.0)
    begin_m = round(float(rng.uniform(west_m - 4.0, east_m - 2.0)), 1)
    first_m = round(float(rng.uniform(south_m + 2.0, north_m)), 1)
    end_m, last_m = round(begin_m + width_m, 1), round(first_m + length_m, 1)
    return (((begin_m, first_m), (end_m, first_m), (end_m, last_m), (begin_m, last_m)),)
