"""``aos-gcs survey`` and ``integrate`` on terrain that does not reach below all photographs."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.store.reader import MissionReader
from tests.fakes.command_line import exit_status
from tests.fakes.survey_flight import TAKEOFF, Photographs


@pytest.fixture
def photographs(tmp_path: Path) -> Photographs:
    return Photographs(tmp_path, hot=True)


def survey(capfd: pytest.CaptureFixture[str], folder: Path, *options: object) -> dict[str, Any]:
    capfd.readouterr()
    assert exit_status(["--log-level", "error", "survey", str(folder), "--headless", "--json", *map(str, options)]) == 0
    result: dict[str, Any] = json.loads(capfd.readouterr().out)
    return result


def terrain(path: Path, east_m: float, hole: float | None = None) -> Path:
    """Write level terrain from 100 m west of the takeoff to a place east of it; a hole is not declared as one."""
    rasterio = pytest.importorskip("rasterio", reason="rasterio (the extra 'geo') is not installed")
    pyproj = pytest.importorskip("pyproj", reason="pyproj (the extra 'geo') is not installed")
    to_zone = pyproj.Transformer.from_crs("EPSG:4326", "EPSG:32633", always_xy=True)
    x, y = to_zone.transform(TAKEOFF.longitude_deg, TAKEOFF.latitude_deg)
    size = {"width": int(100 + east_m), "height": 200}
    heights = np.full((200, size["width"]), TAKEOFF.altitude_amsl_m, dtype=np.float32)
    if hole is not None:
        heights[:10, :10] = hole
    place = {"crs": "EPSG:32633", "transform": rasterio.Affine(1.0, 0.0, x - 100.0, 0.0, -1.0, y + 100.0)}
    with rasterio.open(path, "w", driver="GTiff", count=1, dtype="float32", **size, **place) as dataset:
        dataset.write(heights, 1)
    return path


def test_ground_without_a_height_is_not_said_to_be_examined(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    level = survey(capfd, photographs.images)["message"]
    whole, half = (tmp_path / name for name in ("whole", "half"))
    # Cells of 2 m: terrain in a zone is turned by half a degree.
    all_of_it = survey(capfd, photographs.images, "--dem", terrain(tmp_path / "whole.tif", 100.0), "--out", whole)
    assert re.sub(r"\d+ %", "N %", all_of_it["message"]) == re.sub(r"\d+ %", "N %", level)
    result = survey(capfd, photographs.images, "--dem", terrain(tmp_path / "half.tif", 8.0), "--out", half)
    found = re.fullmatch(
        r"6 of 6 pictures examined: 1 possible person(?:, in the \d+ % of the ground with a height that 2 successive "
        r"pictures or more show)?\. (\d+) % of the photographed ground has no height in half\.tif: not examined\.",
        result["message"],
    )
    assert found is not None
    # The photographs see from -14 to 35 m east, the first and the last of them a smaller strip of it.
    assert 45 <= int(found[1]) <= 60


def test_integrate_says_which_ground_has_no_height(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, east_m, expected in (("whole", 100.0, None), ("half", 8.0, r"(\d+) % .* has no height in half\.tif")):
        dem = terrain(tmp_path / f"{name}.tif", east_m)
        capfd.readouterr()
        assert exit_status(photographs.arguments("--ortho", 0.5, "--dem", dem)) == 0
        lines = [line for line in capfd.readouterr().err.splitlines() if "photographed ground" in line]
        assert bool(lines) == (expected is not None)
        if expected is not None:
            assert re.fullmatch(expected, lines[0])


@pytest.mark.parametrize("command", ["survey", "integrate"])
def test_holes_that_are_not_declared_are_refused(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str], command: str
) -> None:
    options = ["--headless"] if command == "survey" else ["--ortho", "0.5", "--out", str(photographs.out)]
    dem = terrain(tmp_path / "dem.tif", 100.0, -9999.0)
    assert exit_status([command, str(photographs.images), "--dem", str(dem), *options]) == 2
    assert "dem.tif has heights of -9999 m: declare them as holes (gdal_edit -a_nodata" in capfd.readouterr().err


def test_pictures_that_take_no_part_are_named_and_do_not_count(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    """One in colour among grey ones, and one that is black."""
    coloured = np.zeros((72, 96, 3), dtype=np.uint8) + np.array([200, 90, 10], dtype=np.uint8)
    photographs.write("4.jpg", coloured, photographs.tags["4.jpg"])
    photographs.write("5.jpg", np.zeros((72, 96), dtype=np.uint8), photographs.tags["5.jpg"])
    whole = survey(capfd, photographs.images)
    assert re.match(r"4 of 6 pictures examined: 1 possible person, in the \d+ % of the ground", whole["message"])
    with MissionReader(Path(whole["folder"])) as reader:
        left_out = [event.data.text for event in reader.events() if "left out" in getattr(event.data, "text", "")]
    assert left_out[0].startswith("Picture 4.jpg left out: ")
    assert left_out[1].startswith("Picture 5.jpg left out: ")
