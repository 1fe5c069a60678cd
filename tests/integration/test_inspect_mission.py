"""``aos-gcs inspect`` on missions as they are found on disks: finished, killed, damaged."""

import json
import signal
import sqlite3
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import pytest

from aos_gcs.store.reader import MissionReader
from tests.fakes.command_line import exit_status

WRITER = """
import asyncio, os, sys
from pathlib import Path

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import Finding, FindingStatus, TargetEstimate
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase, Suspension
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord, Task, VehicleSnapshot
from aos_gcs.ports import Capture, Severity, VehicleState
from aos_gcs.store.recorder import MissionRecorder

ORIGIN = GeodeticPosition(48.0, 14.0, 300.0)
IMAGE = np.zeros((64, 64, 3), dtype=np.uint8)


def step(number):
    return StepRecord(
        number, 2.0 * number, Phase.SCAN, 0.1 * number, 0.3, "line", 0.25, "exploitation", 1.0, 2.0, 1, None, {1: 0.5},
        {2: "no frame within 5 s"}, (), 1.0, 2.0, 3.0,
    )


def snapshot(number, phase):
    vehicle = VehicleSnapshot(
        VehicleState(1, mode_name="GUIDED", battery_fraction=0.5), Task.SWARM, 35.0, (1.0, 2.0, 35.0), 0.1, None,
        "shortened at the fence",
    )
    return MissionSnapshot(
        "m", "aos-apso", phase, Suspension.NONE, Outcome.OPEN, "scanning", 2.0 * number, number, ORIGIN, (), (),
        (vehicle,), (), TargetEstimate((3.0, 4.0, 0.0), 0.25, 4), 1.5,
        findings=(Finding(1, FindingStatus.NEW, (3.0, 4.0, 0.0), 1.0, 2.0, 1, 1, kind=FindingKind.PERSON),),
    )


async def fly(root, steps, killed):
    async with MissionRecorder.create(root, "m", {"seed": 1}, notify=print) as recorder:
        await recorder.record_action(ActionRecord(100.0, Action.START, None, ()))
        await recorder.record_settings(SettingsRecord(99.0, 1, "return height", {"RTL_ALT": 3000.0}))
        await recorder.record_event(Event(1, 100.0, EventKind.NOTICE, NoticeRecord(Severity.WARNING, "wind", 1, 0.0)))
        for number in range(1, steps + 1):
            phase = Phase.SCAN if number < 3 else Phase.CONVERGE
            await recorder.record_event(Event(number + 1, 100.0, EventKind.SNAPSHOT, snapshot(number, phase)))
            camera = CameraModel.from_fov(64, 64, 0.8)
            bands = ("red", "green", "blue")
            await recorder.record_frame(number, Capture(1, number, 1.0, IMAGE, bands, ORIGIN, np.eye(3), camera, 0.05))
            await recorder.record_step(step(number), {})
            await recorder.flush()
            print(number, flush=True)
        if killed:
            for number in range(1000, 1050):
                await recorder.record_step(step(number), {})
            await asyncio.Event().wait()
        await recorder.record_outcome(OutcomeRecord(200.0, Outcome.FOUND, {"target_error_m": 0.25}))


asyncio.run(fly(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3] == "killed"))
"""

STEPS = 4


def fly(root: Path, *, killed: bool) -> Path:
    """Record a mission in a process of its own, which is killed after the last flushed step or ends."""
    command = [sys.executable, "-c", WRITER, str(root), str(STEPS), "killed" if killed else "ends"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        assert process.stdout is not None
        for line in process.stdout:
            if killed and line.strip() == str(STEPS):
                process.kill()
    assert process.returncode == (-signal.SIGKILL if killed else 0)
    return root / "m"


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fly(tmp_path_factory.mktemp("finished"), killed=False)


@pytest.fixture(scope="module")
def broken_off(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fly(tmp_path_factory.mktemp("killed"), killed=True)


def inspect(*arguments: object) -> int:
    return exit_status(["inspect", *arguments])


def test_a_killed_mission_holds_every_step_that_was_flushed(
    broken_off: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with MissionReader(broken_off) as reader:
        assert [step.step for step in reader.steps()][:STEPS] == list(range(1, STEPS + 1))
        assert [entry.load().image_index for entry in reader.frames()] == list(range(1, STEPS + 1))
        assert reader.outcome() is None
    assert inspect(broken_off) == 0
    assert "not closed" in capsys.readouterr().out


def test_a_report_of_the_simulator_needs_its_world(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(finished, "--truth-report", finished / "report.json") == 2
    assert "--truth-report adds to --truth" in capsys.readouterr().err


def test_a_killed_mission_is_a_sound_database(broken_off: Path) -> None:
    connection = sqlite3.connect(broken_off / "mission.sqlite")
    assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()


def test_the_report_tells_what_an_operator_asks(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(finished, "--steps") == 0
    report = capsys.readouterr().out
    for text in (
        "possible person found",
        "strategy aos-apso, 1 vehicles, 8 s, 4 steps",
        "target at (3.0, 4.0, 0.0) m ENU ± 0.25 m, 4 sightings",
        "smallest separation 1.50 m",
        "best visibility 0.40 m² in step 4",
        "target_error_m: 0.25",
        "exploitation",
        "2 (no frame within 5 s)",
        "shortened at the fence",
        "50%",
        "wind",
        "1970-01-01 00:01:40",
        "mission.sqlite",
    ):
        assert text in report
    assert "\x1b" not in report  # plain where there is no terminal
    rows = [line.split() for line in report.splitlines()]
    assert ["1", "4", "0.05"] in rows, "frames, and how uncertain their times are"
    assert ["1", "return", "height", "RTL_ALT", "=", "3000", "changed"] in [row[2:] for row in rows]
    phases = [line.split() for line in report.splitlines() if line.split()[:1] in (["scan"], ["converge"])]
    assert phases == [["scan", "2", "4"], ["converge", "6", "8"]]


def test_steps_are_listed_only_when_asked_for(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(finished) == 0
    assert "exploitation" not in capsys.readouterr().out


def test_json_is_one_object_with_everything(finished: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert inspect(finished, "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["manifest"] == {"seed": 1}
    assert summary["outcome"]["outcome"] == "found"
    assert [step["step"] for step in summary["steps"]] == [1, 2, 3, 4]
    assert summary["final"]["target"]["position_enu_m"] == [3.0, 4.0, 0.0]
    assert {file["path"]: file["files"] for file in summary["files"]}["frames"] == STEPS


@pytest.mark.parametrize("name", ["", "missing"])
def test_a_folder_without_a_mission_is_one_sentence(
    tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert inspect(tmp_path / name) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is not a mission folder" in line


def test_a_damaged_mission_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mission.sqlite").write_bytes(b"\0" * 4096)
    assert inspect(tmp_path) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "damaged" in line


def test_the_estimate_is_judged_by_the_truth_of_a_simulator(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = tmp_path / "world.json"
    with MissionReader(finished) as reader:
        origin = asdict(reader.last_snapshot().origin)
    person = {"name": "person-1", "position_enu_m": [3.0, 5.0, 0.0], "height_m": 1.8}
    world = {"origin": origin, "seed": 1, "trees_per_ha": 0.0, "targets": [person]}
    truth.write_text(json.dumps(world), encoding="utf-8")
    assert inspect(finished, "--json", "--truth", truth) == 0
    score = json.loads(capsys.readouterr().out)["score"]
    assert score["target_error_m"] == pytest.approx(1.0, abs=0.01)
    assert (score["person_found"], score["claims"], score["false_claims"]) == (True, 1, 0)
    assert inspect(finished, "--truth", truth) == 0
    assert "target error m: 1.00" in capsys.readouterr().out
    assert inspect(finished, "--truth", tmp_path / "no.json") == 2
    assert "no.json cannot be read" in capsys.readouterr().err
