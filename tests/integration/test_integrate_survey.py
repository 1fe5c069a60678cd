"""``aos-gcs integrate`` on geotagged photographs: from their tags to georeferenced maps and tables."""

import csv
import json
import math
import re
import socket
from pathlib import Path

import cv2
import numpy as np
import pymap3d
import pytest
import rasterio
from numpy.typing import NDArray
from rasterio.warp import transform

from aos_gcs.cluster import MAX_JOBS
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.surveys.photos import read_photos
from tests.fakes.command_line import exit_status
from tests.fakes.program import unused_port
from tests.fakes.survey_flight import CAMERA, FOCAL_PX, HEIGHT_M, HOT_M, SIZE, TAKEOFF, Photographs, render, texture


@pytest.fixture
def photographs(tmp_path: Path) -> Photographs:
    return Photographs(tmp_path)


def error_of_map(path: Path) -> NDArray[np.float64]:
    """Return how far a map is from the texture, at the latitude and longitude that others read from it."""
    with rasterio.open(path) as dataset:
        values = dataset.read(1)
        rows, columns = np.nonzero(np.isfinite(values))
        x, y = rasterio.transform.xy(dataset.transform, rows, columns)
        longitude, latitude = transform(dataset.crs, "EPSG:4326", x, y)
    at = (TAKEOFF.latitude_deg, TAKEOFF.longitude_deg, TAKEOFF.altitude_amsl_m)
    east_m, north_m, _ = pymap3d.geodetic2enu(np.array(latitude), np.array(longitude), at[2], *at)
    return np.abs(values[rows, columns] - texture(east_m, north_m))


@pytest.mark.parametrize("options", [(), ("--exact",), ("--median",), ("--trim", 0.2)])
def test_a_map_of_photographs_shows_the_ground_in_its_place(photographs: Photographs, options: tuple[str, ...]) -> None:
    assert exit_status(photographs.arguments("--ortho", 0.2, *options)) == 0
    error = error_of_map(photographs.out)
    assert error.size > 5000
    assert error.mean() < 1.0
    assert np.percentile(error, 99) < 3.0


def test_a_view_of_photographs(photographs: Photographs, tmp_path: Path) -> None:
    out = tmp_path / "view.npy"
    assert exit_status(photographs.arguments("--view", 2, "--size", 50, "--plane-z", 0, "--out", out)) == 0
    camera = CameraModel.from_fov(50, 50, CAMERA.horizontal_fov_rad)
    position = LocalFrame(TAKEOFF).to_geodetic([8.0, 0.0, HEIGHT_M])
    pose = nadir_pose(LocalFrame(TAKEOFF).to_enu(position), math.radians(50.0))
    assert np.nanmean(np.abs(np.load(out) - render(pose, camera))) < 1.5


def test_ground_below_the_place_of_takeoff(photographs: Photographs) -> None:
    origin = read_photos(photographs.images, ground_amsl_m=300.0).origin
    assert origin is not None
    assert origin.altitude_amsl_m == 300.0
    survey = read_photos(photographs.images, ground_amsl_m=300.0)
    assert survey.images[0].pose.position_enu_m == pytest.approx([0.0, 0.0, 30.0], abs=1e-3)


def test_photographs_that_cannot_be_used_are_counted(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    photographs.strip("1.jpg", "GimbalPitchDegree")
    photographs.strip("3.jpg", "GpsLatitude")
    (photographs.images / "5.jpg").write_bytes(b"")
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    errors = capfd.readouterr().err
    assert "3 of 6 images are skipped; 1.jpg: it has no GimbalYawDegree and GimbalPitchDegree" in errors
    assert error_of_map(photographs.out).mean() < 1.0


def test_a_lens_is_taken_out(tmp_path: Path) -> None:
    lens = LensDistortion(LensModel.BROWN_CONRADY, (-0.2, 0.03, 0.001, -0.001, 0.0))
    distorted = CameraModel(*SIZE, FOCAL_PX, FOCAL_PX, CAMERA.cx_px, CAMERA.cy_px, lens)
    photographs = Photographs(tmp_path, camera=distorted)
    assert exit_status(photographs.arguments("--ortho", 0.2)) == 0
    ideal_error = error_of_map(photographs.out).mean()
    assert exit_status(photographs.arguments("--ortho", 0.2, "--lens", "-0.2,0.03,0.001,-0.001")) == 0
    assert error_of_map(photographs.out).mean() < min(1.0, ideal_error / 2)


def test_a_fisheye_in_the_poses_file(tmp_path: Path) -> None:
    lens = LensDistortion(LensModel.FISHEYE, (-0.02, 0.01, 0.0, 0.0))
    camera = CameraModel(*SIZE, FOCAL_PX, FOCAL_PX, CAMERA.cx_px, CAMERA.cy_px, lens)
    images = tmp_path / "images"
    images.mkdir()
    entries = []
    for index in range(3):
        pose = nadir_pose([2.0 * index, 0.0, HEIGHT_M], 0.3 * index)
        cv2.imwrite(str(images / f"{index}.png"), render(pose, camera))
        R = pose.R_cam2enu.T
        entries.append({"imagefile": f"{index}.png", "M3x4": np.column_stack((R, -R @ pose.position_enu_m)).tolist()})
    poses, out = tmp_path / "poses.json", tmp_path / "map.tif"
    poses.write_text(json.dumps({"images": entries, "fisheye": [-0.02, 0.01, 0.0, 0.0]}))
    fov_deg = math.degrees(CAMERA.horizontal_fov_rad)
    place = f"{TAKEOFF.latitude_deg},{TAKEOFF.longitude_deg},{TAKEOFF.altitude_amsl_m}"
    options = ["--poses", poses, "--fov", fov_deg, "--plane-z", 0, "--ortho", 0.2, "--origin", place, "--out", out]
    assert exit_status(["integrate", str(images), *map(str, options)]) == 0
    assert error_of_map(out).mean() < 1.0


def test_anomalies_are_counted_drawn_and_listed(tmp_path: Path) -> None:
    photographs = Photographs(tmp_path, hot=True)
    files = [tmp_path / name for name in ("count.tif", "heat.png", "anomalies.geojson", "covered.tif")]
    outputs = ("--anomaly", files[0], "--anomaly", files[1], "--blobs", files[2], "--count", files[3])
    assert exit_status(photographs.arguments("--ortho", 0.1, *outputs)) == 0
    with rasterio.open(files[0]) as counts, rasterio.open(files[3]) as covered:
        assert counts.descriptions == ("significance",)
        assert counts.read(1).shape == covered.read(1).shape
        assert not counts.read(1)[covered.read(1) < 2].any()
        assert counts.read(1).max() > 6.0
    assert cv2.imread(str(files[1]), cv2.IMREAD_UNCHANGED).shape[2] == 4
    assert (tmp_path / "heat.pgw").is_file()
    first = json.loads(files[2].read_text())["features"][0]
    longitude, latitude = first["geometry"]["coordinates"]
    at = (TAKEOFF.latitude_deg, TAKEOFF.longitude_deg, TAKEOFF.altitude_amsl_m)
    east_m, north_m, _ = pymap3d.geodetic2enu(latitude, longitude, at[2], *at)
    assert (east_m, north_m) == pytest.approx(HOT_M, abs=0.2)
    assert first["properties"]["max_count"] >= 3
    assert first["properties"]["significance"] > 6.0


def test_rows_have_pictures_beside_the_table(tmp_path: Path) -> None:
    photographs = Photographs(tmp_path, hot=True)
    table, folder = tmp_path / "anomalies.json", tmp_path / "rows"
    assert exit_status(photographs.arguments("--ortho", 0.1, "--blobs", table, "--thumbnails", folder)) == 0
    rows = json.loads(table.read_text())["anomalies"]
    assert [row["thumbnail"] for row in rows] == [f"rows/{number:03}.png" for number in range(1, len(rows) + 1)]
    assert [row["significance"] for row in rows] == sorted((row["significance"] for row in rows), reverse=True)
    map_part, significant = np.hsplit(cv2.imread(str(tmp_path / rows[0]["thumbnail"])), 2)
    height, width = map_part.shape[:2]
    assert map_part[height // 2, width // 2].mean() > map_part.mean() + 50
    assert significant[height // 2, width // 2].max() > 100
    assert significant[: height // 4].max() < 50


@pytest.mark.parametrize("detector", ["rx", "local_rx", "thermal"])
def test_every_detector_finds_the_hot_spot(tmp_path: Path, detector: str) -> None:
    photographs = Photographs(tmp_path, hot=True)
    table = tmp_path / "anomalies.csv"
    assert exit_status(photographs.arguments("--ortho", 0.1, "--blobs", table, "--detector", detector)) == 0
    row = next(csv.DictReader(table.read_text().splitlines()))
    assert (float(row["x_m"]), float(row["y_m"])) == pytest.approx(HOT_M, abs=0.2)


def test_autofocus_on_a_region_of_a_map(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "images"
    folder.mkdir()
    camera = CameraModel.from_fov(160, 160, math.radians(50.0))
    rng = np.random.default_rng(0)
    ground = cv2.GaussianBlur(rng.uniform(0.0, 255.0, (600, 600)).astype(np.float32), (0, 0), 3.0)
    ground = cv2.normalize(ground, None, 0.0, 255.0, cv2.NORM_MINMAX)
    entries = []
    for index in range(6):
        pose = nadir_pose([1.6 * (index - 2.5), 0.8 * (index % 2), 25.0])
        u, v = np.meshgrid(np.arange(160), np.arange(160))
        x, y, _ = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, 3.0).T
        maps = [(12.0 * axis + 300.0).reshape(160, 160).astype(np.float32) for axis in (x, y)]
        cv2.imwrite(str(folder / f"{index}.png"), cv2.remap(ground, *maps, cv2.INTER_LINEAR).astype(np.uint8))
        R = pose.R_cam2enu.T
        entries.append({"imagefile": f"{index}.png", "M3x4": np.column_stack((R, -R @ pose.position_enu_m)).tolist()})
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    options = ("--poses", poses, "--fov", 50, "--ortho", 0.1, "--out", tmp_path / "map.npy")
    focus = ("--autofocus", "-4,10", "--focus-region", "-4,-4,4,4", "--focus-tilt")
    assert exit_status(["integrate", str(folder), *map(str, (*options, *focus))]) == 0
    errors = capfd.readouterr().err
    assert "autofocus: z = 3." in errors or "autofocus: z = 2.9" in errors
    assert "° along y" in errors


def unreachable() -> str:
    return f"tcp://127.0.0.1:{unused_port(socket.SOCK_STREAM)}"


BAD_OPTIONS: dict[str, tuple[tuple[object, ...], str]] = {
    "view as GeoTIFF": (("--view", 0), r"Cannot write .*map\.tif: a view has no place on a map"),
    "suffix": (("--ortho", 1, "--count", "c.jpg"), r"--count c\.jpg: the name must end in \.npy or \.tif"),
    "table of a view": (("--view", 0, "--out", "v.npy", "--blobs", "b.csv"), "--blobs lists the anomalies of a map"),
    "median and trim": (("--ortho", 1, "--median", "--trim", 0.1), "--median and --trim exclude each other"),
    "rate": (("--ortho", 1, "--false-alarms-per-ha", 0), "--false-alarms-per-ha must lie between 0 and 20000"),
    "pictures of no table": (("--ortho", 1, "--thumbnails", "rows"), "--thumbnails shows the rows of a table"),
    "trim": (("--ortho", 1, "--trim", 0.6), "--trim must lie between 0 and 0.5"),
    "memory": (("--ortho", 1, "--max-memory", 1), "--max-memory must be at least 50 MB"),
    "jobs": (("--ortho", 1, "--jobs", 0), f"--jobs must lie within 1 and {MAX_JOBS}"),
    "too many jobs": (("--ortho", 1, "--jobs", 100000), f"--jobs must lie within 1 and {MAX_JOBS}"),
    "jobs of a view": (("--view", 0, "--out", "v.npy", "--jobs", 2), "--jobs divides the tiles of a map"),
    "jobs and scheduler": (("--ortho", 1, "--jobs", 1, "--scheduler", "tcp://h:1"), "--jobs and --scheduler exclude"),
    "scheduler": (("--ortho", 1, "--scheduler", unreachable()), r"scheduler tcp://127\.0\.0\.1:\d+ cannot be reached"),
    "no address": (("--ortho", 1, "--scheduler", "nonsense://x"), "scheduler nonsense://x cannot be reached"),
    "lens": (("--ortho", 1, "--lens", "0.1,0.2"), "--lens needs 4 to 5 finite coefficients"),
    "lens of text": (("--ortho", 1, "--lens", "a,b,c,d"), "--lens needs 4 to 5 finite coefficients"),
    "fisheye": (("--ortho", 1, "--fisheye", "1,2,3,4,5"), "--fisheye needs 4 finite coefficients"),
    "lens and fisheye": (("--ortho", 1, "--lens", "0,0,0,0", "--fisheye", "0,0,0,0"), "--lens and --fisheye exclude"),
    "origin": (("--ortho", 1, "--origin", "48,14"), "photographs have positions in their metadata"),
    "ground": (("--ortho", 1, "--ground", "nan"), "--ground must lie between -20,000 and 20,000 m"),
    "endless ground": (("--ortho", 1, "--ground", "1e308"), "--ground must lie between -20,000 and 20,000 m"),
    "picture": (("--ortho", 1, "--png", "map.jpg"), r"--png map\.jpg: the name must end in \.png"),
    "score of nothing": (("--ortho", 1, "--min-score", 5), "--min-score is for anomalies: request them with --anomaly"),
    "degrees twice": (("--ortho", 1, "--degrees", "air=1,air=2"), "--degrees gives air twice: leave one out"),
    "ground above": (("--ortho", 1, "--ground", 900), "No image has the focal surface in front of its camera"),
    "region": (("--ortho", 1, "--plane-z", 0, "--focus-region", "0,0,1,1"), "--focus-region requires --autofocus"),
    "region of no area": (
        ("--ortho", 1, "--autofocus", "-5,5", "--focus-region", "0,0,0,1"),
        "--focus-region needs X0,",
    ),
    "tilts": (
        ("--ortho", 1, "--autofocus", "-5,5", "--focus-tilt", "--tilt", "1,1"),
        "--tilt and --focus-tilt exclude each other",
    ),
}


@pytest.mark.parametrize(("options", "message"), BAD_OPTIONS.values(), ids=BAD_OPTIONS.keys())
def test_bad_options_are_named_and_write_nothing(
    photographs: Photographs,
    options: tuple[object, ...],
    message: str,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("aos_gcs.cluster.CONNECT_TIMEOUT_S", 0.5)
    before = sorted(photographs.out.parent.iterdir())
    assert exit_status(photographs.arguments(*options)) == 2
    errors = capfd.readouterr().err
    assert len(errors.splitlines()) == 1
    assert errors.startswith("aos-gcs: ")
    assert_found(message, errors)
    assert sorted(photographs.out.parent.iterdir()) == before


@pytest.mark.parametrize(
    ("tag", "reason"),
    [
        ("GpsLongitude", "it has no GPSLatitude and GPSLongitude"),
        ("GimbalPitchDegree", "it has no GimbalYawDegree and GimbalPitchDegree"),
        ("RelativeAltitude", r"it has no RelativeAltitude; give the altitude of the ground \(--ground\)"),
    ],
)
def test_a_tag_that_all_photographs_lack_is_named(
    photographs: Photographs, tag: str, reason: str, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in list(photographs.tags):
        photographs.strip(name, tag)
    assert exit_status(photographs.arguments("--ortho", 1)) == 2
    assert_found(rf"None of the 6 photographs in .* can be used; 0\.jpg: {reason}", capfd.readouterr().err)


def test_a_folder_without_photographs(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert exit_status(["integrate", str(tmp_path), "--ortho", "1", "--out", str(tmp_path / "map.npy")]) == 2
    assert (
        "has no photographs (.jpg, .jpeg, .tif, .tiff); for other images give their --poses" in capfd.readouterr().err
    )


def test_tiff_files_without_tags_need_poses(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    cv2.imwrite(str(tmp_path / "0.tif"), np.zeros((8, 8), np.uint8))
    assert exit_status(["integrate", str(tmp_path), "--ortho", "1", "--out", str(tmp_path / "map.npy")]) == 2
    assert_found(r"0\.tif: it has no GPSLatitude.*; images without tags need --poses", capfd.readouterr().err)


def test_a_map_whose_place_is_not_known_is_no_geotiff(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    poses = tmp_path / "poses.json"
    rows = np.column_stack((np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, HEIGHT_M])).tolist()
    poses.write_text(json.dumps({"images": [{"imagefile": "0.jpg", "M3x4": rows}]}))
    options = ("--poses", poses, "--fov", 60, "--plane-z", 0, "--ortho", 1)
    assert exit_status(photographs.arguments(*options)) == 2
    assert "where the map lies on the earth is not known. Give the place" in capfd.readouterr().err
    assert exit_status(photographs.arguments(*options, "--origin", "48.3,14.3")) == 0
    with rasterio.open(photographs.out) as dataset:
        assert dataset.crs.to_dict()["lat_0"] == 48.3


def test_a_world_that_looks_along_z_has_no_place(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    poses = tmp_path / "poses.json"
    rows = np.column_stack((np.eye(3), [0.0, 0.0, HEIGHT_M])).tolist()
    poses.write_text(json.dumps({"images": [{"imagefile": "0.jpg", "M3x4": rows}]}))
    options = ("--poses", poses, "--fov", 60, "--plane-z", 0, "--ortho", 1, "--origin", "48.3,14.3")
    assert exit_status(photographs.arguments(*options)) == 2
    assert "only a world of x east, y north, z up can be placed on the earth" in capfd.readouterr().err
    assert not photographs.out.exists()


def test_a_map_in_the_coordinates_of_its_terrain(photographs: Photographs, tmp_path: Path) -> None:
    dem = tmp_path / "dem.tif"
    east_m, north_m = 450_000.0, 5_350_000.0
    with rasterio.open(
        dem, "w", driver="GTiff", width=60, height=60, count=1, dtype="float32", crs="EPSG:32633",
        transform=rasterio.Affine(1.0, 0.0, east_m - 30.0, 0.0, -1.0, north_m + 30.0),
    ) as dataset:  # fmt: skip
        dataset.write(np.full((60, 60), 5.0, dtype=np.float32), 1)
    R = np.diag([1.0, -1.0, -1.0])
    rows = np.column_stack((R, -R @ [east_m, north_m, 5.0 + HEIGHT_M])).tolist()
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": [{"imagefile": "0.jpg", "M3x4": rows}]}))
    assert exit_status(photographs.arguments("--poses", poses, "--fov", 50, "--dem", dem, "--ortho", 0.5)) == 0
    with rasterio.open(photographs.out) as dataset:
        assert dataset.crs.to_epsg() == 32633
        centre = (np.array(dataset.bounds[:2]) + np.array(dataset.bounds[2:])) / 2
    assert centre == pytest.approx([east_m, north_m], abs=0.5)


def test_pictures_of_large_maps_are_refused_before_the_work(
    photographs: Photographs,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("aos_gcs.cli.result_options.MAX_PICTURE_CELLS", 1000)
    assert exit_status(photographs.arguments("--ortho", 0.2, "--png", tmp_path / "map.png")) == 2
    assert_found(r"Cannot write .*map\.png: a picture of \d+ x \d+ pixels is too large", capfd.readouterr().err)
    assert not photographs.out.exists()


def test_broken_images_are_left_out_when_asked(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    images = tmp_path / "images"
    images.mkdir()
    entries = []
    for index in range(4):
        pose = nadir_pose([2.0 * index, 0.0, HEIGHT_M])
        cv2.imwrite(str(images / f"{index}.png"), render(pose, CAMERA))
        R = pose.R_cam2enu.T
        entries.append({"imagefile": f"{index}.png", "M3x4": np.column_stack((R, -R @ pose.position_enu_m)).tolist()})
    (images / "0.png").write_bytes((images / "0.png").read_bytes()[:-300])
    cv2.imwrite(str(images / "2.png"), np.zeros((50, 60), dtype=np.uint8))
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    out = tmp_path / "map.npy"
    fov_deg = math.degrees(CAMERA.horizontal_fov_rad)
    arguments = ["integrate", str(images), "--poses", str(poses), "--fov", str(fov_deg), "--plane-z", "0"]
    arguments += ["--ortho", "0.2", "--out", str(out)]
    assert exit_status(arguments) == 2
    assert_found(r"0\.png is incomplete", capfd.readouterr().err)
    assert not out.exists()
    assert exit_status([*arguments, "--skip-broken"]) == 0
    errors = capfd.readouterr().err
    assert_found(r"1 of 4 images are skipped; 0\.png: The image .* is incomplete", errors)
    assert_found(r"1 of 3 images are skipped; 2\.png: The image .* has 60 x 50 pixels", errors)
    for path in images.iterdir():
        path.write_bytes(b"")
    assert exit_status([*arguments, "--skip-broken"]) == 2
    assert_found(r"None of the 4 images can be used; 0\.png", capfd.readouterr().err)


def assert_found(pattern: str, text: str) -> None:
    assert re.search(pattern, text), text
