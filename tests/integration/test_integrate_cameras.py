"""Cameras and poses of recordings as other programs describe them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from tests.fakes import survey_flight
from tests.fakes.command_line import exit_status
from tests.fakes.recorded_flight import FOV_DEG, PLANE_Z, Flight

CAMERA = CameraModel.from_fov(60, 60, np.radians(FOV_DEG))
ODD = CameraModel(64, 48, 60.0, 45.0, 29.0, 26.5)
"""Neither square pixels nor its principal point in the centre."""
WORLDS = {"z-down": np.diag([1.0, -1.0, -1.0]), "ned": np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])}


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


def integral_of(flight: Flight, **options: object) -> NDArray[np.float32]:
    assert exit_status(flight.arguments(**options)) == 0
    return np.asarray(np.load(flight.out))


def take_again(flight: Flight, camera: CameraModel) -> NDArray[np.float64]:
    """Render the recording with another camera; return what the view is to show."""
    for index in range(4):
        image = flight.render(flight.pose(index), camera=camera)
        cv2.imwrite(str(flight.images / f"{index}.png"), np.round(image).astype(np.uint8))
    return flight.render(flight.pose(1), camera=CameraModel.from_fov(48, 48, camera.horizontal_fov_rad))


def opencv_yaml(camera: CameraModel, path: Path) -> None:
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", camera.width_px)
    storage.write("image_height", camera.height_px)
    storage.write("camera_matrix", camera.K)
    storage.write("distortion_coefficients", np.zeros((1, 5)))
    storage.release()


def ros_yaml(camera: CameraModel, path: Path) -> None:
    path.write_text(
        f"image_width: {camera.width_px}\nimage_height: {camera.height_px}\ncamera_name: narrow\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {camera.K.ravel().tolist()}\n"
        "distortion_model: plumb_bob\n"
        "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.0, 0.0, 0.0, 0.0, 0.0]\n"
    )


def opendronemap(camera: CameraModel, path: Path) -> None:
    # Of a copy of half the size, as its own examples are.
    width, height = camera.width_px // 2, camera.height_px // 2
    edge = max(camera.width_px, camera.height_px)
    fields = {
        "projection_type": "brown",
        "width": width,
        "height": height,
        "focal_x": camera.fx_px / edge,
        "focal_y": camera.fy_px / edge,
        "c_x": (camera.cx_px - (camera.width_px - 1) / 2) / edge,
        "c_y": (camera.cy_px - (camera.height_px - 1) / 2) / edge,
        **dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0.0),
    }
    path.write_text(json.dumps({"dji fc6310r 64 48 brown 0.9": fields}))


@pytest.mark.parametrize(
    ("name", "write"),
    [
        ("camera.yml", opencv_yaml),
        ("camera.json", opencv_yaml),
        ("camera.xml", opencv_yaml),
        ("ost.yaml", ros_yaml),
        ("cameras.json", opendronemap),
    ],
)
def test_a_camera_file_describes_any_pinhole(
    flight: Flight, tmp_path: Path, name: str, write: Callable[[CameraModel, Path], None]
) -> None:
    expected = take_again(flight, ODD)
    write(ODD, tmp_path / name)
    integral = integral_of(flight, fov=None, camera=tmp_path / name)
    assert np.nanmax(np.abs(np.squeeze(integral) - expected)) < 3.0
    assert np.isfinite(integral).mean() > 0.7


def test_the_poses_file_describes_any_pinhole(flight: Flight) -> None:
    expected = take_again(flight, ODD)
    fields = {"fx": ODD.fx_px, "fy": ODD.fy_px, "cx": ODD.cx_px, "cy": ODD.cy_px}
    flight.poses.write_text(json.dumps(flight.document | fields))
    integral = integral_of(flight, fov=None)
    assert np.nanmax(np.abs(np.squeeze(integral) - expected)) < 3.0


def test_a_camera_file_has_its_lens(flight: Flight, tmp_path: Path) -> None:
    file = {"camera_matrix": CAMERA.K.tolist(), "distortion_coefficients": [-0.2, 0.05, 0.001, 0.002, 0.0]}
    (tmp_path / "camera.json").write_text(json.dumps(file))
    by_file = integral_of(flight, fov=None, camera=tmp_path / "camera.json")
    np.testing.assert_array_equal(by_file, integral_of(flight, lens="-0.2,0.05,0.001,0.002"))
    file["distortion_coefficients"] = [-0.2, 0.05, 0.001, 0.002]
    (tmp_path / "camera.json").write_text(json.dumps(file | {"distortion_model": "equidistant"}))
    by_file = integral_of(flight, fov=None, camera=tmp_path / "camera.json")
    np.testing.assert_array_equal(by_file, integral_of(flight, fisheye="-0.2,0.05,0.001,0.002"))


def test_photographs_take_a_camera_file(tmp_path: Path) -> None:
    photographs = survey_flight.Photographs(tmp_path)
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.5)) == 0
    expected = np.load(photographs.out)
    opencv_yaml(survey_flight.CAMERA, tmp_path / "camera.yml")
    assert exit_status(photographs.arguments("--ortho", 0.5, "--camera", tmp_path / "camera.yml")) == 0
    np.testing.assert_allclose(np.load(photographs.out), expected, atol=0.01)


@pytest.mark.parametrize("direction", ["world-to-camera", "camera-to-world"])
@pytest.mark.parametrize("axes", ["opencv", "opengl"])
@pytest.mark.parametrize("world", ["z-down", "ned"])
def test_poses_of_any_convention_show_the_same(flight: Flight, direction: str, axes: str, world: str) -> None:
    expected = integral_of(flight)
    R_down2enu, R_other2enu = WORLDS["z-down"], WORLDS[world]
    for index, entry in enumerate(flight.document["images"]):
        pose = flight.pose(index)
        R_cam2world = (
            R_other2enu.T @ R_down2enu @ pose.R_cam2enu @ np.diag([1, 1, 1] if axes == "opencv" else [1, -1, -1])
        )
        centre = R_other2enu.T @ R_down2enu @ pose.position_enu_m
        rows = np.column_stack((R_cam2world, centre))
        if direction == "world-to-camera":
            rows = np.column_stack((R_cam2world.T, -R_cam2world.T @ centre))
        entry["M3x4"] = rows.tolist()
    flight.save()
    integral = integral_of(flight, convention=f"{direction}, {axes}, {world}", plane_z=-PLANE_Z)
    np.testing.assert_allclose(integral, expected, atol=1e-3)


def test_a_mesh_is_turned_with_the_poses(flight: Flight, tmp_path: Path) -> None:
    corners = [(-30, -30), (30, -30), (30, 30), (-30, 30)]
    lines = [f"v {x} {y} {PLANE_Z + 0.05 * x + 0.02 * y}" for x, y in corners]
    (tmp_path / "slope.obj").write_text("\n".join([*lines, "f 1 2 3", "f 1 3 4"]))
    expected = integral_of(flight, plane_z=None, dem=tmp_path / "slope.obj", dem_offset=1.0)
    integral = integral_of(flight, plane_z=None, dem=tmp_path / "slope.obj", dem_offset=-1.0, convention="z-down")
    np.testing.assert_allclose(integral, expected, atol=0.05)


def test_poses_with_z_down_can_be_placed_on_the_earth(flight: Flight) -> None:
    place = {"view": None, "size": None, "ortho": 0.5, "origin": "48.3,14.3", "out": flight.out.with_suffix(".tif")}
    assert exit_status(flight.arguments(**place)) == 2
    assert exit_status(flight.arguments(**place, convention="z-down", plane_z=-PLANE_Z)) == 0


def test_a_range_of_frames(flight: Flight) -> None:
    chosen = integral_of(flight, frames="1:4:2", view=0)
    flight.document["images"] = flight.document["images"][1:4:2]
    flight.save()
    np.testing.assert_array_equal(chosen, integral_of(flight, view=0))


def test_a_range_of_photographs(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    photographs = survey_flight.Photographs(tmp_path)
    photographs.strip("5.jpg", "GimbalPitchDegree")
    photographs.out = tmp_path / "map.npy"
    assert exit_status(photographs.arguments("--ortho", 0.5, "--frames", ":3")) == 0
    assert "skipped" not in capfd.readouterr().err
    assert exit_status(photographs.arguments("--ortho", 0.5, "--frames", "6:9")) == 2


BAD_FILES = {
    "no fields": ({"a": 1}, "neither 'camera_matrix'"),
    "no list": ([1, 2], "needs named fields"),
    "matrix": ({"camera_matrix": [[1, 2], [3, 4]]}, "'camera_matrix' must be three rows"),
    "matrix of text": ({"K": [["a"] * 3] * 3}, "'K' must be three rows"),
    "negative focal length": ({"K": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "'K' must be three rows"),
    "skew": ({"K": [[50, 3, 30], [0, 50, 30], [0, 0, 1]]}, "a skew of 3"),
    "size": ({"K": CAMERA.K.tolist(), "image_width": "wide", "image_height": 60}, "'image_width' must be a whole"),
    "half a size": ({"K": CAMERA.K.tolist(), "image_width": 60}, "'image_height' must be a whole"),
    "other shape": ({"K": CAMERA.K.tolist(), "width": 80, "height": 60}, "which is another shape"),
    "centre": ({"K": [[50, 0, 90], [0, 50, 30], [0, 0, 1]]}, r"principal point at \(90, 30\), outside"),
    "rational": ({"K": CAMERA.K.tolist(), "D": [0.1] * 8}, "'D' has 8 coefficients"),
    "few coefficients": ({"K": CAMERA.K.tolist(), "D": [0.1]}, "'D' of the camera file .* needs 4 to 5"),
    "model": ({"K": CAMERA.K.tolist(), "D": [0.1] * 4, "distortion_model": "omni"}, "'distortion_model' is 'omni'"),
    "fisheye": (
        {"K": CAMERA.K.tolist(), "D": [0.1] * 5, "distortion_model": "equidistant"},
        "'D' has 5 coefficients; of the model fisheye at most 4",
    ),
    "projection": ({"a": {"projection_type": "spherical"}}, "'projection_type' is 'spherical'"),
    "no edge": ({"a": {"projection_type": "brown", "focal_x": 1}}, "needs 'width' and 'height'"),
    "no focal": ({"a": {"projection_type": "brown", "width": 60, "height": 60}}, "'focal' must be a finite number"),
    "two cameras": ({name: {"projection_type": "brown", "width": 60, "height": 60} for name in "ab"}, "has 2 cameras"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_a_camera_file_that_cannot_be_used_is_refused(
    flight: Flight, tmp_path: Path, capfd: pytest.CaptureFixture[str], case: str
) -> None:
    content, expected = BAD_FILES[case]
    (tmp_path / "camera.json").write_text(json.dumps(content))
    assert exit_status(flight.arguments(fov=None, camera=tmp_path / "camera.json")) == 2
    errors = capfd.readouterr().err
    assert re.search(expected, errors)
    assert not flight.out.exists()


@pytest.mark.parametrize(
    "content",
    [b"", b"\x00\xff\xfe garbage", b"{", b"a: [", b"<?xml version='1.0'?><a>", b"{" * 100_000, b"x" * 2_000_000],
)
def test_a_file_that_is_no_camera_file_is_refused(
    flight: Flight, tmp_path: Path, capfd: pytest.CaptureFixture[str], content: bytes
) -> None:
    (tmp_path / "camera.yml").write_bytes(content)
    assert exit_status(flight.arguments(fov=None, camera=tmp_path / "camera.yml")) == 2
    assert "camera file" in capfd.readouterr().err
