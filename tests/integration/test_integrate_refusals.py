"""Refusals of ``aos-gcs integrate``: bad input is named and nothing is written."""

import json
import math
import os
import re
import struct
from collections.abc import Callable, Mapping
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.imaging.surfaces import mesh
from aos_gcs.surveys import poses_file
from tests.fakes.command_line import exit_status
from tests.fakes.recorded_flight import Flight


@pytest.fixture(autouse=True)
def _coarse_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plain slopes need no grid of millions of heights, nor endless files as many bytes."""
    monkeypatch.setattr(poses_file, "MAX_FILE_BYTES", 1_000_000)
    monkeypatch.setattr(mesh, "DEFAULT_SAMPLES", 40_000)


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


Change = Callable[[Flight], dict[str, object]]


def remove_images(flight: Flight) -> dict[str, object]:
    for path in flight.images.iterdir():
        path.unlink()
    flight.images.rmdir()
    return {}


def truncate_image(flight: Flight) -> dict[str, object]:
    path = flight.images / "2.png"
    path.write_bytes(path.read_bytes()[:-200])
    return {}


def truncate_jpeg(flight: Flight) -> dict[str, object]:
    image = cv2.imread(str(flight.images / "2.png"))
    content = cv2.imencode(".jpg", image)[1].tobytes()
    (flight.images / "2.png").write_bytes(content[: len(content) // 2])
    return {}


def write_image(content: bytes) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        (flight.images / "2.png").write_bytes(content)
        return {}

    return change


def make_pipe(flight: Flight) -> dict[str, object]:
    path = flight.images / "2.png"
    path.unlink()
    os.mkfifo(path)
    return {}


def output_over_image(flight: Flight) -> dict[str, object]:
    return {"png": flight.images / "2.png"}


def mix_sizes(flight: Flight) -> dict[str, object]:
    cv2.imwrite(str(flight.images / "2.png"), np.zeros((50, 60), dtype=np.uint8))
    return {}


def write_poses(text: str) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        flight.poses.write_text(text)
        return {}

    return change


def change_entry(**fields: object) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        flight.document["images"][2].update(fields)
        flight.save()
        return {}

    return change


def drop_matrix(flight: Flight) -> dict[str, object]:
    del flight.document["images"][2]["M3x4"]
    flight.save()
    return {}


def set_number(row: int, column: int, value: object) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        flight.document["images"][2]["M3x4"][row][column] = value
        flight.save()
        return {}

    return change


def mirror(flight: Flight) -> dict[str, object]:
    rows = flight.document["images"][2]["M3x4"]
    rows[0] = [-float(value) for value in rows[0]]
    flight.save()
    return {}


def with_field(field: str, value: object, others: Mapping[str, object] | None = None, **values: object) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        flight.poses.write_text(json.dumps({**flight.document, **(others or {}), field: value}))
        return values

    return change


def options(**values: object) -> Change:
    return lambda _: values


def output_in_absent_folder(flight: Flight) -> dict[str, object]:
    return {"out": flight.out.parent / "absent" / "integral.npy"}


def output_over_folder(flight: Flight) -> dict[str, object]:
    return {"out": flight.images}


def same_outputs(flight: Flight) -> dict[str, object]:
    return {"count": flight.out}


def dem_file(name: str, content: str = "") -> Change:
    def change(flight: Flight) -> dict[str, object]:
        path = flight.out.parent / name
        path.write_text(content)
        return {"plane_z": None, "dem": path}

    return change


def dem_far_away(flight: Flight) -> dict[str, object]:
    return dem_file("far.obj", "v 500 500 12\nv 510 500 12\nv 500 510 12\nf 1 2 3\n")(flight)


def map_of_dem_far_away(flight: Flight) -> dict[str, object]:
    return dem_far_away(flight) | {"view": None, "size": None, "ortho": 0.1}


def geotiff(flight: Flight, crs: str | None) -> Path:
    rasterio = pytest.importorskip("rasterio", reason="rasterio (the extra 'geo') is not installed")
    path = flight.out.parent / "dem.tif"
    transform = rasterio.Affine(1e-4, 0.0, 14.0, 0.0, -1e-4, 48.0)
    with rasterio.open(
        path, "w", driver="GTiff", width=4, height=4, count=1, dtype="float32", transform=transform, crs=crs
    ) as dataset:
        dataset.write(np.zeros((4, 4), dtype=np.float32), 1)
    return path


def no_geotiff(flight: Flight) -> dict[str, object]:
    path = geotiff(flight, None)
    path.write_text("text")
    return {"plane_z": None, "dem": path}


def geotiff_in_degrees(flight: Flight) -> dict[str, object]:
    return {"plane_z": None, "dem": geotiff(flight, "EPSG:4326")}


def geotiff_without_system(flight: Flight) -> dict[str, object]:
    turn_z_up(flight)
    return {"plane_z": None, "dem": geotiff(flight, None), "origin": "48,14,0"}


def turn_z_up(flight: Flight) -> None:
    """Have the cameras look along -z."""
    for entry in flight.document["images"]:
        entry["M3x4"] = (np.diag([1.0, -1.0, -1.0]) @ np.array(entry["M3x4"], dtype=float)).tolist()
    flight.save()


def name_again(flight: Flight) -> dict[str, object]:
    flight.document["images"] += [flight.document["images"][1]] * 2
    flight.save()
    return {}


def name_in_two_ways(flight: Flight) -> dict[str, object]:
    flight.document["images"].append({**flight.document["images"][1], "imagefile": "1.tiff"})
    flight.save()
    return {}


def name_of_two_files(flight: Flight) -> dict[str, object]:
    cv2.imwrite(str(flight.images / "2.tiff"), np.zeros((60, 60), dtype=np.uint8))
    return change_entry(imagefile="2.jpg")(flight)


def deeper_image(flight: Flight) -> dict[str, object]:
    cv2.imwrite(str(flight.images / "2.png"), np.zeros((60, 60), dtype=np.uint16))
    return {}


def image_of(dtype: str, value: float) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        content = cv2.imencode(".tiff", np.full((60, 60), value, dtype=dtype))[1].tobytes()
        (flight.images / "2.png").write_bytes(content)
        return {}

    return change


def claim_size(flight: Flight) -> dict[str, object]:
    path = flight.images / "2.png"
    content = bytearray(path.read_bytes())
    content[16:24] = struct.pack(">II", 200_000, 200_000)
    path.write_bytes(content)
    return {}


def look_up(flight: Flight) -> dict[str, object]:
    turn_z_up(flight)
    return {"view": None, "size": None, "ortho": 0.1}


BAD_INPUT = {
    "no surface": (options(plane_z=None), "Give the focal plane as --plane-z"),
    "dem and plane": (options(dem="dem.obj"), "--dem and --plane-z exclude each other"),
    "dem and tilt": (options(plane_z=None, dem="dem.obj", tilt="1,1"), "--dem and --tilt exclude each other"),
    "dem and focus tilt": (
        options(plane_z=None, dem="a.obj", autofocus="1,2", focus_tilt=True),
        "--dem and --focus-tilt exclude",
    ),
    "focus stack without a range": (options(focus_stack="stack.png"), "--focus-stack requires the range"),
    "focus stack of no picture": (
        options(plane_z=None, autofocus="1,2", focus_stack="stack.tif"),
        "--focus-stack must name a .png file",
    ),
    "offset without dem": (options(dem_offset=1), "--dem-offset requires --dem"),
    "offset not finite": (options(plane_z=None, dem="a.obj", dem_offset="nan"), "--dem-offset must be a finite"),
    "origin incomplete": (options(plane_z=None, dem="a.tif", origin="48"), "--origin needs LATITUDE"),
    "origin off the globe": (options(plane_z=None, dem="a.tif", origin="148,14,0"), "--origin needs LATITUDE"),
    "dem absent": (options(plane_z=None, dem="/absent/dem.obj"), r"terrain /absent/dem\.obj does not exist"),
    "dem of no kind": (dem_file("dem.xyz"), r"dem\.xyz is of no known kind"),
    "dem broken": (dem_file("dem.obj", "v 1 2\nf 1 1 1\n"), r"dem\.obj is not a mesh"),
    "dem no geotiff": (no_geotiff, r"dem\.tif cannot be read"),
    "dem far away": (dem_far_away, "sees nothing of the terrain"),
    "map of dem far away": (map_of_dem_far_away, "No image sees the terrain"),
    "dem in degrees": (geotiff_in_degrees, r"dem\.tif is in degrees \(EPSG:4326\)"),
    "dem without system": (geotiff_without_system, r"dem\.tif has no coordinate system"),
    "tilt of one angle": (options(tilt="3"), "--tilt needs two angles NORTH_DEG,EAST_DEG"),
    "tilt too steep": (options(tilt="3,61"), "--tilt needs two angles"),
    "neither view nor map": (options(view=None), "Give the virtual camera as --view INDEX"),
    "view and map": (options(ortho=0.1, size=None), "--ortho and --view exclude each other"),
    "size and map": (options(ortho=0.1, view=None), "--ortho and --size exclude each other"),
    "map not positive": (options(ortho=0, view=None, size=None), "--ortho must be a positive number"),
    "map and autofocus": (
        options(ortho=0.1, view=None, size=None, plane_z=None, autofocus="1,20"),
        "--autofocus of a map needs the place to focus on: --focus-region",
    ),
    "map too fine": (options(ortho=1e-4, view=None, size=None), "choose a coarser resolution"),
    "map of the sky": (look_up, "No image has the focal surface in front of its camera"),
    "missing folder": (remove_images, r"image folder .*images does not exist"),
    "missing poses": (options(poses="/absent/poses.json"), r"poses file /absent/poses\.json cannot be read"),
    "truncated png": (truncate_image, r"2\.png is incomplete"),
    "truncated jpeg": (truncate_jpeg, r"2\.png is incomplete"),
    "no image": (write_image(b"not an image"), r"2\.png is not an image"),
    "empty image": (write_image(b""), r"2\.png is empty"),
    "size of a bomb": (claim_size, r"2\.png claims 40,000\.0 megapixels; at most 250 are read"),
    "mixed depths": (deeper_image, r"2\.png has 16-bit values, but the recording has 8-bit ones"),
    "depth of its own": (image_of("float64", 1.0), r"2\.png is not an image of 8, 16 or 32 bit"),
    "values not finite": (image_of("float32", math.nan), r"2\.png has values that are not finite numbers"),
    "named again": (name_again, r"images\[4\] names the image 1\.png again: each image counts once"),
    "named in two ways": (name_in_two_ways, r"names the image 1\.png 2 times"),
    "name of two files": (name_of_two_files, r"names the image 2\.jpg, but .*images has 2\.png, 2\.tiff: which one"),
    "nested poses": (write_poses("[" * 100_000 + "]" * 100_000), "is nested too deeply"),
    "own origin off the globe": (
        with_field("origin", [148, 14, 0]),
        r"'origin' must be \[latitude, longitude, altitude\]",
    ),
    "own origin incomplete": (
        with_field("origin", [48, "14", 0]),
        r"'origin' must be \[latitude, longitude, altitude\]",
    ),
    "origin in space by option": (options(origin="48,14,1e300"), "--origin needs LATITUDE,LONGITUDE"),
    "own origin of z down": (with_field("origin", [48, 14, 0]), r"The cameras look along \+z"),
    "origin of z down": (options(origin="48,14,0"), r"The cameras look along \+z"),
    "image absent": (change_entry(imagefile="gone.png"), r"images\[2\] names the image gone\.png, which is not in"),
    "no image name": (change_entry(imagefile=None), r"images\[2\]: 'imagefile' must name"),
    "mixed sizes": (mix_sizes, r"2\.png has 60 x 50 pixels and 1 channel, but 60 x 60 pixels and 1"),
    "invalid json": (write_poses('{"images": ['), "is not valid JSON"),
    "json of something else": (write_poses("[1, 2]"), "needs a non-empty list 'images'"),
    "no images": (write_poses('{"images": []}'), "needs a non-empty list 'images'"),
    "no matrix": (drop_matrix, r"images\[2\] \(2\.png\): 'M3x4' must be three rows"),
    "wrong shape": (change_entry(M3x4=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]), "'M3x4' must be three rows of four"),
    "text for a number": (set_number(1, 3, "north"), "'north', which is not a finite number"),
    "truth for a number": (set_number(1, 3, True), "True, which is not a finite number"),
    "nan": (set_number(1, 3, float("nan")), "nan, which is not a finite number"),
    "endless number": (set_number(1, 3, 10**400), "'M3x4' contains 1000.*, which is not a finite number"),
    "endless time": (change_entry(time_s=10**400), "'time_s' must be a finite number"),
    "width alone": (with_field("width", 96, {"fx": 60}, fov=None), "has one of 'width' and 'height'"),
    "endless fx": (with_field("fx", 10**400, fov=None), "'fx' must be a positive number of pixels"),
    "endless lens": (with_field("lens", [10**400, 0, 0, 0]), "needs 4 to 5 finite coefficients"),
    "endless origin": (with_field("origin", [48, 14, 10**400]), r"'origin' must be \[latitude, longitude, altitude\]"),
    "origin in space": (with_field("origin", [48, 14, 1e300]), r"'origin' must be \[latitude, longitude, altitude\]"),
    "pose in space": (set_number(1, 3, 1e300), r"images\[2\] \(2\.png\): 'M3x4' moves the world by 1e\+300 m"),
    "pose far away": (
        set_number(1, 3, 1e6),
        r"poses\.json: the image 2\.png lies 1,000 km from the middle of the flight",
    ),
    "endless name": (change_entry(imagefile="a" * 5000), r"images\[2\] names the image 'aaa.*: File name too long"),
    "name of controls": (change_entry(imagefile="\x1b[31m.png"), r"names the image \\x1b\[31m\.png, which is not in"),
    "name of half a character": (change_entry(imagefile="\ud800.png"), r"names the image \\ud800\.png, which is not"),
    "pipe": (make_pipe, r"names the image 2\.png, which is not in"),
    "poses without end": (options(poses="/dev/zero"), "The poses file /dev/zero has more than 1 MB"),
    "output over an image": (output_over_image, r"Cannot write .*2\.png: it is a file of the recording"),
    "time of words": (change_entry(time_s="noon"), r"images\[2\] \(2\.png\): 'time_s' must be a finite number"),
    "no rotation": (set_number(1, 1, 2.0), r"images\[2\] \(2\.png\): the left 3x3 part of 'M3x4' is not a rotation"),
    "mirrored": (mirror, "is not a rotation"),
    "view too large": (options(view=4), r"--view 4 is out of range: .* has the views 0 to 3"),
    "view negative": (options(view=-1), "--view -1 is out of range"),
    "no fov": (options(fov=None), r"The poses file .*poses\.json does not describe the camera: give the field of view"),
    "fov and camera": (options(camera="camera.yml"), "--camera and --fov exclude each other"),
    "camera file absent": (options(fov=None, camera="absent.yml"), "The camera file absent.yml cannot be read"),
    "fx in the file": (with_field("fx", "wide", fov=None), "'fx' must be a positive number of pixels, got 'wide'"),
    "convention": (options(convention="upside-down"), "--convention does not know 'upside-down': use world-to-camera"),
    "two conventions": (options(convention="ned,z-down"), "--convention: ned and z-down exclude each other"),
    "cameras look up": (
        options(convention="enu"),
        "With the convention world-to-camera,opencv,enu most cameras look up",
    ),
    "frames": (options(frames="2"), r"--frames needs a range A:B\[:STEP\] of images counted from 0, got '2'"),
    "frames of words": (options(frames="a:b"), "--frames needs a range"),
    "frames without a step": (options(frames="0:3:0"), "--frames needs a range"),
    "frames backwards": (options(frames="3:1"), "--frames needs a range"),
    "frames beyond": (options(frames="4:"), r"beyond the 4 images of .*poses\.json: it must begin before 4"),
    "frames partly beyond": (options(frames="0:99"), r"beyond the 4 images of .*poses\.json: .* at 4 at the latest"),
    "ground of poses": (options(ground=300), "--ground applies to photographs"),
    "lens in the file": (
        with_field("lens", [0.1, 0.2]),
        r"'lens' of the poses file .* needs 4 to 5 finite coefficients",
    ),
    "fisheye in the file": (with_field("fisheye", 0.1), r"'fisheye' of the poses file .* needs 4 finite coefficients"),
    "fov zero": (options(fov=0), "--fov must lie between 0.1 and 170 degrees, got 0"),
    "fov too wide": (options(fov=180), "--fov must lie between"),
    "size": (options(size=0), "--size must lie between 1 and"),
    "plane not finite": (options(plane_z="nan"), "--plane-z must lie between"),
    "plane behind": (options(plane_z=-20), r"z = -20 m lies behind the virtual camera at z = -10\.0 m"),
    "plane through the camera": (options(plane_z=-10), "passes through the virtual camera"),
    "absent output folder": (output_in_absent_folder, r"Cannot write .*absent/integral\.npy: the folder"),
    "output is a folder": (output_over_folder, "it is a folder"),
    "outputs collide": (same_outputs, "must name different files"),
}


@pytest.mark.parametrize(("change", "message"), BAD_INPUT.values(), ids=BAD_INPUT.keys())
def test_bad_input_is_named_and_writes_nothing(
    flight: Flight, change: Change, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(flight.arguments(**change(flight))) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert re.match(r"aos-gcs: .*" + message, captured.err), captured.err
    assert not flight.out.exists()
