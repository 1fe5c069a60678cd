"""Segments of a search: their files, and their figures over several flights."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import ViewRaster
from aos_gcs.groundmap.segments import segment_figures, success_of
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.planning.checks.check import check_plan
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.prior.file import lay_over
from aos_gcs.prior.segments import Segment, read_segments, segments_about
from aos_gcs.prior.shapes import PolygonPrior, WeightedPolygon
from tests.fakes.fleet import ORIGIN
from tests.fakes.shapes import polygon, ring_deg, write_features

AREA = ((-100.0, -100.0), (100.0, -100.0), (100.0, 100.0), (-100.0, 100.0))
PLAN = MissionPlan(vehicles=3, area_enu_m=AREA, layer_spacing_m=3.0)
SETTINGS = MissionSettings(vehicles=3, area_enu_m=AREA, imaging=ImagingSettings(), origin=ORIGIN)
Written = Callable[..., str]

OCCLUSION = 0.85
LAW = detection_by_views(OCCLUSION, DETECTABILITY[Posture.STANDING])
WEST = Segment("west", ((-100.0, -100.0), (0.0, -100.0), (0.0, 100.0), (-100.0, 100.0)))


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(*features: Any) -> str:
        return write_features(tmp_path / "segments.geojson", features)

    return write


def raster(west: int, east: int) -> ViewRaster:
    """The area, whose halves were seen from so many directions."""
    views = np.full((200, 200), east, dtype=np.uint8)
    views[:, :100] = west
    return ViewRaster(-100, -100, views)


def test_each_segment_has_its_own_figures_and_what_lies_beyond_the_map_was_not_seen() -> None:
    half_out = Segment("half out", ((50.0, -50.0), (150.0, -50.0), (150.0, 50.0), (50.0, 50.0)))
    west, out = segment_figures(raster(0, 10), (WEST, half_out), OCCLUSION, None)
    assert (west.name, west.area_m2, west.seen_fraction, west.detection) == ("west", 20_000.0, 0.0, 0.0)
    assert out.seen_fraction == pytest.approx(0.5)
    assert out.detection == pytest.approx(LAW[10] / 2.0)
    assert (out.probability, out.success) == (None, None)
    (unknown,) = segment_figures(raster(4, 0), (WEST,), None, None)
    assert (unknown.seen_fraction, unknown.detection) == (1.0, None)


def test_success_counts_where_the_person_is_likely_to_be() -> None:
    ring = tuple((latitude, longitude) for longitude, latitude in ring_deg(-100.0, -100.0, 0.0, 100.0))
    prior = lay_over(PolygonPrior((WeightedPolygon((ring,), 0.8),)), ORIGIN, AREA)
    for west, east in ((10, 0), (0, 10)):
        (figures,) = segment_figures(raster(west, east), (WEST,), OCCLUSION, prior)
        assert figures.probability == pytest.approx(0.8, abs=0.01)
        assert figures.success == pytest.approx(0.8 * LAW[west], abs=0.01)
        assert success_of(raster(west, east), OCCLUSION, prior) == pytest.approx(0.8 * LAW[west], abs=0.01)
    assert success_of(raster(1, 1), None, prior) is None
    assert success_of(raster(1, 1), OCCLUSION, None) is None


def test_names_are_those_of_the_file(written: Written) -> None:
    name = written(polygon(-100.0, -100.0, 0.0, 100.0, name="A 1"), polygon(0.0, -100.0, 100.0, 100.0, title="B"))
    first, second = segments_about(name, ORIGIN)
    assert (first.name, second.name) == ("A 1", "B")
    assert np.array(first.area_enu_m) == pytest.approx(np.array(WEST.area_enu_m), abs=0.02)


@pytest.mark.parametrize(
    ("features", "words"),
    [
        ([], "holds 0 features: name 1 to 50 segments"),
        ([polygon(-1, -1, 1, 1, name=str(number)) for number in range(51)], "holds 51 features"),
        ([polygon(-1, -1, 1, 1)], "feature 1 needs a name"),
        ([polygon(-1, -1, 1, 1, name="x" * 61)], "1 to 60 characters"),
        ([polygon(-1, -1, 1, 1, name="A")] * 2, "two segments are named 'A'"),
        ([{"type": "Feature", "properties": {"name": "A"}, "geometry": {"type": "Point"}}], "a segment is one polygon"),
    ],
)
def test_files_of_no_use_are_refused_with_the_remedy(written: Written, features: list[Any], words: str) -> None:
    with pytest.raises(InputDataError) as refusal:
        read_segments(written(*features))
    assert words in str(refusal.value)


def test_segments_with_holes_are_refused(written: Written) -> None:
    holed = polygon(-100.0, -100.0, 100.0, 0.0, name="A")
    holed["geometry"]["coordinates"].append(ring_deg(-50.0, -80.0, 50.0, -20.0))
    with pytest.raises(InputDataError, match="draw segments without holes"):
        read_segments(written(holed))
    with pytest.raises(InputDataError, match="must be a GeoJSON file"):
        read_segments("segments.kml")


def test_plans_are_warned_of_segments_elsewhere_and_refused_where_all_are(written: Written) -> None:
    here, there = polygon(-50, -50, 50, 50, name="here"), polygon(300, 0, 400, 100, name="there")
    settings = replace(SETTINGS, search=SearchSettings(segments=written(here, there)))
    (warning,) = check_plan(PLAN, settings)
    assert not warning.blocking
    assert warning.text == "Segments outside of the search area, which are not searched: there. Extend the area."
    written(here)
    assert check_plan(PLAN, settings) == []
    written(there)
    (problem,) = check_plan(PLAN, settings)
    assert problem.blocking
    assert "No segment of" in problem.text
    Path(settings.search.segments or "").write_text(json.dumps([]), "utf-8")
    assert [one.blocking for one in check_plan(PLAN, settings)] == [True]


def test_a_configuration_with_segments_of_no_use_is_refused() -> None:
    mission = {"vehicles": 3, "area_enu_m": AREA}
    table = {"link": {"urls": ["udpin://127.0.0.1:14550"]}, "mission": mission, "search": {"segments": "gone.geojson"}}
    with pytest.raises(ConfigurationError, match=r"search\.segments: The file of segments gone\.geojson does"):
        mission_settings(parse_config(table))
