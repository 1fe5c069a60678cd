"""Predicted views over relief: those of rays to the ground where it is, not to a plane at the height of the origin."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.groundmap.directions import ViewDirections
from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.groundmap.ground_map import open_map
from aos_gcs.imaging.model import Frame, SurfaceKind
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.planning.detection.expected_views import LineOfCameras, expected_views, predicted_detection
from aos_gcs.planning.detection.pod_proposal import propose_pattern
from aos_gcs.planning.estimate import PlanEstimate, estimate_plan
from aos_gcs.planning.gaps import find_gap_legs
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.settings import ForestSettings, MissionSettings
from aos_gcs.planning.terrain.relief_estimate import estimate_over_ground
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround, viewed_ground
from tests.fakes.relief import ORIGIN, Relief, level, terrain, write_relief

SQUARE = ((-60.0, 0.0), (60.0, 0.0), (60.0, 120.0), (-60.0, 120.0))
FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=4.4, occlusion=0.84)
PLAN = MissionPlan(
    vehicles=3,
    area_enu_m=SQUARE,
    layer_spacing_m=3.0,
    lowest_layer_m=60.0,
    forest=FOREST,
    pod=0.9,
    line_spacing_m=20.0,
    leg_spacing_m=60.0,
    search_speed_mps=10.0,
)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=SQUARE, imaging=ImagingSettings(), origin=ORIGIN)
SLOPE = 0.2


def rising(slope: float, at_origin_m: float = 0.0) -> ReferenceSurface:
    """Heights that rise northwards."""
    north_m = np.arange(-100.0, 301.0, 100.0)
    return ReferenceSurface(-200.0, -100.0, 100.0, np.tile(at_origin_m + slope * north_m[:, None], (1, 5)))


@pytest.mark.parametrize("layers", [LEVEL, rising(0.1)], ids=["level layers", "layers that follow"])
def test_views_over_a_slope_are_those_of_rays_to_it(tmp_path: Path, layers: ReferenceSurface) -> None:
    """The map of searched ground traces the rays; over level ground far more views would be expected."""
    directions = ViewDirections(0.06)
    line = LineOfCameras(np.array([-4.0, 5.0]), np.array([30.0, 33.0]), math.tan(math.radians(15.0)), 3.0)
    leg = ScanLeg((3.0, 60.0), (0.0, 1.0), 12.0)
    ground = ViewedGround(rising(SLOPE), layers)
    searched = open_map(tmp_path, GeodeticPosition(48.0, 14.0, AmslM(0.0)), directions.step)
    camera = CameraModel.from_fov(64, 64, math.radians(30.0))
    image = np.zeros((64, 64, 1), np.float32)
    slope = Terrain(-40.0, 30.0, 1.0, np.tile(SLOPE * (30.0 + np.arange(80.0))[:, None], (1, 80)))
    for aside_m, height_m in zip(line.aside_m, line.heights_m, strict=True):
        for along_m in np.arange(0.0, 12.1, 3.0):
            place = (3.0 - aside_m, 60.0 + along_m)
            pose = nadir_pose((*place, height_m + layers.at(np.array(place))))
            searched.add(Frame(1, image, ("thermal",), pose, camera), slope)
    rows, columns = np.mgrid[-84:-48:2, -16:18:2]
    places_m = np.column_stack((columns.ravel() + 0.5, -rows.ravel() - 0.5))
    counted = np.array(
        [
            int(searched.views[index][row % 32, column % 32])
            if (index := (row // 32, column // 32)) in searched.views
            else 0
            for row, column in zip(rows.ravel(), columns.ravel(), strict=True)
        ]
    )
    expected = expected_views(places_m, [leg], line, directions, ground=ground)
    assert np.count_nonzero(expected) > 60
    assert np.mean(expected == counted) > 0.8
    assert abs(float(np.mean(expected) - np.mean(counted))) < 0.15
    assert float(np.mean(expected_views(places_m, [leg], line, directions))) > 1.25 * float(np.mean(counted))


def test_nothing_is_expected_where_the_ground_is_not_known() -> None:
    line, leg = LineOfCameras(np.zeros(1), np.array([35.0]), 0.4, 2.5), ScanLeg((0.0, 0.0), (0.0, 1.0), 50.0)
    hole = ViewedGround(ReferenceSurface(-100.0, 0.0, 50.0, np.array([[0.0, np.nan, np.nan], [0.0] * 3])), LEVEL)
    seen = expected_views(np.array([[-60.0, 60.0], [0.0, 25.0]]), [leg], line, ViewDirections(0.06), ground=hole)
    assert seen.tolist() == [0, 0]


def over(tmp_path: Path, relief: Relief, imaging: ImagingSettings | None = None, **values: Any) -> PlanEstimate:
    file = write_relief(tmp_path / "ground.tif", relief)
    settings = replace(SETTINGS, terrain=terrain(file, floor_above_ground_m=10.0, **values))
    return estimate_over_ground(PLAN, settings if imaging is None else replace(settings, imaging=imaging), None, {})


def standing(estimate: PlanEstimate) -> float:
    assert estimate.detection is not None
    return estimate.detection.standing


def test_a_plan_promises_less_over_high_ground_below_its_level_layers(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    as_level = standing(estimate_plan(PLAN, 0.0))
    assert standing(over(tmp_path, level(0.0))) == pytest.approx(as_level, abs=0.005)
    high = over(tmp_path, lambda _, north: 0.25 * np.maximum(north, 0.0))
    assert standing(high) < as_level - 0.05
    rises_m = high.viewed.rises_m(np.array([[0.0, 20.0], [30.0, 100.0]]))
    assert rises_m == pytest.approx([5.0, 25.0], abs=0.5)
    on_plane = over(
        tmp_path, lambda _, north: 0.25 * np.maximum(north, 0.0), ImagingSettings(surface=SurfaceKind.LEVEL)
    )
    assert standing(on_plane) == as_level
    assert on_plane.viewed.ground is LEVEL


def test_ground_that_is_not_at_hand_counts_as_level() -> None:
    assert viewed_ground(SQUARE, None, rising(0.1)) is LEVEL_GROUND


def test_proposals_reach_what_is_wanted_on_the_ground_that_there_is() -> None:
    high = ViewedGround(rising(0.0, 25.0), LEVEL)
    pattern, level_pattern = propose_pattern(PLAN, 0.0, high), propose_pattern(PLAN, 0.0)
    assert pattern is not None
    assert level_pattern is not None
    assert pattern.detection >= 0.9
    flown = pattern.applied_to(PLAN)
    on_ground = predicted_detection(flown, estimate_plan(flown, 0.0).legs, 0.0, ground=high)
    assert on_ground is not None
    assert on_ground.standing == pytest.approx(0.9, abs=0.03)
    too_few = level_pattern.applied_to(PLAN)
    promised = predicted_detection(too_few, estimate_plan(too_few, 0.0).legs, 0.0, ground=high)
    assert promised is not None
    assert promised.standing < 0.87


def test_gaps_on_high_ground_take_more_passes() -> None:
    raster = ViewRaster(-60, -120, np.full((120, 120), 4, dtype=np.uint8))
    high = ViewedGround(rising(0.0, 30.0), LEVEL)
    found = [
        find_gap_legs(raster, PLAN, 0.0, from_m=(0.0, 0.0), within_s=60.0, pod=1.0, ground=ground)
        for ground in (high, LEVEL_GROUND)
    ]
    after = [one.detection_after for one in found if one is not None]
    assert after[0] < after[1] - 0.02
