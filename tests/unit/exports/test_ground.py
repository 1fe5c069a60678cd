"""Searched ground as files: outlines of gaps, GeoJSON and GeoTIFF."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.ground_files import SearchedGround, gaps_geojson, write_forest_floor, write_ground_raster
from aos_gcs.exports.outlines import outlines
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.groundmap.ground_map import open_map
from tests.fakes.ground_frames import COLOUR, ground_frame
from tests.fakes.ground_frames import ORIGIN as FRAME_ORIGIN

ORIGIN = GeodeticPosition(47.0, 15.0, 400.0)
AREA = ((0.0, 0.0), (30.0, 0.0), (30.0, 20.0), (0.0, 20.0))


def signed_area(ring: np.ndarray) -> float:
    x, y = ring.T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2.0)


def test_a_ring_of_cells_has_an_outer_ring_and_a_hole() -> None:
    labels = np.ones((3, 3), dtype=np.int32)
    labels[1, 1] = 0
    (outer, hole) = outlines(labels)[1]
    assert set(outer) == {(0, 0), (3, 0), (3, 3), (0, 3)}
    assert set(hole) == {(1, 1), (2, 1), (2, 2), (1, 2)}
    to_xy = np.array([[0, -1], [1, 0]])
    assert signed_area(np.array(outer) @ to_xy) == 9.0
    assert signed_area(np.array(hole) @ to_xy) == -1.0


def test_a_hole_that_touches_the_outside_at_a_corner_is_a_hole() -> None:
    labels = np.ones((3, 3), dtype=np.int32)
    labels[0, 0] = labels[1, 1] = 0
    outer, hole = outlines(labels)[1]
    assert set(outer) == {(1, 0), (3, 0), (3, 3), (0, 3), (0, 1), (1, 1)}
    assert set(hole) == {(1, 1), (2, 1), (2, 2), (1, 2)}


@given(arrays(np.uint8, (6, 7), elements=st.integers(0, 1)))
def test_outlines_enclose_their_cells_and_no_others(mask: np.ndarray) -> None:
    _, labels = cv2.connectedComponents(mask, connectivity=4)
    found = outlines(np.asarray(labels))
    assert set(found) == set(np.unique(labels)) - {0}
    painted = np.zeros_like(mask)
    for label, rings in found.items():
        to_xy = np.array([[0, -1], [1, 0]])
        areas = [signed_area(np.array(ring) @ to_xy) for ring in rings]
        assert areas[0] > 0.0
        assert all(area < 0.0 for area in areas[1:])
        assert sum(areas) == (labels == label).sum()
        # Every corner is one, no three in a line; and a ring that came to one twice would be no polygon.
        for ring in rings:
            assert len(set(ring)) == len(ring)
            steps = np.sign(np.diff(np.array([*ring, ring[0], ring[1]]), axis=0))
            assert (steps[1:] != steps[:-1]).any(axis=1).all()
        painted |= (labels == label).astype(np.uint8)
    assert np.array_equal(painted, mask)


def test_the_forest_floor_is_the_mean_of_all_frames_at_its_place(tmp_path: Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    ground = open_map(tmp_path / "ground", FRAME_ORIGIN, 0.06)
    ground.add(ground_frame(16.0, -16.0), Plane(0.0))
    ground.add(ground_frame(60.0, -16.0, bands=("red", "green", "blue")), Plane(0.0))
    write_forest_floor(tmp_path / "floor.tif", ground)
    with rasterio.open(tmp_path / "floor.tif") as dataset:
        row, column = dataset.index(16.0, -16.0)
        assert [float(band[row, column]) for band in dataset.read()] == pytest.approx(COLOUR)
        row, column = dataset.index(70.0, -16.0)
        values = dataset.read()[:, row, column]
        assert values[:3] == pytest.approx(COLOUR[:3])
        assert np.isnan(values[3])
        assert np.isnan(dataset.read(1)[dataset.index(16.0, -60.0)])
        assert dataset.res == (0.25, 0.25)


def test_nothing_is_written_of_a_map_without_tiles(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="nothing was searched"):
        write_forest_floor(tmp_path / "floor.tif", open_map(tmp_path / "ground", FRAME_ORIGIN, 0.06))


def searched(occlusion: float | None = 0.85) -> SearchedGround:
    views = np.full((64, 64), 40, dtype=np.uint8)
    views[45:49, 10:16] = 2
    views[50, 20] = 0
    return SearchedGround(ViewRaster(-63, -1, views), ORIGIN, AREA, occlusion, 12)


def test_gaps_are_polygons_at_their_places() -> None:
    (gap,) = json.loads(gaps_geojson(searched(), Posture.LYING, 0.9))["features"]
    assert gap["properties"]["area_m2"] == 24.0, "the single cell is too small to be told"
    expected = detection_by_views(0.85, DETECTABILITY[Posture.LYING])[2]
    assert gap["properties"]["mean_detection"] == pytest.approx(expected, abs=1e-3)
    (ring,) = gap["geometry"]["coordinates"]
    assert ring[0] == ring[-1]
    frame = LocalFrame(ORIGIN)
    places = np.array([frame.to_enu(GeodeticPosition(lat, lon, 400.0))[:2] for lon, lat in ring])
    assert places.min(axis=0) == pytest.approx([9.0, 14.0], abs=0.02)
    assert places.max(axis=0) == pytest.approx([15.0, 18.0], abs=0.02)
    assert signed_area(places[:-1]) == pytest.approx(24.0, abs=0.2)


def test_gaps_are_those_of_the_search_area_alone() -> None:
    ground = searched()
    nothing = np.zeros_like(ground.raster.views)
    unseen = SearchedGround(ViewRaster(-63, -1, nothing), ORIGIN, AREA, 0.85, 0)
    (gap,) = json.loads(gaps_geojson(unseen, Posture.STANDING, 0.5))["features"]
    assert gap["properties"]["area_m2"] == 600.0
    assert gap["properties"]["mean_detection"] == 0.0


@pytest.mark.parametrize("below", [0.0, 1.2, float("nan")])
def test_a_bound_that_is_no_probability_is_refused(below: float) -> None:
    with pytest.raises(ConfigurationError, match="below"):
        gaps_geojson(searched(), Posture.STANDING, below)


def test_without_a_described_forest_there_are_no_gaps_to_tell() -> None:
    with pytest.raises(ConfigurationError, match=r"\[forest\]"):
        gaps_geojson(searched(None), Posture.STANDING, 0.8)


@pytest.mark.parametrize(("occlusion", "bands"), [(0.85, 4), (None, 1)])
def test_the_raster_is_read_back_at_its_place(tmp_path: Path, occlusion: float | None, bands: int) -> None:
    rasterio = pytest.importorskip("rasterio")
    path = tmp_path / "pod.tif"
    write_ground_raster(path, searched(occlusion))
    with rasterio.open(path) as dataset:
        assert dataset.count == bands
        assert dataset.descriptions[0] == "views"
        assert dataset.transform.c == -1.0
        assert dataset.transform.f == 63.0
        assert dataset.read(1)[46, 12] == 2.0
        if occlusion is not None:
            standing = detection_by_views(occlusion, DETECTABILITY[Posture.STANDING])[2]
            assert dataset.read(2)[46, 12] == pytest.approx(standing, rel=1e-6)
            assert dataset.descriptions[1] == "detection standing"
