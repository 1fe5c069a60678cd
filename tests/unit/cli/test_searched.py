"""Searched ground of recorded missions: the command, the files of the interface, and what they refuse."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import httpx
import pytest

from aos_gcs.config.file import read_config
from aos_gcs.config.model import ServiceConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap.ground_map import open_map
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.decisions import LeftPlace, SearchRecord
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.planning.search_settings import SearchSettings
from aos_gcs.planning.settings import ForestSettings, MissionSettings
from aos_gcs.runtime.continuing import continued_sortie
from aos_gcs.runtime.recorded.viewer import Viewer
from aos_gcs.store.database import MissionDatabase
from tests.fakes.app import app_of
from tests.fakes.command_line import exit_status
from tests.fakes.ground_frames import ORIGIN, ground_frame
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import START_UTC_S, HandClock
from tests.fakes.records import snapshot

AREA = ((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0))
FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=5.0)


def recorded(
    folder: Path,
    forest: ForestSettings | None = FOREST,
    *,
    search: SearchSettings | None = None,
    carried: Path | None = None,
    east_m: float = 18.0,
    utc_s: float = START_UTC_S,
    last: MissionSnapshot | None = None,
) -> Path:
    """Record a search of which the eastern half was seen, or another one, and return its folder."""
    database = MissionDatabase(folder, {})
    settings = MissionSettings(2, AREA, ImagingSettings(), forest=forest, search=search or SearchSettings())
    database.write([partial(MissionDatabase.add_search, record=SearchRecord(settings, ORIGIN))])
    if last is not None:
        database.write([partial(MissionDatabase.add_event, event=Event(1, utc_s, EventKind.SNAPSHOT, last))])
    database.close()
    ground = open_map(folder / "ground", ORIGIN, 0.06, carried)
    for north_m in (-8.0, 0.0, 8.0):
        ground.add(ground_frame(east_m, north_m), Plane(0.0), utc_s)
    ground.flush()
    return folder


def run(*arguments: object) -> int:
    return exit_status(arguments)


def test_the_command_tells_figures_and_writes_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = recorded(tmp_path / "m")
    raster, gaps, floor = tmp_path / "pod.tif", tmp_path / "gaps.geojson", tmp_path / "floor.tif"
    assert run("searched", folder, "--raster", raster, "--gaps", gaps, "--floor", floor, "--below", 0.99) == 0
    told = capsys.readouterr().out
    assert "55% of the area seen" in told
    assert "3 frames" in told
    assert "mean probability of detection: standing" in told
    assert raster.stat().st_size > 500
    assert floor.stat().st_size > 500
    areas = [one["properties"]["area_m2"] for one in json.loads(gaps.read_text("utf-8"))["features"]]
    assert sum(areas) == 400.0, "three views are not enough anywhere"
    assert run("searched", folder, "--json") == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["seen_fraction"] == pytest.approx(0.55)
    assert 0.0 < figures["detection"]["standing"] < figures["detection"]["lying"] < 0.6


def test_segments_add_up_over_the_flights_of_an_operation(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    features = []
    for name, west_m, east_m in (("A", -10.0, 0.0), ("B", 0.0, 10.0)):
        corners = ((west_m, -10.0), (east_m, -10.0), (east_m, 10.0), (west_m, 10.0))
        places = [LocalFrame(ORIGIN).to_geodetic((*corner, 0.0)) for corner in corners]
        ring = [[place.longitude_deg, place.latitude_deg] for place in (*places, places[0])]
        properties = {"name": name, "weight": 3 if name == "A" else 1}
        geometry = {"type": "Polygon", "coordinates": [ring]}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    file = tmp_path / "segments.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}), "utf-8")
    search = SearchSettings(prior=str(file), segments=str(file))
    first = recorded(tmp_path / "first", search=search)
    second = recorded(tmp_path / "second", search=search, carried=first / "ground", east_m=-18.0)

    def figures(folder: Path) -> dict[str, dict[str, float]]:
        assert run("searched", folder, "--json") == 0
        told = json.loads(capsys.readouterr().out)
        assert told["success"] == pytest.approx(sum(one["success"] for one in told["segments"]), abs=0.01)
        return {one["name"]: one for one in told["segments"]}

    before, after = figures(first), figures(second)
    assert before["A"]["detection"] < before["B"]["detection"]
    assert after["A"]["detection"] > before["A"]["detection"]
    assert after["B"]["detection"] >= before["B"]["detection"]
    for name, share in (("A", 0.75), ("B", 0.25)):
        assert after[name]["probability"] == pytest.approx(share, abs=0.02)
        assert after[name]["success"] == pytest.approx(share * after[name]["detection"], abs=0.05)
    assert run("searched", second) == 0
    told = capsys.readouterr().out
    assert "probability of success by the prior: " in told
    assert "segment A: 100% of 0.02 ha seen, probability of detection (standing) " in told
    file.unlink()
    assert run("searched", second, "--json") == 0
    gone = json.loads(capsys.readouterr().out)
    assert (gone["segments"], gone["success"]) == ([], None)


@pytest.mark.parametrize(("after_s", "is_forgotten"), [(600.0, False), (601.0, True)])
def test_what_had_been_forgotten_at_the_last_frame_is_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], after_s: float, is_forgotten: bool
) -> None:
    search, utc_s = SearchSettings(forget_min=10.0), START_UTC_S + after_s
    first, gaps = recorded(tmp_path / "first", search=search), tmp_path / "gaps.geojson"
    second = recorded(tmp_path / "second", search=search, carried=first / "ground", east_m=-18.0, utc_s=utc_s)
    for folder, share in ((first, 0.55), (second, 0.55 if is_forgotten else 1.0)):
        assert run("searched", folder, "--json") == 0
        assert json.loads(capsys.readouterr().out)["seen_fraction"] == pytest.approx(share)
    assert run("searched", second, "--gaps", gaps, "--below", 0.001) == 0
    areas = [one["properties"]["area_m2"] for one in json.loads(gaps.read_text("utf-8"))["features"]]
    assert sum(areas) == pytest.approx(180.0 if is_forgotten else 0.0)


def test_without_a_described_forest_there_are_views_but_no_gaps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, gaps = recorded(tmp_path / "m", None), tmp_path / "gaps.geojson"
    assert run("searched", folder) == 0
    assert "detection" not in capsys.readouterr().out
    assert run("searched", folder, "--gaps", gaps) == 2
    assert "[forest]" in capsys.readouterr().err
    assert not gaps.exists()


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--posture", "kneeling"), "--posture"),
        (("--below", "1.5"), "--below"),
        (("--gaps", "no/such/folder/gaps.geojson"), "does not exist"),
        (("--gaps", "{folder}/mission.sqlite"), "file of the recording"),
    ],
)
def test_bad_options_are_refused_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], named: str
) -> None:
    folder = recorded(tmp_path / "m")
    assert run("searched", folder, *(one.format(folder=folder) for one in options)) == 2
    assert named in capsys.readouterr().err


CONFIGURATION = """
[mission]
vehicles = 2
any_vehicles = true
{mission}
[link]
urls = ["udpin:127.0.0.1:0"]
"""


def configured(tmp_path: Path, mission: str = "area_enu_m = [[0, 0], [30, 0], [30, 30], [0, 30]]") -> ServiceConfig:
    path = tmp_path / "mission.toml"
    path.write_text(CONFIGURATION.format(mission=mission), "utf-8")
    return read_config(path)


def test_a_later_flight_continues_the_map_of_an_earlier_one(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "monday")
    following = continued_sortie(configured(tmp_path), folder)
    assert following.settings.origin == ORIGIN, "the frame of the map goes on"
    assert following.settings.area_enu_m == ((0, 0), (30, 0), (30, 30), (0, 30))
    assert (following.number, following.operation, following.former_id) == (2, "monday", "monday")
    assert following.folder == folder
    again = open_map(tmp_path / "ground", ORIGIN, 0.06, carried=following.folder / "ground")
    assert again.header.frames == 3


def test_what_an_earlier_flight_has_left_for_later_is_left_to_the_one_that_continues_it(tmp_path: Path) -> None:
    left = (LeftPlace((12.0, 4.0), 0.3),)
    folder = recorded(tmp_path / "monday", last=replace(snapshot(), left_for_later=left))
    assert continued_sortie(configured(tmp_path), folder).left_for_later == left


def test_a_mission_that_waits_for_its_plan_can_continue(tmp_path: Path) -> None:
    assert continued_sortie(configured(tmp_path, ""), recorded(tmp_path / "monday")).settings.area_enu_m == ()


@pytest.mark.parametrize(
    ("mission", "named"),
    [
        ("area_enu_m = [[500, 0], [530, 0], [530, 30]]", "another area"),
        (
            "area_enu_m = [[0, 0], [30, 0], [30, 30]]\norigin_deg = [47.1, 15.0, 400.0]",
            r"has \[47.1, 15.0, 400.0\]\. Take",
        ),
    ],
)
def test_a_mission_of_another_place_is_not_continued(tmp_path: Path, mission: str, named: str) -> None:
    with pytest.raises(ConfigurationError, match=named):
        continued_sortie(configured(tmp_path, mission), recorded(tmp_path / "monday"))


def test_nothing_is_flown_where_there_is_nothing_to_continue(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    configured(tmp_path)
    MissionDatabase(tmp_path / "empty", {}).close()
    assert run("run", tmp_path / "mission.toml", "--continue", tmp_path / "empty") == 2
    assert "no map of searched ground" in capsys.readouterr().err


def test_a_mission_that_has_searched_nothing_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    MissionDatabase(tmp_path / "m", {}).close()
    assert run("searched", tmp_path / "m") == 2
    assert "no map of searched ground" in capsys.readouterr().err


async def test_the_interface_offers_the_same_files(tmp_path: Path) -> None:
    viewer = Viewer(recorded(tmp_path / "m"), ImagingSettings(), 5.0)
    app = app_of(ScriptedMission(HandClock()), viewer=viewer)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1") as client:
        gaps = await client.get("/api/ground.geojson", params={"posture": "lying", "below": 0.9})
        assert gaps.headers["content-type"] == "application/geo+json"
        assert 'filename="searched.geojson"' in gaps.headers["content-disposition"]
        assert {one["properties"]["posture"] for one in gaps.json()["features"]} == {"lying"}
        raster = await client.get("/api/ground.tif")
        assert raster.content[:2] == b"II"
        assert (await client.get("/api/ground.geojson", params={"below": 0.0})).status_code == 422
        assert (await client.get("/api/ground.png")).status_code == 422


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--raster", "pod.tif", "--gaps", "gaps.geojson"), "no section [forest]"),
        (("--raster", "pod.png"), "--raster pod.png: the name must end in .tif"),
        (("--raster", "pod.tif", "--gaps", "gaps.kml"), "--gaps gaps.kml: the name must end in .geojson"),
        (("--raster", "one.tif", "--floor", "one.tif"), "named for two results"),
    ],
)
def test_where_one_result_is_refused_none_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    folder = recorded(tmp_path / "m", None)
    (tmp_path / "out").mkdir()
    with contextlib.chdir(tmp_path / "out"):
        assert run("searched", folder, *options) == 2
    assert reason in capsys.readouterr().err
    assert not list((tmp_path / "out").iterdir())
