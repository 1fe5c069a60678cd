"""Heights of photographs and of the terrain below them, in ``aos-gcs integrate`` and ``survey``."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.mission.model.events import EventKind, NoticeRecord
from aos_gcs.ports import Severity
from aos_gcs.store.reader import MissionReader
from aos_gcs.surveys.photos import read_photos
from tests.fakes.command_line import exit_status
from tests.fakes.survey_flight import HEIGHT_M, HOT_M, Photographs, write_flat_terrain

SECOND_FLIGHT = ("3.jpg", "4.jpg", "5.jpg")


@pytest.fixture
def photographs(tmp_path: Path) -> Photographs:
    return Photographs(tmp_path, hot=True)


def heights_m(photographs: Photographs) -> list[float]:
    return [float(image.pose.position_enu_m[2]) for image in read_photos(photographs.images).images]


def test_flights_from_different_heights_lie_where_they_were_flown(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs.raise_takeoff(SECOND_FLIGHT, 12.0)
    assert heights_m(photographs) == pytest.approx([HEIGHT_M] * 6, abs=0.01)
    table = tmp_path / "anomalies.csv"
    options = ("--ortho", 0.1, "--blobs", table)
    assert exit_status(photographs.arguments(*options, "--dem", write_flat_terrain(tmp_path / "dem.tif"))) == 0
    (row,) = csv.DictReader(table.read_text().splitlines())
    assert (float(row["x_m"]), float(row["y_m"])) == pytest.approx(HOT_M, abs=0.2)
    two = "photographs of two takeoffs, 12 m apart in height, such as 0.jpg and 3.jpg: "
    assert f"{two}each counts from its own. If they began at one place" in capfd.readouterr().err
    assert exit_status(photographs.arguments(*options)) == 0
    assert f"{two}give --ground or --dem, or one folder for each flight" in capfd.readouterr().err
    assert exit_status(photographs.arguments(*options, "--ground", 310)) == 0
    assert "takeoffs" not in capfd.readouterr().err


def test_names_of_photographs_of_two_takeoffs_have_their_folders(photographs: Photographs) -> None:
    photographs.raise_takeoff(SECOND_FLIGHT, 12.0)
    for folder, names in (("100MEDIA", ("0.jpg", "1.jpg", "2.jpg")), ("101MEDIA", SECOND_FLIGHT)):
        (photographs.images / folder).mkdir()
        for index, name in enumerate(names):
            shutil.move(photographs.images / name, photographs.images / folder / f"{index}.jpg")
    (warning,) = read_photos(photographs.images).warnings
    assert "such as 100MEDIA/0.jpg and 101MEDIA/0.jpg" in warning


def test_heights_above_the_takeoff_outlast_a_drift_of_altitudes(photographs: Photographs) -> None:
    """A receiver without RTK drifts by metres from photograph to photograph, and one altitude is far off."""
    drift_m = np.random.default_rng(0).uniform(-2.0, 2.0, 6)
    drift_m[4] = 60.0
    for index, by_m in enumerate(drift_m):
        photographs.change(f"{index}.jpg", AbsoluteAltitude=f"{330.0 + by_m:.2f}")
    assert np.ptp(heights_m(photographs)) < 0.01
    (warning,) = read_photos(photographs.images).warnings
    assert warning.startswith("1 of 6 photographs have an absolute altitude that does not fit those beside them")
    assert warning.endswith("the first is 4.jpg")


def test_a_survey_of_two_takeoffs_finds_what_it_shows(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs.raise_takeoff(SECOND_FLIGHT, 12.0)
    dem = write_flat_terrain(tmp_path / "dem.tif")
    arguments = ["survey", str(photographs.images), "--headless", "--json", "--dem", str(dem)]
    assert exit_status(["--log-level", "error", *arguments]) == 0
    result = json.loads(capfd.readouterr().out)
    (finding,) = result["findings"]
    assert finding["frames"] == 4
    assert result["message"].endswith(" Read the warnings about heights first.")
    with MissionReader(Path(result["folder"])) as reader:
        notices = [event.data for event in reader.events(EventKind.NOTICE) if isinstance(event.data, NoticeRecord)]
    takeoffs, falling = [one.text for one in notices if one.severity is Severity.WARNING]
    assert takeoffs.startswith("photographs of two takeoffs, 12 m apart in height, such as 0.jpg and 3.jpg: ")
    assert "Unless the ground falls by 12.0 m from there, their altitudes err: put these photographs into" in falling


def misfit_of(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], dem: Path, *options: object, status: int = 0
) -> str:
    """Return what is said of a terrain that does not fit; empty where nothing is."""
    capfd.readouterr()
    assert exit_status(photographs.arguments("--ortho", 0.5, "--dem", dem, *options)) == status
    lines = capfd.readouterr().err.splitlines()
    return next((line.removeprefix("aos-gcs: ") for line in lines if "The photographs " in line), "")


def test_a_terrain_of_other_heights_is_named_with_the_offset_that_fits(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    dem = write_flat_terrain(tmp_path / "dem.tif", 310.0 - 47.5)
    warning = misfit_of(photographs, capfd, dem)
    assert warning == (
        f"The photographs were taken 67.5 m above the terrain {dem}, but 20.0 m above their place of takeoff "
        "(medians). Unless the ground falls by 47.5 m from there, the two count heights from different surfaces, such "
        "as the ellipsoid, or in different units: --dem-offset 47.5 puts the terrain at the height of the place of "
        "takeoff."
    )
    assert misfit_of(photographs, capfd, dem, "--dem-offset", 47.5) == ""
    assert "--dem-offset 47.5 puts" in misfit_of(photographs, capfd, dem, "--dem-offset", 20)
    assert misfit_of(photographs, capfd, write_flat_terrain(tmp_path / "dem.tif", 303.0)) == ""


def test_heights_above_the_ellipsoid_are_recognised(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Level:
        def undulation_m(self, _latitude_deg: float, _longitude_deg: float) -> float:
            return 46.0

    monkeypatch.setattr("aos_gcs.cli.terrain_heights.find_geoid", Level)
    warning = misfit_of(photographs, capfd, write_flat_terrain(tmp_path / "dem.tif", 310.0 - 47.5))
    assert "the altitude looks like one above the ellipsoid" in warning
    assert "the geoid is 46.0 m above the ellipsoid here): --dem-offset 47.5 puts" in warning


@pytest.mark.parametrize(
    ("height_m", "words"),
    [
        (310.0 / 0.3048, r"m below the terrain .*: the model's heights look like feet\. Convert them to metres\.$"),
        (340.0, r"10\.0 m below the terrain .* rises by 30\.0 m from there, .*: --dem-offset -30\.0 puts"),
    ],
)
def test_a_terrain_in_which_nothing_can_be_found_is_refused(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str], height_m: float, words: str
) -> None:
    refused = misfit_of(photographs, capfd, write_flat_terrain(tmp_path / "dem.tif", height_m), status=2)
    assert re.search(words, refused), refused
    assert not photographs.out.exists()


def test_heights_of_zero_where_there_are_none_are_refused(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for index in range(6):
        photographs.change(f"{index}.jpg", AbsoluteAltitude="2330.00")
    refused = misfit_of(photographs, capfd, write_flat_terrain(tmp_path / "dem.tif", 0.0), status=2)
    assert re.search(r"2330\.0 m above the terrain .*: check the terrain for holes that are not declared", refused)


def test_each_takeoff_is_compared_with_the_terrain(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The altitudes of the second flight, from the same place, are 30 m too high."""
    for name in SECOND_FLIGHT:
        photographs.change(name, AbsoluteAltitude="360.0")
    warning = misfit_of(photographs, capfd, write_flat_terrain(tmp_path / "dem.tif"))
    assert "50.0 m above the terrain" in warning
    assert "20.0 m above their place of takeoff (those with 3.jpg)" in warning
    assert warning.endswith("put these photographs into a folder of their own, and give --dem-offset 30.0 for it.")


def test_photographs_without_altitudes_need_an_offset_of_the_terrain(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in list(photographs.tags):
        photographs.strip(name, "AbsoluteAltitude")
    dem = write_flat_terrain(tmp_path / "dem.tif")
    refused = misfit_of(photographs, capfd, dem, status=2)
    assert "have neither AbsoluteAltitude nor GPSAltitude" in refused
    assert refused.endswith("Below the photographs it has 310.0 m in the median: --dem-offset -310.0 there.")
    table = tmp_path / "anomalies.csv"
    assert misfit_of(photographs, capfd, dem, "--dem-offset", -310.0, "--blobs", table) == ""
    assert "--dem-offset -310.0 puts" in misfit_of(photographs, capfd, dem, "--dem-offset", 310.0, status=2)
    assert exit_status(photographs.arguments("--ortho", 0.1, "--dem", dem, "--dem-offset", -310, "--blobs", table)) == 0
    (row,) = csv.DictReader(table.read_text().splitlines())
    assert (float(row["x_m"]), float(row["y_m"])) == pytest.approx(HOT_M, abs=0.2)
