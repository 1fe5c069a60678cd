"""``aos-gcs calibrate``: camera, mount and clock of simulated flights, and what integrate makes of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.photos import read_photos
from aos_gcs.surveys.poses_file import read_poses
from tests.fakes.calibration_flight import FOV_DEG, CalibrationFlight, Truth
from tests.fakes.command_line import exit_status
from tests.fakes.photographs import exif_block, write_photograph, xmp_packet


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> CalibrationFlight:
    return CalibrationFlight(tmp_path_factory.mktemp("flight"), Truth())


@pytest.fixture(scope="module")
def calibration(flight: CalibrationFlight) -> Path:
    path = flight.poses.with_name("calibration.json")
    assert exit_status(flight.arguments(path, "--position-sigma", 0.02, "--attitude-sigma", 0.1)) == 0
    return path


def _errors_and_sigmas(
    flight: CalibrationFlight, truth: Truth, path: Path
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return errors of all unknowns and their standard deviations."""
    found = json.loads(path.read_text())
    lens = [*found.get("distortion_coefficients", [0.0, 0.0])[:2]]
    values = np.array([*found["boresight_deg"], found["camera_matrix"][0][0], *lens, found["clock_offset_s"]])
    true = np.array([*truth.boresight_deg, flight.camera.fx_px, *truth.lens[:2], truth.clock_offset_s])
    return np.abs(values - true), np.sqrt(np.diag(found["covariance"]))


def test_a_flight_tells_mount_clock_focal_length_and_lens(flight: CalibrationFlight, calibration: Path) -> None:
    truth, found = Truth(), json.loads(calibration.read_text())
    assert found["not_determined"] == []
    errors = np.abs(np.array(found["boresight_deg"]) - truth.boresight_deg)
    assert errors.max() < 0.1
    assert abs(found["clock_offset_s"] - truth.clock_offset_s) < 0.005
    focal_px = found["camera_matrix"][0][0]
    assert abs(focal_px / flight.camera.fx_px - 1.0) < 0.005
    assert abs(found["distortion_coefficients"][0] - truth.lens[0]) < 0.01
    errors, sigmas = _errors_and_sigmas(flight, truth, calibration)
    assert (errors < 3.5 * sigmas).all()
    before_px, after_px = found["median_residual_px"]
    assert before_px > 3.0
    assert after_px < 0.2
    before_px, after_px = found["held_out_residual_px"]
    assert before_px > 3.0
    assert after_px < 0.4
    assert found["doubts"] == []


def test_integrals_are_sharp_with_the_calibration(flight: CalibrationFlight, calibration: Path, tmp_path: Path) -> None:
    common = ["integrate", str(flight.images), "--poses", str(flight.poses), "--convention", "camera-to-world,enu"]
    common += [
        "--plane-z",
        "0",
        "--ortho",
        "0.1",
        "--out",
        str(tmp_path / "map.npy"),
        "--count",
        str(tmp_path / "n.npy"),
    ]
    contrasts = []
    for camera in (["--fov", str(FOV_DEG)], ["--calibration", str(calibration)]):
        assert exit_status([*common, *camera]) == 0
        values, count = np.load(tmp_path / "map.npy"), np.load(tmp_path / "n.npy")
        contrasts.append(float(np.std(np.squeeze(values)[count > 0.6 * count.max()])))
    assert contrasts[1] > 1.25 * contrasts[0]


def test_a_calibration_without_times_leaves_the_clock(
    flight: CalibrationFlight, calibration: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    images = [{key: entry[key] for key in ("imagefile", "M3x4")} for entry in flight.document["images"]]
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": images}))
    arguments = ["integrate", str(flight.images), "--poses", str(poses), "--convention", "camera-to-world,enu"]
    arguments += [
        "--plane-z",
        "0",
        "--view",
        "0",
        "--out",
        str(tmp_path / "view.npy"),
        "--calibration",
        str(calibration),
    ]
    assert exit_status(arguments) == 0
    assert "The clock offset of the calibration is not applied" in capfd.readouterr().err


def test_a_single_line_determines_neither_focal_length_nor_clock(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    flight = CalibrationFlight(tmp_path, Truth(heights_m=(20.0,), headings_deg=(0.0, 0.0)))
    out = tmp_path / "calibration.json"
    assert exit_status(flight.arguments(out)) == 0
    found = json.loads(out.read_text())
    assert {"focal_px", "clock_offset_s"} <= set(found["not_determined"])
    assert found["clock_offset_s"] == 0.0
    assert "clock offset: not determined by this flight" in capfd.readouterr().out


def test_a_result_far_from_what_was_told_is_not_written_unless_forced(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    truth = Truth(boresight_deg=(0.0, 12.0, 0.0), lens=(), focal_error=0.0, heights_m=(20.0,), headings_deg=(0.0, 90.0))
    flight = CalibrationFlight(tmp_path, truth)
    out = tmp_path / "calibration.json"
    assert exit_status(flight.arguments(out)) == 2
    errors = capfd.readouterr().err
    assert "Far from the given values: pitch. Check poses" in errors
    assert "Images left out of the fit bear it out: --force is right where these were guesses." in errors
    assert "is not written. Follow them, or write it with --force" in errors
    assert not out.exists()
    assert exit_status(flight.arguments(out, "--force")) == 0
    (doubt,) = json.loads(out.read_text())["doubts"]
    assert doubt.startswith("Far from the given values: pitch.")
    capfd.readouterr()
    arguments = ["integrate", str(flight.images), "--poses", str(flight.poses), "--out", str(tmp_path / "view.npy")]
    arguments += ["--convention", "camera-to-world,enu", "--plane-z", "0", "--view", "0", "--calibration", str(out)]
    assert exit_status(arguments) == 0
    assert f"The calibration {out} is doubtful and was written with --force: Far from" in capfd.readouterr().err


def test_poses_that_err_more_than_is_said_are_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    truth = Truth(attitude_sigma_deg=1.5, heights_m=(20.0,), headings_deg=(0.0, 180.0), size_px=(192, 144))
    flight = CalibrationFlight(tmp_path, truth)
    arguments = flight.arguments(tmp_path / "calibration.json")
    assert exit_status([*arguments, "--attitude-sigma", "0.2"]) == 2
    errors = capfd.readouterr().err
    assert "Recorded poses err by more than --attitude-sigma says" in errors
    assert "--position-drift" not in errors
    assert exit_status([*arguments, "--attitude-sigma", "2"]) == 0
    assert "Recorded poses err" not in capfd.readouterr().err


def test_a_camera_that_was_right_is_not_replaced(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    truth = Truth(boresight_deg=(0.0, 0.0, 0.0), clock_offset_s=0.0, focal_error=0.0, lens=())
    flight = CalibrationFlight(tmp_path, truth)
    out = tmp_path / "calibration.json"
    assert exit_status(flight.arguments(out, "--position-sigma", 0.02, "--attitude-sigma", 0.1)) == 2
    assert "Images left out of the fit are described no better" in capfd.readouterr().err
    assert not out.exists()


def test_positions_that_drift_bend_the_result_unless_it_is_said(tmp_path: Path) -> None:
    truth = Truth(drift_m=1.0)
    flight = CalibrationFlight(tmp_path, truth)
    out = tmp_path / "calibration.json"
    common = ("--position-sigma", 0.05, "--attitude-sigma", 0.1)
    assert exit_status(flight.arguments(out, *common, "--force")) == 0
    assert "add --position-drift 2" in " ".join(json.loads(out.read_text())["doubts"])
    errors, sigmas = _errors_and_sigmas(flight, truth, out)
    assert (errors / sigmas).max() > 10.0
    assert exit_status(flight.arguments(out, *common, "--position-drift", 2)) == 0
    errors, sigmas = _errors_and_sigmas(flight, truth, out)
    assert (errors < 3.5 * sigmas).all()
    assert json.loads(out.read_text())["doubts"] == []


ERRING_POSES = Truth(
    boresight_deg=(0.0, 0.0, 0.0),
    clock_offset_s=0.0,
    focal_error=0.0,
    lens=(),
    heights_m=(20.0,),
    headings_deg=(0.0, 180.0),
    attitude_sigma_deg=1.0,
    position_sigma_m=0.05,
)


def scatter_m(poses: Sequence[Pose], flight: CalibrationFlight) -> float:
    """Scatter of the places on the ground that frames show in their middle, about the true ones."""

    def places(poses: Sequence[Pose]) -> NDArray[np.float64]:
        forward = np.array([pose.R_cam2enu[:, 2] for pose in poses])
        centres_m = np.array([pose.position_enu_m for pose in poses])
        return np.asarray(centres_m[:, :2] - centres_m[:, 2:] / forward[:, 2:] * forward[:, :2])

    return float(np.std(places(poses) - places(flight.true_poses), axis=0).mean())


def test_neighbours_correct_the_errors_of_single_poses(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    flight = CalibrationFlight(tmp_path, ERRING_POSES)
    flight.document["images"].append({**flight.document["images"][0], "imagefile": "7_0.png", "note": "kept"})
    flight.save()
    (flight.images / "7_0.png").write_bytes((flight.images / "0_0.png").read_bytes())
    refined = tmp_path / "refined.json"
    arguments = ["calibrate", str(flight.images), "--poses", str(flight.poses), "--fov", str(FOV_DEG)]
    arguments += ["--convention", "camera-to-world,enu", "--frames", "0:8", "--poses-out", str(refined)]
    assert exit_status([*arguments, "--position-sigma", "0.05", "--attitude-sigma", "1"]) == 0
    assert "poses of 8 of 8 images corrected" in capfd.readouterr().out
    entries = json.loads(refined.read_text())["images"]
    assert entries[8] == flight.document["images"][8]

    def poses(images: list[dict[str, Any]]) -> list[Pose]:
        return [Pose(M[:, 3], M[:, :3]) for M in (np.array(entry["M3x4"]) for entry in images[:8])]

    assert scatter_m(poses(entries), flight) < 0.5 * scatter_m(poses(flight.document["images"]), flight)


def test_corrected_poses_of_photographs_are_a_poses_file(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    flight = CalibrationFlight(tmp_path, ERRING_POSES)
    folder, refined, out = tmp_path / "photographs", tmp_path / "refined.json", tmp_path / "map.tif"
    flight.write_photographs(folder)
    arguments = ["calibrate", str(folder), "--poses-out", str(refined)]
    assert exit_status([*arguments, "--position-sigma", "0.05", "--attitude-sigma", "1"]) == 0
    assert "poses of 8 of 8 images corrected" in capfd.readouterr().out
    recorded, corrected = read_photos(folder), read_poses(refined, folder)
    assert corrected.origin == recorded.origin
    assert [image.path for image in corrected.images] == [image.path for image in recorded.images]
    assert corrected.images[0].camera == recorded.images[0].camera
    before, after = ([image.pose for image in survey.images] for survey in (recorded, corrected))
    assert scatter_m(after, flight) < 0.5 * scatter_m(before, flight)
    map_of = ["integrate", str(folder), "--poses", str(refined), "--plane-z", "0", "--ortho", "0.2", "--out", str(out)]
    assert exit_status(map_of) == 0


def test_corrected_poses_are_those_of_one_camera(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    flight = CalibrationFlight(tmp_path, replace(ERRING_POSES, headings_deg=(0.0,)))
    folder = tmp_path / "photographs"
    flight.write_photographs(folder)
    tags = {"RelativeAltitude": "+20", "GimbalYawDegree": 0, "GimbalPitchDegree": -90, "CalibratedFocalLength": 127}
    xmp = xmp_packet({f"drone-dji:{name}": value for name, value in tags.items()})
    ramp = np.tile(np.arange(flight.camera.width_px, dtype=np.uint8), (flight.camera.height_px, 1))
    write_photograph(folder / "0_3.jpg", ramp, exif_block(48.3069, 14.2858), xmp)
    refined = tmp_path / "refined.json"
    assert exit_status(["calibrate", str(folder), "--poses-out", str(refined)]) == 2
    assert "0_0.jpg and 0_3.jpg have different sizes or focal lengths" in capfd.readouterr().err
    assert not refined.exists()


def test_images_without_texture_are_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    import cv2  # noqa: PLC0415

    flight = CalibrationFlight(tmp_path, Truth(heights_m=(20.0,), headings_deg=(0.0, 180.0)))
    ramp = np.tile(np.arange(flight.camera.width_px, dtype=np.uint8) // 2, (flight.camera.height_px, 1))
    for path in flight.images.iterdir():
        cv2.imwrite(str(path), ramp)
    out = tmp_path / "calibration.json"
    assert exit_status(flight.arguments(out)) == 2
    assert "have only 0 points in common" in capfd.readouterr().err
    arguments = [argument if argument != "--out" else "--poses-out" for argument in flight.arguments(out)]
    assert exit_status(arguments) == 2
    assert "No 40 images in a row have 60 points in common" in capfd.readouterr().err
    assert not out.exists()


def test_bad_options_and_files_are_named(
    flight: CalibrationFlight, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "calibration.json"
    cases = [
        (flight.arguments(out, "--position-sigma", 0), "--position-sigma must be a positive number"),
        (flight.arguments(out, "--position-drift", -1), "--position-drift must be a number of at least 0"),
        (flight.arguments(out, "--frames", "0:3"), "needs 6 images with poses, got 3"),
        (flight.arguments(tmp_path / "absent" / "file.json"), "absent"),
        (flight.arguments(flight.poses), f"Cannot write {flight.poses}: it is a file of the recording"),
        (flight.arguments(next(flight.images.iterdir())), "the name must end in .json"),
        (flight.arguments(out)[:-2], "Nothing to write: give --out FILE.json"),
        (flight.arguments(out, "--poses-out", flight.poses), "it is a file of the recording"),
    ]
    bad = tmp_path / "bad.json"
    for content, message in (
        ({"camera_matrix": [[1, 0, 1], [0, 1, 1], [0, 0, 1]]}, "'boresight_deg' must be yaw, pitch and roll"),
        ({"boresight_deg": [0, 0, 90]}, "'boresight_deg' must be yaw, pitch and roll of at most 45"),
        ({"boresight_deg": [0, 0, 0], "clock_offset_s": "late"}, "'clock_offset_s' must be a number"),
        ({"boresight_deg": [0, 0, 0], "doubts": "none"}, "'doubts' must be a list of texts"),
        ({"boresight_deg": [0, 0, 0]}, "neither 'camera_matrix'"),
    ):
        bad.write_text(json.dumps(content))
        arguments = ["integrate", str(flight.images), "--poses", str(flight.poses), "--out", str(tmp_path / "a.npy")]
        arguments += ["--view", "0", "--plane-z", "0", "--calibration", str(bad)]
        assert exit_status(arguments) == 2
        assert message in capfd.readouterr().err
        assert exit_status([*arguments, "--fov", "60"]) == 2
        assert "--calibration and --fov exclude each other" in capfd.readouterr().err
    for arguments, message in cases:
        assert exit_status(arguments) == 2
        assert message in capfd.readouterr().err
