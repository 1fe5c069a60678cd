"""``aos-gcs terrain check``: what operators are told of an elevation model."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.fakes.command_line import exit_status
from tests.fakes.elevation_files import PLACE_DEG, ground_m, write_geoid, write_model

pytest.importorskip("rasterio", reason="needs the extra geo")

PLAN = """
[link]
urls = ["udpin://127.0.0.1:14550"]
[mission]
vehicles = 3
any_vehicles = true
origin_deg = [47.5, 14.25, 800.0]
area_enu_m = [[-60.0, -60.0], [60.0, -60.0], [60.0, 60.0], [-60.0, 60.0]]
"""


def check(*options: object) -> int:
    return exit_status(["terrain", "check", *map(str, options)])


def test_a_terrain_is_described_with_the_heights_of_a_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, plan = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773"), tmp_path / "plan.toml"
    plan.write_text(PLAN)
    assert check(model, "--kind", "terrain", "--plan", plan, "--at", "47.5003,14.2504", "--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["datum"] == "EGM96 height"
    assert report["cells"] == 12_000
    assert report["holes"] == {"count": 0, "cells": 12_000, "first_deg": None, "suspected": None}
    heights = {place["name"]: place["height_m"] for place in report["places"]}
    assert list(heights) == ["launch site", "corner 1", "corner 2", "corner 3", "corner 4", "47.5003,14.2504"]
    assert heights["launch site"] == pytest.approx(float(ground_m(*PLACE_DEG)), abs=0.1)
    assert heights["47.5003,14.2504"] == pytest.approx(float(ground_m(47.5003, 14.2504)), abs=0.1)
    assert report["area"]["unknown"] == 0
    assert report["area"]["highest_m"] - report["area"]["lowest_m"] > 20.0
    followed = report["followed"]
    assert followed["max_slope"] == pytest.approx(0.1)
    assert followed["least_above_ground_m"] >= 35.0
    assert 39.0 < followed["most_above_ground_m"] < 120.0
    assert check(model, "--kind", "terrain", "--plan", plan) == 0
    captured = capsys.readouterr()
    assert "vertical datum: EGM96 height" in captured.out
    assert "holes: none" in captured.out
    assert "geoid: " in captured.out
    assert "of relief; 0 of" in captured.out
    assert "at most 10% steep, " in captured.out
    assert "beyond the ceiling" not in captured.out
    assert captured.err == ""


def test_an_origin_that_does_not_fit_the_model_is_told_with_the_likely_cause(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    feet = np.full((120, 100), 800.0 / 0.3048, dtype=np.float32)
    model, plan = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=feet), tmp_path / "plan.toml"
    plan.write_text(PLAN)
    assert check(model, "--kind", "terrain", "--plan", plan) == 1
    told = capsys.readouterr().err
    assert "The origin's altitude of 800.0 m differs by 1824.7 m from the elevation model" in told
    assert "(the model's heights look like feet)" in told
    raised, geoid = feet * 0.3048 + 45.0, write_geoid(tmp_path / "geoid.gtx", 45.0)
    write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=raised)
    assert check(model, "--kind", "terrain", "--plan", plan, "--geoid", geoid) == 1
    assert "look like those above the ellipsoid (the geoid is 45.0 m above" in capsys.readouterr().err


def test_layers_that_cannot_follow_a_gorge_are_told_where(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = np.full((120, 100), 800.0, dtype=np.float32)
    heights[55:65, 48:52] = 700.0
    model, plan = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights), tmp_path / "plan.toml"
    plan.write_text(PLAN.replace("800.0", "700.0"))
    assert check(model, "--kind", "terrain", "--plan", plan) == 0
    assert "20.0 m beyond the ceiling of 120 m at 47." in capsys.readouterr().out


def test_a_hole_below_the_area_is_told_and_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[55:60, 48:53] = np.nan
    model, plan = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights), tmp_path / "plan.toml"
    plan.write_text(PLAN)
    assert check(model, "--kind", "terrain", "--plan", plan) == 1
    out = capsys.readouterr().out
    assert "holes: 25 cells (0.2%), the first at 47.5" in out
    assert "launch site: no height" in out
    assert "search area: 700.0 to 700.0 m" in out


def test_a_model_without_heights_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = np.full((120, 100), np.nan, dtype=np.float32)
    model = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights)
    assert check(model, "--kind", "terrain") == 1
    assert "holes: 12,000 cells (100.0%)" in capsys.readouterr().out


def test_a_surface_model_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, geoid = write_model(tmp_path / "dsm.tif", "EPSG:4979", cell=5e-5), write_geoid(tmp_path / "geoid.gtx", 45.0)
    assert check(model, "--kind", "surface", "--geoid", geoid, "--at", "47.5,14.25") == 0
    captured = capsys.readouterr()
    assert "its heights are those of crowns" in captured.err
    assert f"47.5,14.25: {float(ground_m(*PLACE_DEG)) - 45.0:.1f}" in captured.out


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--kind", "ground"), "--kind must be terrain or surface"),
        (("--kind", "terrain", "--at", "95,10"), "--at needs LATITUDE,LONGITUDE"),
        (("--kind", "terrain", "--geoid", "absent.gtx"), "does not exist"),
        (("--kind", "terrain", "--datum", "ellipsoid"), "according to the file"),
        (("--kind", "terrain", "--plan", "absent.toml"), "Cannot read the configuration"),
    ],
)
def test_wrong_options_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    assert check(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773"), *options) == 2
    assert reason in capsys.readouterr().err


def test_a_plan_without_places_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('[link]\nurls = ["udpin://127.0.0.1:14550"]\n[mission]\nvehicles = 3\n')
    assert check(write_model(tmp_path / "dtm.tif", "EPSG:32633+5773"), "--kind", "terrain", "--plan", plan) == 2
    assert "mission.origin_deg and the search area are needed" in capsys.readouterr().err


def test_a_patch_of_zeros_and_tiles_that_contradict_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    heights = np.full((120, 100), 700.0, dtype=np.float32)
    heights[40:60, 50:80] = 0.0
    model = write_model(tmp_path / "dtm.tif", "EPSG:32633+5773", heights=heights)
    assert check(model, "--kind", "terrain") == 0
    told = capsys.readouterr().err
    assert "may have holes that are written as 0: 600 cells are exactly 0 m" in told
    other = write_model(tmp_path / "other.tif", "EPSG:32633+5773", heights=heights / np.float32(0.3048))
    assert check(model, other, "--kind", "terrain") == 2
    assert "overlap and contradict each other by up to 1596.6 m" in capsys.readouterr().err


@pytest.mark.parametrize("crs", ["EPSG:32760+5773", "EPSG:32701+5773"])
def test_a_plan_across_the_180th_meridian_is_looked_at_where_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], crs: str
) -> None:
    import pyproj  # noqa: PLC0415 - tests without the extra are skipped
    import rasterio  # noqa: PLC0415 - tests without the extra are skipped
    from rasterio.transform import Affine  # noqa: PLC0415

    model, plan = tmp_path / "fiji.tif", tmp_path / "plan.toml"
    to_crs = pyproj.Transformer.from_crs("EPSG:4326", crs.partition("+")[0], always_xy=True)
    x, y = to_crs.transform(180.0, -16.8)
    profile = {"driver": "GTiff", "height": 120, "width": 120, "count": 1, "dtype": "float32", "nodata": -9999.0}
    with rasterio.open(model, "w", crs=crs, transform=Affine(5, 0, x - 300, 0, -5, y + 300), **profile) as dataset:
        dataset.write(np.full((120, 120), 800.0, dtype=np.float32), 1)
    plan.write_text(PLAN.replace("47.5, 14.25", "-16.8, 180.0"))
    assert check(model, "--kind", "terrain", "--plan", plan, "--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["area"]["unknown"] == 0
    south, west, north, east = report["bounds_deg"]
    assert east - west < 0.01
    assert north - south < 0.01
