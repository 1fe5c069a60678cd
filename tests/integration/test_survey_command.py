"""``aos-gcs survey``: from a folder of photographs, or a recorded flight, to findings."""

from __future__ import annotations

import fcntl
import json
import os
import re
import shutil
import signal
import sqlite3
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pymap3d
import pytest

from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from aos_gcs.surveys.photos import read_photos
from aos_gcs.surveys.projected import ProjectedSystem
from tests.fakes.app import client_at
from tests.fakes.command_line import exit_status
from tests.fakes.program import running
from tests.fakes.recording import record
from tests.fakes.survey_flight import CAMERA, HOT_M, TAKEOFF, Photographs

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"


OVERLAP = ", in the 68 % of the ground that 2 successive pictures or more show."


@pytest.fixture
def photographs(tmp_path: Path) -> Photographs:
    return Photographs(tmp_path, hot=True)


def survey(capfd: pytest.CaptureFixture[str], folder: Path, *options: object) -> dict[str, Any]:
    """Examine a folder without a dashboard, and return what is printed."""
    capfd.readouterr()
    assert exit_status(["--log-level", "error", "survey", str(folder), "--headless", "--json", *map(str, options)]) == 0
    result: dict[str, Any] = json.loads(capfd.readouterr().out)
    return result


def error(capfd: pytest.CaptureFixture[str], folder: Path, *options: object) -> str:
    """Return why a folder is refused, in one line."""
    capfd.readouterr()
    assert exit_status(["--log-level", "error", "survey", str(folder), "--headless", *map(str, options)]) == 2
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("aos-gcs: ")]
    return line


def east_north_m(finding: dict[str, Any]) -> tuple[float, float]:
    at = (TAKEOFF.latitude_deg, TAKEOFF.longitude_deg, TAKEOFF.altitude_amsl_m)
    east_m, north_m, _ = pymap3d.geodetic2enu(finding["latitude_deg"], finding["longitude_deg"], at[2], *at)
    return float(east_m), float(north_m)


def test_what_photographs_show_is_found_in_its_place(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    result = survey(capfd, photographs.images, "--crs", "EPSG:32633")
    (finding,) = result["findings"]
    assert east_north_m(finding) == pytest.approx(HOT_M, abs=0.3)
    assert (finding["kind"], finding["status"], result["result"]) == ("anomaly", "new", "found")
    expected_m = ProjectedSystem.of("EPSG:32633").east_north_m(finding["latitude_deg"], finding["longitude_deg"])
    assert (finding["east_m"], finding["north_m"]) == expected_m
    assert result["message"] == f"6 of 6 pictures examined: 1 possible person{OVERLAP}"
    assert finding["reasons"][-1] == "in the view of 4 pictures, 0.jpg to 3.jpg"
    assert "seen in 4 of 4 frames" in finding["reasons"]
    assert not any("vehicle" in reason for reason in finding["reasons"])
    assert finding["significance"] > 5.0
    assert 0.0 < result["first_finding_s"] <= result["elapsed_s"]


@pytest.mark.slow
def test_the_recorded_flight_has_three_findings(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    flight = SHARED / "F0_flight"
    if not flight.is_dir():
        pytest.skip("the recorded flight is absent: nothing at ../shared/data/F0_flight beside the repository")
    poses = ("--poses", flight / "poses.json", "--fov", 50.815436217896945, "--convention", "z-down")
    ground = ("--dem", SHARED / "F0" / "dem_lr.obj.gz", "--dem-offset", 1, "--origin", "48.3069,14.2858,310")
    findings = survey(capfd, flight / "images", *poses, *ground, "--out", tmp_path / "results")["findings"]
    persons = json.loads((flight / "persons.json").read_text())["persons"]
    assert len(findings) == len(persons)
    places_m = np.array([east_north_m(finding) for finding in findings])
    for person in persons:
        assert np.linalg.norm(places_m - (person["x_m"], -person["y_m"]), axis=1).min() < 1.0
    significances = [finding["significance"] for finding in findings]
    assert min(significances) > 7.0


def test_an_empty_forest_has_no_findings(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    result = survey(capfd, Photographs(tmp_path).images)
    assert (result["findings"], result["result"], result["first_finding_s"]) == ([], "not_found", None)
    assert result["message"] == f"6 of 6 pictures examined: no person found{OVERLAP}"


def test_a_survey_is_not_examined_twice(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = survey(capfd, photographs.images)
    monkeypatch.setattr("aos_gcs.examination.examiner.search_window", None)
    assert survey(capfd, photographs.images) == first
    assert survey(capfd, Path(first["folder"])) == first
    shutil.rmtree(photographs.images)
    assert survey(capfd, Path(first["folder"])) == first


def test_other_options_or_pictures_need_another_folder(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    survey(capfd, photographs.images)
    refused = "holds a survey of other pictures, or with other options: name another folder with --out"
    assert refused in error(capfd, photographs.images, "--false-alarms-per-ha", 1)
    (photographs.images / "5.jpg").unlink()
    assert refused in error(capfd, photographs.images)
    survey(capfd, photographs.images, "--out", photographs.images.with_name("second"))


def test_an_examination_that_was_ended_goes_on(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.examination.windows.MAX_REACH", 0.3)
    whole = survey(capfd, photographs.images)
    assert whole["windows"] > 2
    ended = photographs.images.with_name("ended")
    observe = SurveyMission.observe

    def interrupted(mission: SurveyMission, targets: Any, step: int) -> Any:
        if step == 3:
            raise KeyboardInterrupt
        return observe(mission, targets, step)

    with monkeypatch.context() as patched:
        patched.setattr(SurveyMission, "observe", interrupted)
        arguments = ["survey", str(photographs.images), "--headless", "--json", "--out", str(ended)]
        assert exit_status(["--log-level", "error", *arguments]) == 130
    with MissionReader(ended) as reader:
        # The third is in the record, but not in its state.
        assert len(reader.steps()) == 3
    again = survey(capfd, photographs.images, "--out", ended)
    assert again["windows"] == whole["windows"]
    assert [east_north_m(one) for one in again["findings"]] == [
        pytest.approx(east_north_m(one)) for one in whole["findings"]
    ]
    with MissionReader(ended) as reader:
        assert [record.step for record in reader.steps()] == list(range(1, whole["windows"] + 1))
        kept = [(frame.step, frame.vehicle_id) for frame in reader.frames()]
        assert len(kept) == len(set(kept))


def test_poses_in_a_projected_system(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    system = ProjectedSystem.of("EPSG:32633")
    opened = read_photos(photographs.images)
    assert opened.origin is not None
    frame = LocalFrame(opened.origin)
    entries = []
    for image in opened.images:
        place = frame.to_geodetic(image.pose.position_enu_m)
        centre_m = np.array([*system.east_north_m(place.latitude_deg, place.longitude_deg), place.altitude_amsl_m])
        R = image.pose.R_cam2enu.T
        entries.append({"imagefile": image.path.name, "M3x4": np.column_stack((R, -R @ centre_m)).tolist()})
    poses = tmp_path / "poses.json"
    poses.write_text(json.dumps({"images": entries}))
    given = ("--poses", poses, "--fov", np.degrees(CAMERA.horizontal_fov_rad), "--plane-z", TAKEOFF.altitude_amsl_m)
    assert "give --origin LAT,LON[,ALT] of the poses' world, or --crs EPSG:CODE" in error(
        capfd, photographs.images, *given
    )
    (finding,) = survey(capfd, photographs.images, *given, "--crs", "EPSG:32633")["findings"]
    # The grid's north, by which these poses are turned, lies half a degree off.
    assert east_north_m(finding) == pytest.approx(HOT_M, abs=0.4)


def test_folders_that_cannot_be_examined_are_named(
    photographs: Photographs, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()
    assert "has no photographs" in error(capfd, empty)
    assert not (tmp_path / "empty-survey").exists()
    assert "does not exist; check the path" in error(capfd, tmp_path / "nowhere")
    for system in ("EPSG:32601", "EPSG:27700"):
        assert f"beside the area of {system}" in error(capfd, photographs.images, "--crs", system)
    assert "EPSG:0' is unknown" in error(capfd, photographs.images, "--crs", "EPSG:0")
    assert "holds no survey: name another folder with --out" in error(capfd, photographs.images, "--out", empty)
    assert "must lie between 0 and 20000" in error(capfd, photographs.images, "--false-alarms-per-ha", 0)
    assert "--min-score must not be negative" in error(capfd, photographs.images, "--min-score", -1)
    assert "--fov must lie between 0.1 and 170 degrees" in error(capfd, photographs.images, "--fov", "1e-9")
    assert "--plane-z must lie between" in error(capfd, photographs.images, "--plane-z=-1e300")
    assert "needs a range A:B" in error(capfd, photographs.images, "--frames", "0:" + "9" * 5000)
    assert "without spaces" in error(capfd, photographs.images, "--out", tmp_path / "my results")
    assert "No image has the focal surface in front" in error(capfd, photographs.images, "--plane-z", 900)


def test_pictures_that_do_not_overlap_give_no_false_assurance(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    """A place in one picture alone cannot be found: "no person found" would be taken for a searched area."""
    result = survey(capfd, photographs.images, "--frames", "0:1")
    assert result["message"] == (
        "1 of 1 pictures examined: no person found, as no place is in 2 successive pictures: only pictures that "
        "overlap can be examined."
    )
    partly = survey(capfd, photographs.images, "--frames", "0:6:5", "--out", photographs.images.with_name("partly"))
    assert re.search(r"found, in the \d+ % of the ground that 2 successive pictures or more show\.$", partly["message"])


def test_photographs_of_several_sensors_are_refused(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("0.jpg", "1.jpg"):
        (photographs.images / name).rename(photographs.images / f"DJI_{name[0]}_T.JPG")
    assert "choose one with --sensor thermal, wide or zoom" in error(capfd, photographs.images)


def test_one_program_at_a_time_continues_a_survey(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    first = survey(capfd, photographs.images)
    folder = os.open(first["folder"], os.O_RDONLY)
    fcntl.flock(folder, fcntl.LOCK_EX)
    try:
        capfd.readouterr()
        assert exit_status(["--log-level", "error", "survey", first["folder"], "--port", "0"]) == 2
        assert "is open in another aos-gcs survey: end that first" in capfd.readouterr().err
        # What was found can be printed all the same.
        assert survey(capfd, photographs.images) == first
    finally:
        os.close(folder)


def write_in_colour(photographs: Photographs) -> None:
    rng = np.random.default_rng(0)
    for name, tags in list(photographs.tags.items()):
        grey = cv2.imread(str(photographs.images / name), cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        red = grey.astype(np.float64)
        # Against colours without the noise of a camera, every bend of the ground stands out.
        noisy = np.dstack((red, red / 2 + 40, 200 - red / 2)) + rng.normal(0.0, 3.0, (*red.shape, 3))
        photographs.write(name, np.clip(noisy, 0, 255).astype(np.uint8), tags)


def test_colour_pictures_have_anomalies(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    write_in_colour(photographs)
    (finding,) = survey(capfd, photographs.images)["findings"]
    assert east_north_m(finding) == pytest.approx(HOT_M, abs=0.3)
    assert (finding["kind"], finding["frames"]) == ("anomaly", 4)
    assert finding["reasons"][0] == "no temperatures to judge it by"


def test_a_detector_that_cannot_be_applied_says_what_is_missing(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    write_in_colour(photographs)
    text = error(capfd, photographs.images, "--detector", "thermal")
    assert "No frame can be examined: The thermal detector needs a thermal band" in text


async def test_a_mission_is_shown_by_replay(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    await record(tmp_path / "mission")
    assert exit_status(["--log-level", "error", "survey", str(tmp_path / "mission")]) == 2
    assert "is the record of a mission: show it with aos-gcs replay" in capfd.readouterr().err


def test_a_picture_that_cannot_be_read_is_left_out(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    content = (photographs.images / "2.jpg").read_bytes()
    (photographs.images / "2.jpg").write_bytes(content[: len(content) // 2] + b"\xff\xd9")
    assert survey(capfd, photographs.images)["findings"]


def test_a_damaged_picture_is_named_and_left_out(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    """A stretch of a memory card that reads as zeros: decoders fill it up with the rest of the picture moved."""
    content = bytearray((photographs.images / "4.jpg").read_bytes())
    first = content.index(b"\xff\xda") + 100
    assert len(content) > first + 600
    content[first : first + 400] = bytes(400)
    (photographs.images / "4.jpg").write_bytes(content)
    result = survey(capfd, photographs.images)
    assert result["message"].startswith("5 of 6 pictures examined: 1 possible person")
    with MissionReader(Path(result["folder"])) as reader:
        texts = [getattr(event.data, "text", "") for event in reader.events()]
    assert [text for text in texts if re.match(r"Picture 4\.jpg left out: .* is damaged: .* Copy it again", text)]


def test_names_of_pictures_need_not_be_text(photographs: Photographs, capfd: pytest.CaptureFixture[str]) -> None:
    """Cards of older cameras hold names that are no UTF-8."""
    for name, latin in (("1.jpg", b"1\xe9.jpg"), ("2.jpg", b"2\xe9\n.jpg")):
        (photographs.images / name).rename(photographs.images / os.fsdecode(latin))
    (photographs.images / os.fsdecode(b"2\xe9\n.jpg")).write_bytes(b"no picture")
    (finding,) = survey(capfd, photographs.images)["findings"]
    assert finding["reasons"][-1] == "in the view of 3 pictures, 0.jpg to 3.jpg"


def test_a_full_disk_is_said_in_words(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("aos_gcs.store.database.MissionDatabase.add_frame", full)
    text = error(capfd, photographs.images)
    assert "No space left on device; free some space or check the disk" in text


@pytest.mark.parametrize("allowed", [0, 1, 2, 3, 5, 9])
def test_a_survey_that_a_full_disk_has_ended_continues(
    photographs: Photographs, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, allowed: int
) -> None:
    """Whatever of its first records has found room, the same command goes on when there is room again."""
    count = 0

    def full(self: MissionDatabase, statement: str, *values: object) -> None:
        nonlocal count
        count += 1
        if count > allowed:
            raise sqlite3.OperationalError("database or disk is full")
        execute(self, statement, *values)

    execute = MissionDatabase._execute
    with monkeypatch.context() as patched:
        patched.setattr(MissionDatabase, "_execute", full)
        assert "disk is full" in error(capfd, photographs.images)
    assert len(survey(capfd, photographs.images)["findings"]) == 1


def test_a_survey_beside_its_pictures_is_shown_again(
    photographs: Photographs, capfd: pytest.CaptureFixture[str]
) -> None:
    """Neither the results in the folder of the pictures nor other files there make the pictures others."""
    first = survey(capfd, photographs.images, "--out", photographs.images / "results")
    (photographs.images / "notes.txt").write_text("windy")
    assert survey(capfd, photographs.images, "--out", photographs.images / "results") == first


async def test_the_dashboard_of_a_survey_takes_decisions_and_no_commands(
    photographs: Photographs, tmp_path: Path
) -> None:
    out = tmp_path / "results"
    arguments = ("survey", str(photographs.images), "--out", str(out), "--port", "0")
    async with running(tmp_path / "run", *arguments) as program:
        await program.until_logged("stays available until Ctrl-C", 60)
        found = re.match(r"(http://[^/]+)/#code=(\S+)", program.operator_url)
        assert found is not None
        async with client_at(found[1]) as client:
            assert (await client.patch("/api/findings/1", json={"status": "confirmed"})).status_code == 403
            assert (await client.post("/api/session", json={"code": found[2], "name": "Ada"})).status_code == 200
            judged = await client.patch("/api/findings/1", json={"status": "confirmed"})
            assert (judged.json()["status"], judged.json()["operator"]) == ("confirmed", "Ada")
            seen = (await client.get("/api/mission")).headers["X-Seen"]
            for action in ("start", "hold", "return"):
                refused = await client.post("/api/mission/actions", json={"action": action}, headers={"X-Seen": seen})
                assert refused.status_code == 409
            mission = (await client.get("/api/mission")).json()
            assert (mission["allowed_actions"], mission["vehicles"], mission["replay"]) == ([], [], None)
            assert '"confirmed"' in (await client.get("/api/findings.geojson")).text
            assert (await client.get("/api/findings/1/thermal.png")).content.startswith(b"\x89PNG")
            frames = (await client.get("/api/viewer/1")).json()["frames"]
            assert [frame["name"] for frame in frames] == [f"{index}.jpg" for index in range(6)]
            assert (await client.get("/api/viewer/1/integrals/integral.png?height_m=1.5")).status_code == 200
        program.stop(signal.SIGINT)
        assert await program.ended(10.0) == 130
    with MissionReader(out) as reader:
        snapshot = reader.last_snapshot()
    assert snapshot is not None
    assert [(one.status, one.operator) for one in snapshot.findings] == [("confirmed", "Ada")]
    with sqlite3.connect(out / "mission.sqlite") as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
