"""Priors from files: what they say of an area, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.checks import CheckStatus
from aos_gcs.mission.preflight.plan import check_prior
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.prior.file import prior_over, read_prior
from tests.fakes.fleet import ORIGIN
from tests.fakes.shapes import point, polygon, ring_deg, write_features

AREA = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=AREA, layer_spacing_m=3.0)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=AREA, imaging=ImagingSettings(), origin=ORIGIN)
Written = Callable[..., str]


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(*features: Any, **members: Any) -> str:
        return write_features(tmp_path / "prior.geojson", features, **members)

    return write


def write_grid(
    path: Path, values: np.ndarray, crs: str | None = "EPSG:32633", cell_m: float = 20.0, **profile: Any
) -> str:
    """A raster whose middle is the origin, in metres of UTM or in degrees."""
    rasterio = pytest.importorskip("rasterio")
    pyproj = pytest.importorskip("pyproj")
    x, y = pyproj.Transformer.from_crs("EPSG:4326", crs or "EPSG:32633", always_xy=True).transform(14.3, 48.3)
    step_x, step_y = (cell_m / 74_200.0, cell_m / 111_200.0) if crs == "EPSG:4326" else (cell_m, cell_m)
    rows, columns = values.shape
    transform = rasterio.Affine(step_x, 0.0, x - columns / 2 * step_x, 0.0, -step_y, y + rows / 2 * step_y)
    profile = {"count": 1, "dtype": values.dtype.name, "crs": crs, "transform": transform, **profile}
    with rasterio.open(path, "w", driver="GTiff", height=rows, width=columns, **profile) as dataset:
        dataset.write(values, 1)
    return str(path)


def test_polygons_share_their_probability_by_place_and_leave_the_rest_outside(written: Written) -> None:
    name = written(
        polygon(-100.0, -100.0, 0.0, 100.0, probability=0.6),
        polygon(50.0, -100.0, 150.0, 100.0, probability=0.2),
    )
    prior = prior_over(name, ORIGIN, AREA)
    assert prior.share == pytest.approx(0.6 + 0.1, abs=0.01)
    west, middle, east = prior.at(np.array([[-50.0, 10.0], [25.0, 10.0], [75.0, 10.0]])) / prior.cell_m**2
    assert middle == 0.0
    assert west == pytest.approx(0.6 / 2e4, rel=1e-3)
    assert east == pytest.approx(0.2 / 2e4, rel=1e-3)
    weights = prior.weights(np.array([[-50.0, 0.0], [75.0, 0.0]]))
    assert weights == pytest.approx([0.75, 0.25], abs=1e-3)


def test_weights_are_relative_and_holes_and_parts_count(written: Written) -> None:
    holed = polygon(-100.0, -100.0, 100.0, 0.0, weight=3)
    holed["geometry"]["coordinates"].append(ring_deg(-50.0, -80.0, 50.0, -20.0))
    parts = {"type": "MultiPolygon", "coordinates": [[ring_deg(-90, 10, -60, 60)], [ring_deg(60, 10, 90, 60)]]}
    name = written(holed, {"type": "Feature", "properties": {"weight": 1}, "geometry": parts})
    prior = prior_over(name, ORIGIN, AREA)
    assert prior.share == pytest.approx(1.0, abs=0.01)
    hole, body, left, right = prior.at(np.array([[0.0, -50.0], [80.0, -50.0], [-75.0, 30.0], [75.0, 30.0]]))
    assert hole == 0.0
    assert left == pytest.approx(right, rel=1e-3) == pytest.approx(0.25 / 3000.0 * prior.cell_m**2, rel=1e-3)
    assert body == pytest.approx(0.75 / 14_000.0 * prior.cell_m**2, rel=1e-3)


def test_a_last_known_point_has_its_quartiles_at_its_distances(written: Written) -> None:
    name = written(point(0.0, 0.0, category="hiker", distances_m=[20.0, 40.0, 60.0, 80.0]))
    prior = prior_over(name, ORIGIN, AREA)
    rows, columns = np.mgrid[: prior.mass.shape[0], : prior.mass.shape[1]]
    east_m = prior.west_m + (columns + 0.5) * prior.cell_m
    north_m = prior.north_m - (rows + 0.5) * prior.cell_m
    within = [float(prior.mass[np.hypot(east_m, north_m) <= radius_m].sum()) for radius_m in (20, 40, 60, 80)]
    assert within == pytest.approx([0.25, 0.5, 0.75, 0.95], abs=0.02)
    assert 0.95 < prior.share < 1.0


@pytest.mark.parametrize("crs", ["EPSG:32633", "EPSG:4326", "EPSG:3857"])
def test_a_raster_says_the_same_in_every_coordinate_system(tmp_path: Path, crs: str) -> None:
    values = np.zeros((20, 20), dtype=np.float32)
    values[:10] = 3.0  # the north
    values[10:] = 1.0
    scale = 1.5032 if crs == "EPSG:3857" else 1.0  # of Mercator's map at 48.3 degrees
    prior = prior_over(write_grid(tmp_path / "p.tif", values, crs, 20.0 * scale), ORIGIN, AREA)
    assert prior.share == pytest.approx(0.25, abs=0.01)
    north, south = prior.at(np.array([[30.0, 50.0], [30.0, -50.0]])) / prior.cell_m**2
    assert north == pytest.approx(0.75 / 8e4, rel=0.02)
    assert south == pytest.approx(0.25 / 8e4, rel=0.02)


def test_cells_without_data_count_as_nothing(tmp_path: Path) -> None:
    values = np.ones((10, 10), dtype=np.float32)
    values[:, 5:] = -9999.0
    prior = prior_over(write_grid(tmp_path / "p.tif", values, nodata=-9999.0), ORIGIN, AREA)
    west, east = prior.at(np.array([[-50.0, 0.0], [50.0, 0.0]]))
    assert west > 0.0 == east


@pytest.mark.parametrize(
    ("change", "crs", "words"),
    [
        (np.nan, "EPSG:32633", "1 cells that are no finite number: declare them as nodata"),
        (np.inf, "EPSG:32633", "no finite number"),
        (-0.5, "EPSG:32633", "negative values, down to -0.5: set them to 0"),
        (1.0, None, "states no coordinate system: set it (gdal_edit.py"),
    ],
)
def test_rasters_of_no_use_are_refused_with_the_remedy(
    tmp_path: Path, change: float, crs: str | None, words: str
) -> None:
    values = np.ones((10, 10), dtype=np.float32)
    values[3, 4] = change
    with pytest.raises(InputDataError, match=r".*") as refusal:
        read_prior(write_grid(tmp_path / "p.tif", values, crs))
    assert words in str(refusal.value)


def test_rasters_that_say_nothing_or_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputDataError, match=r"Every value .* is 0"):
        read_prior(write_grid(tmp_path / "p.tif", np.zeros((10, 10), dtype=np.float32)))
    (tmp_path / "text.tif").write_text("no raster", "utf-8")
    for name, words in (("text.tif", "cannot be read"), ("gone.tif", "does not exist"), ("p.png", "must be a GeoTIFF")):
        with pytest.raises(InputDataError, match=words):
            read_prior(str(tmp_path / name))


BOX = (-50.0, -50.0, 50.0, 50.0)
DISTANCES = [100.0, 200.0, 300.0, 400.0]


@pytest.mark.parametrize(
    ("features", "members", "words"),
    [
        ([], {}, "holds no feature"),
        ([polygon(*BOX)], {}, "feature 1 has neither probability (0 to 1) nor weight"),
        ([polygon(*BOX, probability=-0.1)], {}, "probability of feature 1 must not be negative, but is -0.1"),
        ([polygon(*BOX, probability=60)], {}, "must be 0 to 1, but is 60: state a share of 1, or weight"),
        ([polygon(*BOX, probability="much")], {}, "must be a finite number, but is 'much'"),
        ([polygon(*BOX, weight=0)], {}, "every weight is 0"),
        ([polygon(*BOX, probability=0.7), polygon(*BOX, probability=0.7)], {}, "add up to 1.4, 1 at most"),
        ([polygon(*BOX, probability=0.7), polygon(*BOX, weight=7)], {}, "use one of them"),
        ([polygon(*BOX, weight=1), point(0, 0, distances_m=DISTANCES)], {}, "either polygons, or one last known point"),
        ([point(0, 0, distances_m=DISTANCES)] * 2, {}, "holds 2 points: leave one"),
        ([point(0, 0, category="hiker")], {}, "needs the property distances_m"),
        ([point(0, 0, distances_m=[1, 2, 3])], {}, "25%, 50%, 75%, 95% of lost persons"),
        ([point(0, 0, distances_m=[200, 100, 300, 400])], {}, "four ascending numbers of metres above 0"),
        ([point(0, 0, distances_m=[0, 100, 300, 400])], {}, "four ascending numbers of metres above 0"),
        ([polygon(*BOX, weight=1)], {"crs": {"properties": {"name": "EPSG:32633"}}}, "save it as EPSG:4326"),
        ([polygon(*BOX, weight=1)], {"type": "Topology"}, "its type is 'Topology'"),
        ([{"type": "Feature", "properties": {}, "geometry": None}], {}, "without a geometry"),
        (["feature"], {}, "among its features"),
    ],
)
def test_shapes_of_no_use_are_refused_with_the_remedy(
    written: Written, features: list[Any], members: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputDataError) as refusal:
        read_prior(written(*features, **members))
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ("coordinates", "words"),
    [
        ([[[448000.0, 5350000.0]] * 4], "no longitude and latitude: save it as EPSG:4326"),
        ([[[14.0, 48.0], [14.1, 48.0]]], "a ring of 2 corners"),
        ([[[14.0, 48.0], [14.1, 48.0], [14.2, 48.0]]], "without an area"),
        ([[[14.0, None], [14.1, 48.0], [14.2, 48.0]]], "no pair of numbers"),
        ([], "without coordinates"),
        ([7], "no list of places"),
    ],
)
def test_polygons_of_no_use_are_refused(written: Written, coordinates: Any, words: str) -> None:
    geometry = {"type": "Polygon", "coordinates": coordinates}
    with pytest.raises(InputDataError) as refusal:
        read_prior(written({"type": "Feature", "properties": {"weight": 1}, "geometry": geometry}))
    assert words in str(refusal.value)


def test_plans_are_refused_or_warned_by_what_the_prior_says_of_their_area(written: Written) -> None:
    settings = replace(SETTINGS, search=SearchSettings(prior=written(polygon(-200.0, -100.0, 0.0, 100.0, weight=1))))
    (warning,) = check_plan(PLAN, settings)
    assert not warning.blocking
    assert warning.text.startswith("50% of the prior probability lies outside of the search area")
    (check,) = check_prior(settings, ORIGIN)
    assert (check.status, check.text) == (CheckStatus.WARN, "50% of the probability lies in the search area")
    written(polygon(-100.0, -100.0, 100.0, 100.0, weight=1))
    assert check_plan(PLAN, settings) == []
    assert check_prior(settings, ORIGIN)[0].status is CheckStatus.PASS
    assert check_prior(SETTINGS, ORIGIN) == ()
    written(polygon(300.0, -100.0, 400.0, 100.0, weight=1))
    (problem,) = check_plan(PLAN, settings)
    assert problem.blocking
    assert "does not meet the search area" in problem.text
    (check,) = check_prior(settings, ORIGIN)
    assert check.status is CheckStatus.FAIL
    assert not check.overridable
    elsewhere = GeodeticPosition(48.3, 14.3047, 260.0)
    assert check_plan(PLAN, replace(settings, origin=None), origin=elsewhere) == [], "350 m to the east"
    assert check_plan(PLAN, replace(settings, origin=None)) == [], "nobody knows where the area is"
    Path(settings.search.prior or "").unlink()
    assert [problem.blocking for problem in check_plan(PLAN, settings)] == [True]


def test_a_configuration_with_a_prior_of_no_use_is_refused(written: Written) -> None:
    def configured(prior: object) -> MissionSettings:
        mission = {"vehicles": 3, "area_enu_m": AREA, "origin_deg": (48.3, 14.3, 260.0)}
        table = {"link": {"urls": ["udpin://127.0.0.1:14550"]}, "mission": mission, "search": {"prior": prior}}
        return mission_settings(parse_config(table))

    name = written(polygon(*BOX, weight=1))
    assert configured(name).search.prior == name
    with pytest.raises(ConfigurationError, match=r"search\.prior: The prior gone\.tif does not exist"):
        configured("gone.tif")
    with pytest.raises(ConfigurationError, match=r"search\.prior"):
        configured(7)
    written(polygon(300.0, -100.0, 400.0, 100.0, weight=1))
    with pytest.raises(ConfigurationError, match=r"cannot be flown \(area_enu_m\): Prior: .* does not meet"):
        configured(name)
