"""``aos-gcs replay --verify``: searches over the tests' fleet, in virtual time, recorded and then computed again."""

from __future__ import annotations

import asyncio
import json
import re
import shutil
import sqlite3
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aos_gcs.errors import WorkerError
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.search.targets.persons import watch_persons
from aos_gcs.planning.settings import DetectionSettings, RegistrationSettings
from aos_gcs.ports import ThreadWorker
from aos_gcs.runtime.recorded.verification import verify_mission
from aos_gcs.runtime.simulated.virtual_time import run
from aos_gcs.store.images import encode_image
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import DATABASE_NAME
from tests.fakes.command_line import exit_status
from tests.fakes.mission_flight import Flight, flying, prepare
from tests.fakes.recorded_search import write_search

STEP = 3
"""The step in which something is changed."""
Database = sqlite3.Connection


async def fly_straight(folder: Path) -> Flight:
    flight = prepare(3)
    async with flying(flight) as outcome:
        assert await outcome is Outcome.FOUND
    write_search(folder, flight.recorder)
    return flight


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("verify") / "mission"
    run(fly_straight(folder))
    return folder


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "mission"))


def verify(folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Return the exit status of the command, and what it prints."""
    status = exit_status(["--log-level", "error", "replay", str(folder), "--verify"])
    printed = capsys.readouterr()
    return status, printed.out + printed.err


def change(database: Database, table: str, column: str, edit: Callable[[Any], None]) -> None:
    """Change the record of a step."""
    (text,) = database.execute(f"SELECT {column} FROM {table} WHERE step = ?", (STEP,)).fetchone()  # noqa: S608
    record = json.loads(text)
    edit(record)
    database.execute(f"UPDATE {table} SET {column} = ? WHERE step = ?", (json.dumps(record), STEP))  # noqa: S608


def test_a_search_is_computed_again_and_identical(recorded: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with MissionReader(recorded) as reader:
        steps = reader.steps()
    assert {step.phase for step in steps} == {"scan", "converge", "found"}
    assert verify(recorded, capsys) == (0, f"identical: {len(steps)} steps computed again\n")


def test_a_search_with_thermal_cameras_alone_finds_and_is_identical(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async def fly() -> None:
        flight = prepare(3)
        for vehicle in flight.fleet.members.values():
            vehicle.bands = ("thermal",)
        async with flying(flight) as outcome:
            assert await outcome is Outcome.FOUND
        write_search(tmp_path / "mission", flight.recorder)

    run(fly())
    code, text = verify(tmp_path / "mission", capsys)
    assert (code, text.partition(":")[0]) == (0, "identical")


def test_a_changed_pixel_is_named(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with MissionReader(copy) as reader:
        frame = reader.frames(STEP)[1]
        image = frame.load().image.copy()
        image[5, 5, 0] += 1
        frame.path.write_bytes(encode_image(image, frame.load().bands).content)
    code, text = verify(copy, capsys)
    assert (code, text.partition(": recorded")[0]) == (
        1,
        f"different: step {STEP}, vehicle {frame.vehicle_id}, frame (digest of pixels and pose)",
    )


def test_a_last_step_whose_frames_a_killed_station_has_not_written_is_left_out(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with MissionReader(copy) as reader:
        last = reader.steps()[-1].step
        assert reader.outcome() is None
    with closing(sqlite3.connect(copy / DATABASE_NAME)) as database:
        database.execute("DELETE FROM frames WHERE step = ? AND vehicle_id > 1", (last,))
        database.commit()
    assert verify(copy, capsys) == (0, f"identical: {last - 1} steps computed again\n")


def move_frame(database: Database) -> None:
    database.execute("UPDATE frames SET latitude_deg = latitude_deg + 1e-6 WHERE step = ? AND vehicle_id = 2", (STEP,))


def move_vehicle(database: Database) -> None:
    def edit(record: Any) -> None:
        record["situation"]["swarm"][1]["position_enu_m"][0] += 0.5

    change(database, "decisions", "record", edit)


def mark_more(database: Database) -> None:
    change(database, "decisions", "record", lambda record: record["marks"].update({"2": "0123456789abcdef"}))


def settle(database: Database) -> None:
    change(database, "decisions", "record", lambda record: record.update(settled_enu_m=[[1.0, 2.0]]))


def decide_otherwise(database: Database) -> None:
    change(database, "decisions", "record", lambda record: record.update(following="found"))


def move_waypoint(database: Database) -> None:
    def edit(record: Any) -> None:
        record["waypoints"][2]["sent_enu_m"][1] += 0.01

    change(database, "steps", "record", edit)


def draw_otherwise(database: Database) -> None:
    change(database, "steps", "strategy_state", lambda state: state["generator"]["state"].update(state=1))


def conclude_otherwise(database: Database) -> None:
    change(database, "decisions", "conclusion", lambda record: record.update(following="land"))


@pytest.mark.parametrize(
    ("tamper", "expected"),
    [
        (move_frame, r", vehicle 2, frame \(digest of pixels and pose\): recorded \w+, computed \w+"),
        (move_vehicle, r", vehicle \d, waypoint, requested enu m: recorded \[.+\], computed \[.+\]"),
        (mark_more, r", vehicle 2, mask \(digest of its marks\): recorded 0123456789abcdef, computed \w{16}"),
        (settle, r", settled places: recorded \[\[1, 2\]\], computed \[\]"),
        (decide_otherwise, r", phase that follows: recorded found, computed scan"),
        (move_waypoint, r", vehicle 3, waypoint, sent enu m: recorded \[.+\], computed \[.+\]"),
        (draw_otherwise, r", state of the strategy, generator, state, state: recorded 1, computed \d+"),
        (conclude_otherwise, r", phase that was concluded: recorded land, computed scan"),
    ],
)
def test_what_was_changed_in_the_record_is_named(
    copy: Path, capsys: pytest.CaptureFixture[str], tamper: Callable[[Database], None], expected: str
) -> None:
    with closing(sqlite3.connect(copy / DATABASE_NAME)) as database, database:
        tamper(database)
    code, text = verify(copy, capsys)
    assert code == 1
    assert re.fullmatch(rf"different: step {STEP}{expected}\n", text), text


def forget_decision(database: Database) -> None:
    database.execute("DELETE FROM decisions WHERE step = ?", (STEP,))


def lose_step(database: Database) -> None:
    database.execute("DELETE FROM steps WHERE step = ?", (STEP,))
    forget_decision(database)


def damage(database: Database) -> None:
    change(database, "decisions", "record", lambda record: record.pop("situation"))


def forget_all(database: Database) -> None:
    database.execute("DELETE FROM steps")


def grow_old(database: Database) -> None:
    database.executescript("DROP TABLE decisions; DROP TABLE searches; PRAGMA user_version = 3;")


@pytest.mark.parametrize(
    ("tamper", "expected"),
    [
        (forget_decision, f"what step {STEP} depended on is not recorded"),
        (lose_step, f"steps before step {STEP + 1} are missing in the record"),
        (damage, f"decision of step {STEP} cannot be read: DecisionRecord: missing situation"),
        (forget_all, "it holds no step of a search"),
        (grow_old, "recorded by an older version (layout below 4) and does not hold what its decisions depended on"),
    ],
)
def test_a_record_that_holds_too_little_is_an_error(
    copy: Path, capsys: pytest.CaptureFixture[str], tamper: Callable[[Database], None], expected: str
) -> None:
    with closing(sqlite3.connect(copy / DATABASE_NAME)) as database:
        tamper(database)
        database.commit()
    code, text = verify(copy, capsys)
    assert code == 2
    assert expected in text


def check(folder: Path, flight: Flight) -> None:
    with MissionReader(write_search(folder, flight.recorder)) as reader:
        result = verify_mission(reader)
    assert result.difference is None, str(result.difference)
    assert result.steps == len(flight.recorder.steps) > 5


class BusyWorker(ThreadWorker):
    """Takes a second of the mission's time to judge targets, so that an operator can be faster."""

    def __init__(self) -> None:
        self.fails = False

    async def run(self, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        if function is watch_persons:
            await asyncio.sleep(1.0)
            if self.fails:
                raise WorkerError("it was out of memory")
        return await super().run(function, *args, **kwargs)


@pytest.mark.looptime
async def test_holds_verdicts_losses_and_failed_judgements_are_in_the_record(tmp_path: Path) -> None:
    worker, ada = BusyWorker(), {"operator": "Ada"}
    flight = prepare(4, detection=DetectionSettings(threshold_m2=0.3), worker=worker)
    view, commands = flight.view, flight.commands

    async def step(number: int) -> None:
        await flight.until(lambda: view.snapshot().step >= number)

    async with flying(flight) as outcome:
        await flight.until(lambda: bool(view.snapshot().findings))
        first = view.snapshot().step + 1
        await step(first)
        await commands.act(Action.HOLD, None, **ada)
        await commands.change_finding(1, FindingChange(status=FindingStatus.REJECTED), **ada)
        await commands.add_finding((-5.0, 20.0, 0.0), "a shoe", **ada)
        await commands.act(Action.RESUME, None, **ada)
        await step(first + 2)
        worker.fails = True
        await step(first + 4)
        worker.fails = False
        await commands.act(Action.RETURN, [2], **ada)
        await step(first + 8)
        await commands.act(Action.RETURN, None, **ada)
        await outcome
    recorder = flight.recorder
    assert first not in recorder.conclusions
    assert not all(conclusion.judged for conclusion in recorder.conclusions.values())
    assert {len(decision.situation.swarm) for decision in recorder.decisions.values()} == {3, 4}
    check(tmp_path / "mission", flight)


def shifted(_registration: object, frames: Sequence[Frame], _min_confidence: float) -> list[Frame]:
    """Stand in for a registration that is sure of the poses."""
    offset_m = np.array([0.3, 0.0, 0.0])
    return [replace(one, pose=replace(one.pose, position_enu_m=one.pose.position_enu_m + offset_m)) for one in frames]


@pytest.mark.looptime
async def test_corrected_poses_and_the_focal_plane_are_in_the_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.mission.search.frames.vision.apply_sure", shifted)
    flight = prepare(3, registration=RegistrationSettings(enabled=True))
    async with flying(flight) as outcome:
        await flight.until(lambda: flight.view.snapshot().step >= 4)
        flight.mission.sortie.vision.override_focus(1.0)
        await outcome
    assert {decision.focal_height_m for decision in flight.recorder.decisions.values()} == {0.0, 1.0}
    check(tmp_path / "mission", flight)
