"""``aos-gcs lab recordings``: a synthetic flight with two warm spots, and the recorded one where it is there."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import project_points
from tests.fakes.command_line import exit_status

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
SIZE, FOV_DEG, GROUND_Z = 320, 50.0, 18.0
CAMERA = CameraModel.from_fov(SIZE, SIZE, math.radians(FOV_DEG))
PERSONS = [(-2.0, 3.0, GROUND_Z), (4.0, -3.0, GROUND_Z)]
"""Places in a world of x east, y south, z down, as that of the recorded flight."""
OPTIONS = ("--plane-z", str(GROUND_Z), "--fov", str(FOV_DEG), "--window", "6", "--stride", "3")


def write_recording(folder: Path, *, images: int = 9, marked: list[dict[str, Any]] | None = None) -> Path:
    """A drone that flies east 10 m above the ground; leaves that shine lie elsewhere in each frame."""
    (folder / "images").mkdir(parents=True)
    entries = []
    for index in range(images):
        pose = Pose(np.array([0.4 * index - 1.6, 0.0, GROUND_Z - 20.0]), np.eye(3))
        rng = np.random.default_rng(index)
        image = rng.normal(90.0, 4.0, (SIZE, SIZE))
        for place in PERSONS:
            (u, v) = np.rint(project_points([place], CAMERA, pose)[0]).astype(int)
            image[v - 6 : v + 7, u - 3 : u + 4] += 90.0
        for u, v in rng.integers(8, SIZE - 8, (4, 2)):
            image[v : v + 4, u : u + 4] += 60.0
        cv2.imwrite(str(folder / "images" / f"{index}.png"), np.clip(image, 0, 255).astype(np.uint8))
        t = -pose.position_enu_m
        entries.append({"imagefile": f"{index}.png", "M3x4": np.column_stack([np.eye(3), t]).tolist()})
    (folder / "poses.json").write_text(json.dumps({"images": entries}))
    persons = [dict(zip(("x_m", "y_m", "z_m"), place, strict=True)) for place in PERSONS]
    (folder / "persons.json").write_text(json.dumps({"persons": persons if marked is None else marked}))
    return folder


def command(*arguments: str) -> int:
    return exit_status(["--log-level", "error", "lab", "recordings", *arguments])


def results(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert command(*arguments, "--json") == 0
    data: dict[str, Any] = json.loads(capsys.readouterr().out)
    return data


def test_persons_are_claimed_at_their_places_and_leaves_are_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = results(capsys, str(write_recording(tmp_path / "flight")), *OPTIONS, "--detectors", "thermal,local_rx")
    assert [(one["detector"], one["first"]) for one in data["windows"]] == [
        ("thermal", 0),
        ("local_rx", 0),
        ("thermal", 3),
        ("local_rx", 3),
    ]
    for window in data["windows"]:
        assert (window["persons"], window["detected"], window["found"]) == (2, 2, 2)
        assert (window["claims"], window["false_claims"]) == (2, 0)
        assert max(window["errors_m"]) < 0.3
        assert 0.03 < window["searched_ha"] < 0.05
    total = data["totals"][0]
    assert (total["recall"]["hits"], total["recall"]["trials"]) == (4, 4)
    assert 0.3 < total["recall"]["low"] < 1.0
    assert total["false_claims"]["events"] == 0
    assert total["false_claims"]["high"] > 10.0


def test_claims_where_nobody_is_count_as_false_and_unclaimed_persons_as_missed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    beside = [{"x_m": 4.0, "y_m": -3.0, "z_m": GROUND_Z}, {"x_m": 0.0, "y_m": -6.0, "z_m": GROUND_Z}]
    folder = write_recording(tmp_path / "flight", marked=beside)
    data = results(capsys, str(folder), *OPTIONS, "--detectors", "local_rx")
    for window in data["windows"]:
        assert (window["persons"], window["found"], window["claims"], window["false_claims"]) == (2, 1, 2, 1)
    assert data["totals"][0]["precision"]["hits"] == data["totals"][0]["recall"]["hits"] == 2


def test_a_recording_of_nobody_has_false_claims_only_and_the_document_is_renewed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, document = write_recording(tmp_path / "flight", marked=[]), tmp_path / "recordings.md"
    arguments = (str(folder), *OPTIONS, "--detectors", "local_rx", "--document", str(document))
    assert command(*arguments) == 0
    table = capsys.readouterr().out
    assert "| local_rx | 2 | - | - | 0 of 4: 0 % (0 to 49) |" in table
    document.write_text(document.read_text().replace("# Recordings\n", "# Recordings\n\nOwn words.\n"))
    assert command(*arguments) == 0
    text = document.read_text()
    assert "Own words." in text
    assert text.endswith(f"{table.rstrip()}\n\n<!-- End of the written part -->\n")


@pytest.mark.parametrize(
    ("persons", "expected"),
    [
        ("{", "persons.json is not valid JSON"),
        ("[]", "needs a list 'persons'"),
        ('{"persons": [3]}', "persons[0] must be an object with x_m, y_m, z_m"),
        ('{"persons": [{"x_m": 1, "y_m": "2", "z_m": 18}]}', "persons[0]: 'y_m' must be a finite number of metres"),
        ('{"persons": [{"x_m": 1, "y_m": NaN, "z_m": 18}]}', "persons[0]: 'y_m' must be a finite number of metres"),
        ('{"persons": [{"x_m": 1, "y_m": 2}]}', "persons[0]: 'z_m' must be a finite number of metres, got None"),
        ('{"persons": [{"x_m": 900, "y_m": 2, "z_m": 18}]}', "persons[0] is in no image of"),
    ],
)
def test_files_of_persons_that_cannot_be_are_refused_by_their_field(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], persons: str, expected: str
) -> None:
    folder = write_recording(tmp_path / "flight", images=2)
    (folder / "persons.json").write_text(persons)
    assert command(str(folder), *OPTIONS) == 2
    assert expected in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--detectors", "eyes"), "--detectors must be among rx, local_rx, thermal, got 'eyes'"),
        (("--window", "1"), "--window must be at least 2"),
        (("--window", "30"), "--window 30 with --first 0 does not fit into flight, which has 2 images"),
        (("--resolution", "0"), "--resolution must lie within 0.01 and 1 m"),
        (("--dem", "hill.obj"), "--plane-z excludes --dem and --dem-offset"),
        (("--fov", "0"), "--fov must lie within 1 and 170 degrees"),
        (("--plane-z", "nan"), "--dem-offset and --plane-z must be finite"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], expected: str
) -> None:
    folder = write_recording(tmp_path / "flight", images=2)
    assert command(str(folder), *OPTIONS, *options) == 2
    assert expected in " ".join(capsys.readouterr().err.split())


def test_a_folder_without_terrain_asks_for_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(str(write_recording(tmp_path / "flight", images=2)), "--fov", "50") == 2
    assert "needs one terrain" in " ".join(capsys.readouterr().err.split())


def test_the_recorded_flight_keeps_its_persons(capsys: pytest.CaptureFixture[str]) -> None:
    flight = SHARED / "F0_flight"
    if not flight.is_dir():
        pytest.skip("the recorded flight is absent: nothing at ../shared/data/F0_flight beside the repository")
    ground = ("--dem", str(SHARED / "F0" / "dem_lr.obj.gz"), "--dem-offset", "-1", "--fov", "50.815436217896945")
    data = results(capsys, str(flight), *ground, "--first", "12", "--stride", "60", "--detectors", "local_rx")
    early, middle, late = data["windows"]
    for window in (middle, late):
        assert (window["persons"], window["detected"], window["found"], window["false_claims"]) == (3, 3, 3, 0)
        assert max(window["errors_m"]) < 1.0
    assert early["detected"] >= 2
    assert sum(window["false_anomalies"] for window in data["windows"]) == 0


@pytest.mark.slow
def test_the_whole_recorded_flight_has_three_rows(tmp_path: Path) -> None:
    flight = SHARED / "F0_flight"
    if not flight.is_dir():
        pytest.skip("the recorded flight is absent: nothing at ../shared/data/F0_flight beside the repository")
    table = tmp_path / "rows.csv"
    arguments = ["integrate", str(flight / "images"), "--poses", str(flight / "poses.json")]
    arguments += ["--fov", "50.815436217896945", "--dem", str(SHARED / "F0" / "dem_lr.obj.gz"), "--dem-offset", "-1"]
    arguments += ["--ortho", "0.1", "--out", str(tmp_path / "map.npy"), "--blobs", str(table)]
    assert exit_status([*arguments, "--thumbnails", str(tmp_path / "rows")]) == 0
    rows = list(csv.DictReader(table.read_text().splitlines()))
    places = [(person["x_m"], person["y_m"]) for person in json.loads((flight / "persons.json").read_text())["persons"]]
    assert len(rows) == len(places)
    for x_m, y_m in places:
        assert min(math.hypot(x_m - float(row["x_m"]), y_m - float(row["y_m"])) for row in rows) < 1.0
    assert all((tmp_path / row["thumbnail"]).is_file() for row in rows)
