"""Heights of photographs and of the terrain below them, in ``aos-gcs integrate`` and ``survey``."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

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
    (finding,) = json.loads(capfd.readouterr().out)["findings"]
    assert finding["frames"] == 4
