"""``aos-gcs integrate`` from its command line to its files, on rendered and on recorded flights."""

import json
import logging
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

FOV_DEG = 50.0
PLANE_Z = 12.0
RECORDED = Path(__file__).resolve().parents[3] / "shared" / "data" / "F0"

Document = dict[str, list[dict[str, Any]]]


@pytest.fixture(autouse=True)
def _restore_logging(monkeypatch: pytest.MonkeyPatch) -> None:
    root = logging.getLogger()
    monkeypatch.setattr(root, "handlers", list(root.handlers))
    monkeypatch.setattr(root, "level", root.level)


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
        return ["integrate", str(self.images), *(str(item) for pair in values.items() for item in pair)]


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


def options(**values: object) -> Change:
    return lambda _: values


def output_in_absent_folder(flight: Flight) -> dict[str, object]:
    return {"out": flight.out.parent / "absent" / "integral.npy"}


def output_over_folder(flight: Flight) -> dict[str, object]:
    return {"out": flight.images}


def same_outputs(flight: Flight) -> dict[str, object]:
    return {"count": flight.out}


BAD_INPUT = {
    "missing folder": (remove_images, r"image folder .*images does not exist"),
    "missing poses": (options(poses="/absent/poses.json"), r"poses file /absent/poses\.json cannot be read"),
    "truncated png": (truncate_image, r"2\.png is incomplete"),
    "truncated jpeg": (truncate_jpeg, r"2\.png is incomplete"),
    "no image": (write_image(b"not an image"), r"2\.png is not an image"),
    "empty image": (write_image(b""), r"2\.png is not an image"),
    "image absent": (change_entry(imagefile="gone.png"), r"images\[2\] names the image gone\.png, which is not in"),
    "no image name": (change_entry(imagefile=None), r"images\[2\]: 'imagefile' must name"),
    "mixed sizes": (mix_sizes, r"2\.png has 60 x 50 pixels and 1 channel, but 0\.png has 60 x 60"),
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
    assert run([str(argument) for argument in arguments]) == 0
    with np.load(recording / "reference" / "plane_z18.npz") as reference:
        integral, count = np.load(out), np.load(count_file)
        same = count == reference["count"]
        assert np.count_nonzero(~same) <= 20
        error = np.abs(integral - reference["integral"])[same]
        assert error.mean() <= 0.01
        assert error.max() <= 0.15
