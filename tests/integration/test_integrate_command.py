"""``aos-gcs integrate`` from its command line to its files, on rendered and on recorded flights."""

import json
import logging
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.cli import main
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.imaging.surfaces import mesh

FOV_DEG = 50.0
PLANE_Z = 12.0
RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"

Document = dict[str, list[dict[str, Any]]]


@pytest.fixture(autouse=True)
def _restore_logging(monkeypatch: pytest.MonkeyPatch) -> None:
    root = logging.getLogger()
    monkeypatch.setattr(root, "handlers", list(root.handlers))
    monkeypatch.setattr(root, "level", root.level)


@pytest.fixture(autouse=True)
def _coarse_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plain slopes need no grid of millions of heights."""
    monkeypatch.setattr(mesh, "DEFAULT_SAMPLES", 40_000)


def texture(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return 120 + 60 * np.sin(0.9 * points[:, 0]) * np.cos(0.7 * points[:, 1])


class Flight:
    """A small recording in a world with z down: the cameras look along +z at a textured plane."""

    def __init__(self, folder: Path) -> None:
        self.images = folder / "images"
        self.images.mkdir()
        self.poses = folder / "poses.json"
        self.out = folder / "integral.npy"
        self.camera = CameraModel.from_fov(60, 60, np.radians(FOV_DEG))
        self.document: Document = {"images": []}
        for index, x in enumerate((-1.0, -0.3, 0.4, 1.0)):
            centre = np.array([x, 0.2 * x, -10.0])
            R_world2cam = cv2.Rodrigues(np.array([0.02 * index, 0.05, 0.3]))[0]
            image = self.render(Pose(centre, R_world2cam.T))
            cv2.imwrite(str(self.images / f"{index}.png"), np.round(image).astype(np.uint8))
            rows = np.column_stack((R_world2cam, -R_world2cam @ centre)).tolist()
            rows[0][0] = str(rows[0][0])
            self.document["images"].append({"imagefile": f"{index}.png", "M3x4": rows})
        self.save()

    def save(self) -> None:
        self.poses.write_text(json.dumps(self.document))

    def render(self, pose: Pose, size: int = 60) -> NDArray[np.float64]:
        camera = CameraModel.from_fov(size, size, np.radians(FOV_DEG))
        u, v = np.meshgrid(np.arange(size), np.arange(size))
        points = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, PLANE_Z)
        return texture(points).reshape(size, size)

    def pose(self, index: int) -> Pose:
        M = np.array(self.document["images"][index]["M3x4"], dtype=float)
        return Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)

    def arguments(self, **options: object) -> list[str]:
        values: dict[str, object] = {
            "--poses": self.poses,
            "--fov": FOV_DEG,
            "--plane-z": PLANE_Z,
            "--view": 1,
            "--size": 48,
            "--out": self.out,
        }
        values |= {"--" + name.replace("_", "-"): value for name, value in options.items()}
        # None leaves an option out, True gives it as a flag.
        given = [(name,) if value is True else (name, value) for name, value in values.items() if value is not None]
        return ["integrate", str(self.images), *(str(item) for option in given for item in option)]


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


def run(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert isinstance(stop.value.code, int)
    return stop.value.code


def test_the_integral_is_the_view_of_the_plane(flight: Flight, tmp_path: Path) -> None:
    count_file, png_file = tmp_path / "count.npy", tmp_path / "integral.png"
    assert run(flight.arguments(count=count_file, png=png_file)) == 0
    integral, count = np.load(flight.out), np.load(count_file)
    assert integral.dtype == np.float32
    assert integral.shape == count.shape == (48, 48)
    np.testing.assert_array_equal(np.isnan(integral), count == 0)
    assert count.max() == 4
    error = np.abs(integral - flight.render(flight.pose(1), 48))
    assert np.nanmean(error) < 0.5
    rgba = cv2.imread(str(png_file), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(rgba[:, :, 3] == 0, count == 0)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "count.npy",
        "images",
        "integral.npy",
        "integral.png",
        "poses.json",
    ]


def test_colour_images_give_a_colour_integral(flight: Flight) -> None:
    for path in flight.images.iterdir():
        grey = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), np.dstack((np.zeros_like(grey), grey // 2, grey)))
    assert run(flight.arguments()) == 0
    integral = np.load(flight.out)
    assert integral.shape == (48, 48, 3)
    assert np.nanmean(np.abs(integral[:, :, 0] - flight.render(flight.pose(1), 48))) < 0.5
    assert np.nanmax(integral[:, :, 2]) == 0.0


def test_deep_images_keep_their_values(flight: Flight) -> None:
    for path in flight.images.iterdir():
        grey = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), grey.astype(np.uint16) * 100)
    assert run(flight.arguments()) == 0
    assert np.nanmean(np.abs(np.load(flight.out) / 100 - flight.render(flight.pose(1), 48))) < 0.5


def write_slope(path: Path, slope_x: float, slope_y: float, height: float = PLANE_Z) -> Path:
    """Write the mesh of a large tilted square that has the height at x = y = 0."""
    corners = [(-40, -40), (40, -40), (40, 40), (-40, 40)]
    vertices = "".join(f"v {x} {y} {height + slope_x * x + slope_y * y}\n" for x, y in corners)
    path.write_text(vertices + "f 1 2 3 4\n")
    return path


def test_a_level_mesh_gives_what_the_plane_gives(flight: Flight, tmp_path: Path) -> None:
    assert run(flight.arguments()) == 0
    on_plane = np.load(flight.out)
    dem = write_slope(tmp_path / "dem.obj", 0.0, 0.0, PLANE_Z + 3.0)
    for fast in (None, True):
        assert run(flight.arguments(plane_z=None, dem=dem, dem_offset=-3, fast=fast)) == 0
        on_mesh = np.load(flight.out)
        both = ~np.isnan(on_mesh) & ~np.isnan(on_plane)
        assert both.sum() >= np.count_nonzero(~np.isnan(on_plane)) - 3
        np.testing.assert_allclose(on_mesh[both], on_plane[both], atol=0.05)


def test_north_and_east_of_the_tilt(flight: Flight, tmp_path: Path) -> None:
    # The cameras' mean position is x = 0.025, y = 0.005.
    north, east = math.tan(math.radians(12.0)), math.tan(math.radians(-7.0))
    assert run(flight.arguments(tilt="12,-7")) == 0
    tilted = np.load(flight.out)
    dem = write_slope(tmp_path / "dem.obj", east, north, PLANE_Z - 0.025 * east - 0.005 * north)
    assert run(flight.arguments(plane_z=None, dem=dem)) == 0
    on_mesh = np.load(flight.out)
    both = ~np.isnan(on_mesh) & ~np.isnan(tilted)
    assert both.sum() > 1500
    np.testing.assert_allclose(on_mesh[both], tilted[both], atol=0.02)


def test_a_map_has_the_ground_where_its_world_file_says(
    flight: Flight, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    png, count_file = tmp_path / "map.png", tmp_path / "count.npy"
    assert run(flight.arguments(view=None, size=None, ortho=0.2, png=png, count=count_file)) == 0
    integral, count = np.load(flight.out), np.load(count_file)
    assert count.shape == integral.shape == cv2.imread(str(png)).shape[:2]
    assert count[[0, -1]].any(axis=1).all()
    assert count[:, [0, -1]].any(axis=0).all()
    dx, _, _, dy, x, y = map(float, (tmp_path / "map.pgw").read_text().split())
    # The cameras look along +z: rows along +y show the ground as they see it.
    assert (dx, dy) == (0.2, 0.2)
    assert f"map: {count.shape[1]} x {count.shape[0]} cells of 0.2 m" in capfd.readouterr().err
    columns, rows = np.meshgrid(np.arange(count.shape[1]), np.arange(count.shape[0]))
    points = np.stack((x + dx * columns.ravel(), y + dy * rows.ravel()), axis=1)
    error = np.abs(integral - texture(points).reshape(count.shape))[count == 4]
    assert error.size > 1000
    assert error.mean() < 1.0


def test_a_map_of_terrain_ends_with_the_terrain(flight: Flight, tmp_path: Path) -> None:
    dem = tmp_path / "dem.obj"
    dem.write_text("v -2 -3 12\nv 2 -3 12\nv 2 3 12\nv -2 3 12\nf 1 2 3 4\n")
    options: dict[str, object] = {"plane_z": None, "dem": dem, "view": None, "size": None}
    assert run(flight.arguments(**options, ortho=0.1)) == 0
    integral = np.load(flight.out)
    assert integral.shape == (60, 40)
    assert np.isfinite(integral).all()


def test_images_that_see_nothing_are_counted(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    # One camera is turned round, to look up.
    rows = np.array(flight.document["images"][2]["M3x4"], dtype=float)
    flight.document["images"][2]["M3x4"] = (np.diag([1.0, -1.0, -1.0]) @ rows).tolist()
    flight.save()
    assert run(flight.arguments()) == 0
    assert "1 of 4 images do not see the focal surface; the first is 2.png" in capfd.readouterr().err


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


def lens_of(field: str, coefficients: object) -> Change:
    def change(flight: Flight) -> dict[str, object]:
        flight.poses.write_text(json.dumps({**flight.document, field: coefficients}))
        return {}

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
    return {"plane_z": None, "dem": geotiff(flight, None), "origin": "48,14,0"}


def look_up(flight: Flight) -> dict[str, object]:
    for entry in flight.document["images"]:
        entry["M3x4"] = (np.diag([1.0, -1.0, -1.0]) @ np.array(entry["M3x4"], dtype=float)).tolist()
    flight.save()
    return {"view": None, "size": None, "ortho": 0.1}


BAD_INPUT = {
    "no surface": (options(plane_z=None), "Give the focal plane as --plane-z"),
    "dem and plane": (options(dem="dem.obj"), "--dem and --plane-z exclude each other"),
    "dem and tilt": (options(plane_z=None, dem="dem.obj", tilt="1,1"), "--dem and --tilt exclude each other"),
    "dem and autofocus": (options(plane_z=None, dem="a.obj", autofocus="1,2"), "--dem and --autofocus exclude"),
    "offset without dem": (options(dem_offset=1), "--dem-offset requires --dem"),
    "offset not finite": (options(plane_z=None, dem="a.obj", dem_offset="nan"), "--dem-offset must be a finite"),
    "origin incomplete": (options(plane_z=None, dem="a.tif", origin="48"), "--origin needs LATITUDE"),
    "origin off the globe": (options(plane_z=None, dem="a.tif", origin="148,14,0"), "--origin needs LATITUDE"),
    "dem absent": (options(plane_z=None, dem="/absent/dem.obj"), r"terrain /absent/dem\.obj cannot be read"),
    "dem of no kind": (dem_file("dem.xyz"), r"dem\.xyz is of no known kind"),
    "dem broken": (dem_file("dem.obj", "v 1 2\nf 1 1 1\n"), r"dem\.obj is no mesh"),
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
    "empty image": (write_image(b""), r"2\.png is not an image"),
    "image absent": (change_entry(imagefile="gone.png"), r"images\[2\] names the image gone\.png, which is not in"),
    "no image name": (change_entry(imagefile=None), r"images\[2\]: 'imagefile' must name"),
    "mixed sizes": (mix_sizes, r"2\.png has 60 x 50 pixels and 1 channel, but 60 x 60 pixels and 1"),
    "invalid json": (write_poses('{"images": ['), "is not valid JSON"),
    "json of something else": (write_poses("[1, 2]"), "needs a non-empty list 'images'"),
    "no images": (write_poses('{"images": []}'), "needs a non-empty list 'images'"),
    "no matrix": (drop_matrix, r"images\[2\] \(2\.png\): 'M3x4' must be three rows"),
    "wrong shape": (change_entry(M3x4=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]), "'M3x4' must be three rows of four"),
    "text for a number": (set_number(1, 3, "north"), "'north', which is no finite number"),
    "truth for a number": (set_number(1, 3, True), "True, which is no finite number"),
    "nan": (set_number(1, 3, float("nan")), "nan, which is no finite number"),
    "no rotation": (set_number(1, 1, 2.0), r"images\[2\] \(2\.png\): the left 3x3 part of 'M3x4' is no rotation"),
    "mirrored": (mirror, "is no rotation"),
    "view too large": (options(view=4), r"--view 4 is out of range: .* has the views 0 to 3"),
    "view negative": (options(view=-1), "--view -1 is out of range"),
    "no fov": (options(fov=None), "--poses needs the field of view of the images: give it as --fov DEG"),
    "ground of poses": (options(ground=300), "--ground applies to photographs"),
    "lens in the file": (lens_of("lens", [0.1, 0.2]), r"'lens' of the poses file .* needs 4 to 5 finite coefficients"),
    "fisheye in the file": (lens_of("fisheye", 0.1), r"'fisheye' of the poses file .* needs 4 finite coefficients"),
    "fov zero": (options(fov=0), "--fov must lie between 0 and 180 degrees, got 0"),
    "fov too wide": (options(fov=180), "--fov must lie between"),
    "size": (options(size=0), "--size must lie between 1 and"),
    "plane not finite": (options(plane_z="nan"), "--plane-z must be a finite number"),
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
    assert run(flight.arguments(**change(flight))) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert re.match(r"aos-gcs: .*" + message, captured.err), captured.err
    assert not flight.out.exists()


@pytest.fixture
def recording() -> Path:
    if not RECORDED.is_dir():
        pytest.skip("the recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository")
    return RECORDED


def test_a_recorded_flight_agrees_with_an_independent_renderer(recording: Path, tmp_path: Path) -> None:
    renders = {r["tag"]: r for r in json.loads((recording / "reference" / "renders.json").read_text())["renders"]}
    entries = json.loads((recording / "poses.json").read_text())["images"]
    virtual = np.array(renders["plane_z18"]["virtual_pose_world_to_camera_cv"])
    distances = [np.abs(np.array(entry["M3x4"], dtype=float) - virtual).max() for entry in entries]
    out, count_file = tmp_path / "integral.npy", tmp_path / "count.npy"
    arguments = ["integrate", recording / "images", "--poses", recording / "poses.json", "--plane-z", 18]
    arguments += ["--fov", 50.815436217896945, "--view", int(np.argmin(distances)), "--out", out, "--count", count_file]
    assert run([str(argument) for argument in [*arguments, "--fast"]]) == 0
    with np.load(recording / "reference" / "plane_z18.npz") as reference:
        integral, count = np.load(out), np.load(count_file)
        same = count == reference["count"]
        assert np.count_nonzero(~same) <= 20
        error = np.abs(integral - reference["integral"])[same]
        assert error.mean() <= 0.05
        assert error.max() <= 1.0
