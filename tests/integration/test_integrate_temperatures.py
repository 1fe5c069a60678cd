"""Temperatures of radiometric photographs in ``aos-gcs integrate``."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.photos import read_photos
from aos_gcs.surveys.poses_writing import poses_document
from aos_gcs.surveys.radiometric.dji import thermal_sdk
from tests.fakes import dji_sdk
from tests.fakes.command_line import exit_status
from tests.fakes.flir_photographs import make_radiometric
from tests.fakes.recorded_flight import Flight
from tests.fakes.survey_flight import CAMERA, Photographs, render


def warm_ground(pose: Pose) -> np.ndarray:
    return 12.0 + (render(pose, CAMERA).astype(np.float64) - 120.0) / 10.0


def test_radiometric_photographs_become_degrees(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    survey = read_photos(photographs.images)
    fov_deg = math.degrees(CAMERA.horizontal_fov_rad)
    for image in survey.images[:-1]:
        make_radiometric(image.path, warm_ground(image.pose), fov_deg=fov_deg)
    assert exit_status(photographs.arguments("--ortho", 0.25)) == 0
    shades = np.load(photographs.out)
    assert exit_status(photographs.arguments("--ortho", 0.25, "--degrees", "recorded")) == 0
    errors = capfd.readouterr().err
    assert "1 of 6 images are skipped; 5.jpg: it has no radiometric data of FLIR" in errors
    degrees = np.load(photographs.out)
    assert np.nanmean(degrees) == pytest.approx(12.0 + (np.nanmean(shades) - 120.0) / 10.0, abs=1.0)
    assert exit_status(photographs.arguments("--ortho", 0.25, "--degrees", "emissivity=0.8,reflected=-30")) == 0
    assert np.nanmean(np.load(photographs.out)) > np.nanmean(degrees) + 2.0


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_photographs_of_dji_become_degrees_by_its_sdk(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    for index in range(5):
        dji_sdk.insert(photographs.images / f"{index}.jpg", dji_sdk.RADIOMETRIC)
    dji_sdk.insert(photographs.images / "5.jpg", dji_sdk.CRASHING)
    library = dji_sdk.build(tmp_path / "sdk" / "linux" / "release_x64")
    degrees = ("--ortho", 0.25, "--degrees", "recorded")
    assert exit_status(photographs.arguments(*degrees)) == 2
    assert "0.jpg: it is a picture of DJI" in capfd.readouterr().err
    assert exit_status(photographs.arguments(*degrees, "--dji-sdk", tmp_path / "sdk")) == 0
    assert "1 of 6 images are skipped; 5.jpg: DJI's Thermal SDK has ended" in capfd.readouterr().err
    measured = dji_sdk.celsius()
    assert measured.min() <= np.nanmin(np.load(photographs.out)) < np.nanmax(np.load(photographs.out)) <= measured.max()
    thermal_sdk(library).close()


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_a_photograph_that_the_sdk_cannot_measure_is_named_or_skipped(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs = Photographs(tmp_path)
    for index in range(6):
        dji_sdk.insert(photographs.images / f"{index}.jpg", dji_sdk.COLD if index == 3 else dji_sdk.RADIOMETRIC)
    library = dji_sdk.build(tmp_path / "sdk")
    arguments = photographs.arguments("--ortho", 0.25, "--degrees", "recorded", "--dji-sdk", tmp_path / "sdk")
    assert exit_status(arguments) == 2
    assert "3.jpg has no temperatures: DJI's Thermal SDK gives no temperatures for some" in capfd.readouterr().err
    assert exit_status([*arguments, "--skip-broken"]) == 0
    assert "1 of 6 images are skipped" in capfd.readouterr().err
    thermal_sdk(library).close()


def test_an_sdk_needs_degrees(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert exit_status(Photographs(tmp_path).arguments("--ortho", 0.5, "--dji-sdk", tmp_path)) == 2
    assert "--dji-sdk requires --degrees" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("celsius", "--degrees needs 'recorded' or NAME=VALUE of emissivity, distance"),
        ("emissivity=2", "--degrees: emissivity must lie between 0.01 and 1, got '2'"),
        ("distance=", "--degrees: distance must lie between"),
    ],
)
def test_settings_of_temperatures_are_checked(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], settings: str, words: str
) -> None:
    assert exit_status(Photographs(tmp_path).arguments("--ortho", 0.5, "--degrees", settings)) == 2
    assert words in capfd.readouterr().err


def test_temperatures_need_radiometric_photographs(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert exit_status(Flight(tmp_path).arguments(degrees="recorded")) == 2
    assert "has no temperatures: it has no radiometric data of FLIR or DJI" in capfd.readouterr().err


@pytest.mark.parametrize("scale", [1, 2])
def test_temperatures_are_read_at_given_poses(tmp_path: Path, scale: int) -> None:
    """Pictures may have more pixels than the temperatures beside them: the camera of the file is scaled."""
    photographs = Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    survey = read_photos(photographs.images)
    fov_deg = math.degrees(CAMERA.horizontal_fov_rad)
    for image in survey.images:
        make_radiometric(image.path, warm_ground(image.pose), fov_deg=fov_deg)
    degrees = ("--ortho", 0.25, "--degrees", "recorded")
    assert exit_status(photographs.arguments(*degrees)) == 0
    expected = np.load(photographs.out)
    pictured = CameraModel.from_fov(scale * CAMERA.width_px, scale * CAMERA.height_px, CAMERA.horizontal_fov_rad)
    images = [(image.path.name, image.pose, image.taken_at_s) for image in survey.images]
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps(poses_document(images, survey.origin, pictured)))
    assert exit_status(photographs.arguments(*degrees, "--poses", poses, "--plane-z", 0)) == 0
    np.testing.assert_allclose(np.load(photographs.out), expected, atol=0.01)
