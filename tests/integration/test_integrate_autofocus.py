"""Autofocus on the recorded flight with three lying people, and from the command line."""

import json
import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.cli import focus_stack
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.imaging.focus import region as focus_region
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.region import GroundRegion, ViewRegion
from aos_gcs.imaging.focus.track import FocusTrack, search_range_m, update_focus
from aos_gcs.imaging.model import Frame
from aos_gcs.surveys.images import LazyFrames
from aos_gcs.surveys.poses_file import read_poses
from tests.fakes.command_line import exit_status

RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"
PEOPLE_PX = (130.0, 100.0, 270.0, 230.0)
PEOPLE_Z_M = 18.0
LOW_M, HIGH_M = 5.0, 25.0


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fifth of the points to compare: enough for a height, in a fifth of the time."""
    monkeypatch.setattr(focus_region, "MAX_POINTS", 2_000)


@pytest.fixture(scope="module")
def recording() -> tuple[list[Frame], ViewRegion]:
    """The frames, and the window of the reference view that shows the people."""
    if not RECORDED.is_dir():
        pytest.skip("the recorded flight F0 is absent: nothing at ../shared/data/F0 beside the repository")
    render = json.loads((RECORDED / "reference" / "renders.json").read_text())["renders"][0]
    M = np.array(render["virtual_pose_world_to_camera_cv"])
    pose = Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)
    survey = read_poses(RECORDED / "poses.json", RECORDED / "images", np.radians(render["view_fov_deg"]))
    frames = list(LazyFrames(survey.images, survey.bands))
    return frames, ViewRegion(frames[0].camera, pose, PEOPLE_PX)


def test_the_people_come_into_focus(recording: tuple[list[Frame], ViewRegion]) -> None:
    frames, region = recording
    result = find_focus(frames, region, LOW_M, HIGH_M)
    assert result.found
    assert result.height_m == pytest.approx(PEOPLE_Z_M, abs=1.0)
    assert result.confidence > 0.8


@pytest.mark.usefixtures("few_points")
def test_the_ground_around_the_people_comes_into_focus(recording: tuple[list[Frame], ViewRegion]) -> None:
    frames, view = recording
    x, y, _ = view.centre_m(PEOPLE_Z_M)
    result = find_focus(frames, GroundRegion(x - 6.0, y - 6.0, x + 6.0, y + 6.0), LOW_M, HIGH_M)
    assert result.found
    assert result.height_m == pytest.approx(PEOPLE_Z_M, abs=1.0)


@pytest.mark.usefixtures("few_points")
def test_under_dense_canopy_without_people_nothing_is_found(recording: tuple[list[Frame], ViewRegion]) -> None:
    frames, view = recording
    empty = ViewRegion(view.camera, view.pose, (280.0, 280.0, 450.0, 450.0))
    assert not find_focus(frames, empty, LOW_M, HIGH_M).found


@pytest.mark.usefixtures("few_points")
@pytest.mark.parametrize("start_m", [5.0, 25.0])
def test_a_mission_converges_from_any_start(recording: tuple[list[Frame], ViewRegion], start_m: float) -> None:
    frames, region = recording
    track = FocusTrack(start_m, 0.5)
    # Successive steps see the people from every third place of the flight in turn.
    for step in range(6):
        low_m, high_m = search_range_m(track, LOW_M, HIGH_M)
        track = update_focus(track, find_focus(frames[step % 3 :: 3], region, low_m, high_m))
    assert track.height_m == pytest.approx(PEOPLE_Z_M, abs=1.0)
    assert track.sigma_m < 1.5


def test_the_command_focuses_the_recorded_flight(
    recording: tuple[list[Frame], ViewRegion], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    del recording
    out = tmp_path / "integral.npy"
    options = ["--fov", "50.815436217896945", "--view", "14", "--size", "200", "--autofocus", "14,23"]
    code, errors = run([str(RECORDED / "images"), "--poses", str(RECORDED / "poses.json"), *options], out, capsys)
    assert code == 0, errors
    height_m, confidence = told(errors)
    assert height_m == pytest.approx(PEOPLE_Z_M, abs=1.0)
    assert confidence > 0.5
    assert np.load(out).shape == (200, 200)


def test_the_command_focuses_a_rendered_flight(
    flight: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, errors = run([*flight, "--autofocus", "4,18"], tmp_path / "integral.npy", capsys)
    assert code == 0, errors
    height_m, confidence = told(errors)
    assert height_m == pytest.approx(12.0, abs=0.3)
    assert 0.2 <= confidence <= 1.0


def test_the_shift_of_a_terrain_is_found(flight: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--autofocus", "-4,4", "--dem", str(level_terrain(tmp_path, 11.0))]
    code, errors = run([*flight, *options], tmp_path / "integral.npy", capsys)
    assert code == 0, errors
    match = re.search(r"autofocus: terrain shifted by ([+-][\d.]+) ± ([\d.]+) m", errors)
    assert match, errors
    assert float(match[1]) == pytest.approx(1.0, abs=0.3)
    assert abs(float(match[1]) - 1.0) < 3.0 * float(match[2])


def test_a_terrain_hardly_moves_where_frames_do_not_tell_its_shift(
    flight: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    terrain = str(level_terrain(tmp_path, 40.0))
    code, errors = run([*flight, "--autofocus", "-4,4", "--dem", terrain], tmp_path / "found.npy", capsys)
    assert code == 0, errors
    match = re.search(r"terrain shifted by ([+-][\d.]+) ± ([\d.]+) m, mostly .*: the images contain little", errors)
    assert match, errors
    assert abs(float(match[1])) < 1.0 < float(match[2])
    code, errors = run([*flight, "--dem", terrain, "--dem-offset", match[1]], tmp_path / "given.npy", capsys)
    assert code == 0, errors
    np.testing.assert_allclose(np.load(tmp_path / "found.npy"), np.load(tmp_path / "given.npy"), atol=1.0)


def test_a_contact_sheet_is_written_even_where_nothing_is_found(
    flight: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stack = tmp_path / "stack.png"
    options = ["--autofocus", "1,2", "--focus-stack", str(stack)]
    code, errors = run([*flight, *options], tmp_path / "integral.npy", capsys)
    assert code == 2
    assert "found no focal plane" in errors
    picture = cv2.imread(str(stack), cv2.IMREAD_UNCHANGED)
    assert picture.shape == (3 * (focus_stack.EDGE_PX + focus_stack.LABEL_PX), 4 * focus_stack.EDGE_PX, 4)
    tiles = picture.reshape(3, -1, 4, focus_stack.EDGE_PX, 4).swapaxes(1, 2).reshape(12, -1)
    assert len({tile.tobytes() for tile in tiles}) == 12
    strips = picture.reshape(3, -1, 4, focus_stack.EDGE_PX, 4)[:, focus_stack.EDGE_PX :]
    labels = strips.swapaxes(1, 2).reshape(12, -1, 4)
    assert np.all(labels[..., 3] == 255), "each height stands below its picture"
    assert len({label.tobytes() for label in labels}) == 12


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ([], "neither is given"),
        (["--plane-z", "3", "--autofocus", "4,18"], "both are given"),
        (["--plane-z", "nan"], "--plane-z must lie between"),
        (["--autofocus", "7"], "needs two heights LOW,HIGH"),
        (["--autofocus", "9,4"], "needs two heights LOW,HIGH"),
        (["--autofocus", "low,high"], "needs two heights LOW,HIGH"),
        (["--dem", "a.obj", "--focus-region", "0,0,1,1"], "--focus-region requires --autofocus"),
        (["--autofocus", "1,2"], "found no focal plane from 1 to 2 m"),
    ],
)
def test_what_cannot_be_done_is_said_and_writes_nothing(
    flight: list[str], options: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "integral.npy"
    code, errors = run([*flight, *options], out, capsys)
    assert code == 2
    assert says in errors
    assert not out.exists()


@pytest.fixture
def flight(tmp_path: Path) -> list[str]:
    """Arguments for a small recording of a plane z = 12, the world's z pointing down."""
    camera = CameraModel.from_fov(160, 160, math.radians(50.0))
    rng = np.random.default_rng(0)
    ground = cv2.GaussianBlur(rng.uniform(0.0, 255.0, (600, 600)).astype(np.float32), (0, 0), 3.0)
    ground = cv2.normalize(ground, None, 0.0, 255.0, cv2.NORM_MINMAX)
    images = tmp_path / "images"
    images.mkdir()
    entries = []
    for index in range(6):
        pose = Pose(np.array([1.6 * (index - 2.5), 0.8 * (index % 2), -10.0]), np.eye(3))
        u, v = np.meshgrid(np.arange(160), np.arange(160))
        x, y, _ = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, 12.0).T
        maps = [(12.0 * axis + 300.0).reshape(160, 160).astype(np.float32) for axis in (x, y)]
        image = cv2.remap(ground, *maps, cv2.INTER_LINEAR)
        leaves = cv2.resize((rng.random((20, 20)) < 0.3).astype(np.uint8), (160, 160), interpolation=cv2.INTER_NEAREST)
        cv2.imwrite(str(images / f"{index}.png"), np.where(leaves > 0, 0, image).astype(np.uint8))
        rows = np.column_stack((np.eye(3), -pose.position_enu_m)).tolist()
        entries.append({"imagefile": f"{index}.png", "M3x4": rows})
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    return [str(images), "--poses", str(poses), "--fov", "50", "--view", "2", "--size", "80"]


def level_terrain(folder: Path, z_m: float) -> Path:
    mesh = folder / "terrain.obj"
    corners = [(-60, -60), (60, -60), (60, 60), (-60, 60)]
    mesh.write_text("".join(f"v {x} {y} {z_m}\n" for x, y in corners) + "f 1 2 3\nf 1 3 4\n")
    return mesh


def run(arguments: list[str], out: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    status = exit_status(["--log-level", "error", "integrate", *arguments, "--out", str(out)])
    return status, capsys.readouterr().err


def told(errors: str) -> tuple[float, float]:
    match = re.search(r"autofocus: z = (-?[\d.]+) ± [\d.]+ m, confidence ([\d.]+)", errors)
    assert match, errors
    return float(match[1]), float(match[2])
