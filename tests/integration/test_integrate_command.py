"""``aos-gcs integrate`` from its command line to its files, on rendered and on recorded flights."""

import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.imaging.surfaces import mesh
from tests.fakes.command_line import exit_status
from tests.fakes.recorded_flight import PLANE_Z, Flight, texture

RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"


@pytest.fixture(autouse=True)
def _coarse_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plain slopes need no grid of millions of heights."""
    monkeypatch.setattr(mesh, "DEFAULT_SAMPLES", 40_000)


@pytest.fixture
def flight(tmp_path: Path) -> Flight:
    return Flight(tmp_path)


def test_the_integral_is_the_view_of_the_plane(flight: Flight, tmp_path: Path) -> None:
    count_file, png_file = tmp_path / "count.npy", tmp_path / "integral.png"
    assert exit_status(flight.arguments(count=count_file, png=png_file)) == 0
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
    assert exit_status(flight.arguments()) == 0
    integral = np.load(flight.out)
    assert integral.shape == (48, 48, 3)
    assert np.nanmean(np.abs(integral[:, :, 0] - flight.render(flight.pose(1), 48))) < 0.5
    assert np.nanmax(integral[:, :, 2]) == 0.0


def test_deep_images_keep_their_values(flight: Flight) -> None:
    for path in flight.images.iterdir():
        grey = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        cv2.imwrite(str(path), grey.astype(np.uint16) * 100)
    assert exit_status(flight.arguments()) == 0
    assert np.nanmean(np.abs(np.load(flight.out) / 100 - flight.render(flight.pose(1), 48))) < 0.5


def write_slope(path: Path, slope_x: float, slope_y: float, height: float = PLANE_Z) -> Path:
    """Write the mesh of a large tilted square that has the height at x = y = 0."""
    corners = [(-40, -40), (40, -40), (40, 40), (-40, 40)]
    vertices = "".join(f"v {x} {y} {height + slope_x * x + slope_y * y}\n" for x, y in corners)
    path.write_text(vertices + "f 1 2 3 4\n")
    return path


def test_a_level_mesh_gives_what_the_plane_gives(flight: Flight, tmp_path: Path) -> None:
    assert exit_status(flight.arguments()) == 0
    on_plane = np.load(flight.out)
    dem = write_slope(tmp_path / "dem.obj", 0.0, 0.0, PLANE_Z + 3.0)
    for exact in (None, True):
        assert exit_status(flight.arguments(plane_z=None, dem=dem, dem_offset=-3, exact=exact)) == 0
        on_mesh = np.load(flight.out)
        both = ~np.isnan(on_mesh) & ~np.isnan(on_plane)
        assert both.sum() >= np.count_nonzero(~np.isnan(on_plane)) - 3
        np.testing.assert_allclose(on_mesh[both], on_plane[both], atol=0.05)


def test_north_and_east_of_the_tilt(flight: Flight, tmp_path: Path) -> None:
    # The cameras' mean position is x = 0.025, y = 0.005.
    north, east = math.tan(math.radians(12.0)), math.tan(math.radians(-7.0))
    assert exit_status(flight.arguments(tilt="12,-7")) == 0
    tilted = np.load(flight.out)
    dem = write_slope(tmp_path / "dem.obj", east, north, PLANE_Z - 0.025 * east - 0.005 * north)
    assert exit_status(flight.arguments(plane_z=None, dem=dem)) == 0
    on_mesh = np.load(flight.out)
    both = ~np.isnan(on_mesh) & ~np.isnan(tilted)
    assert both.sum() > 1500
    np.testing.assert_allclose(on_mesh[both], tilted[both], atol=0.02)


def test_a_map_has_the_ground_where_its_world_file_says(
    flight: Flight, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    png, count_file = tmp_path / "map.png", tmp_path / "count.npy"
    assert exit_status(flight.arguments(view=None, size=None, ortho=0.2, png=png, count=count_file)) == 0
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
    assert exit_status(flight.arguments(**options, ortho=0.1)) == 0
    integral = np.load(flight.out)
    assert integral.shape == (60, 40)
    assert np.isfinite(integral).all()


def test_images_that_see_nothing_are_counted(flight: Flight, capfd: pytest.CaptureFixture[str]) -> None:
    # One camera is turned round, to look up.
    rows = np.array(flight.document["images"][2]["M3x4"], dtype=float)
    flight.document["images"][2]["M3x4"] = (np.diag([1.0, -1.0, -1.0]) @ rows).tolist()
    flight.save()
    assert exit_status(flight.arguments()) == 0
    assert "1 of 4 images do not see the focal surface; the first is 2.png" in capfd.readouterr().err


@pytest.fixture
def recording() -> Path:
    if not RECORDED.is_dir():
        pytest.skip("the recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository")
    return RECORDED


@pytest.mark.parametrize("options", [(), ("--exact",)], ids=["fast", "exact"])
def test_a_recorded_flight_agrees_with_an_independent_renderer(
    recording: Path, tmp_path: Path, options: tuple[str, ...]
) -> None:
    renders = {r["tag"]: r for r in json.loads((recording / "reference" / "renders.json").read_text())["renders"]}
    entries = json.loads((recording / "poses.json").read_text())["images"]
    virtual = np.array(renders["plane_z18"]["virtual_pose_world_to_camera_cv"])
    distances = [np.abs(np.array(entry["M3x4"], dtype=float) - virtual).max() for entry in entries]
    out, count_file = tmp_path / "integral.npy", tmp_path / "count.npy"
    arguments = ["integrate", recording / "images", "--poses", recording / "poses.json", "--plane-z", 18]
    arguments += ["--fov", 50.815436217896945, "--view", int(np.argmin(distances)), "--out", out, "--count", count_file]
    assert exit_status([str(argument) for argument in [*arguments, *options]]) == 0
    with np.load(recording / "reference" / "plane_z18.npz") as reference:
        integral, count = np.load(out), np.load(count_file)
        same = count == reference["count"]
        assert np.count_nonzero(~same) <= 20
        error = np.abs(integral - reference["integral"])[same]
        assert error.mean() <= 0.05
        assert error.max() <= 1.0
