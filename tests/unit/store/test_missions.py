import asyncio
import json
import sqlite3
import threading
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.plans import TrafficSituation
from aos_gcs.airspace.traffic import Obstacle, WaypointRequest
from aos_gcs.errors import RecordingError
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.rotations import R_from_quaternion
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action, ActionRecord, ActionResult
from aos_gcs.mission.model.decisions import (
    ConclusionRecord,
    DecisionRecord,
    FormedLine,
    SearchRecord,
    Situation,
    SwarmPlace,
)
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord, PicturesRecord
from aos_gcs.mission.model.findings import Finding, FindingStatus, TargetEstimate
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity
from aos_gcs.store.codec import encode
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.recorder import QUEUE_SIZE, MissionRecorder
from tests.fakes.mission_store import Store
from tests.fakes.records import capture, notice_event, snapshot, step_record


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "missions")


@pytest.fixture
async def recorder(store: Store) -> AsyncIterator[MissionRecorder]:
    async with store.record() as recorder:
        yield recorder


class FullDisk:
    """Lets the database fail as SQLite does on a full disk, while ``full`` is set."""

    def __init__(self) -> None:
        self.full = False


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> FullDisk:
    disk = FullDisk()
    write = MissionDatabase.write

    def write_if_room(database: MissionDatabase, writes: Sequence[Write]) -> None:
        if disk.full:
            raise sqlite3.OperationalError("database or disk is full")
        write(database, writes)

    monkeypatch.setattr(MissionDatabase, "write", write_if_room)
    return disk


# --- what is recorded can be read -----------------------------------------------------------------------------------


async def test_everything_recorded_is_read_back(store: Store) -> None:
    pictures = PicturesRecord(2, (PictureKind.INTEGRAL,), -1.0, -2.0, 3.0, 4.0)
    data = (
        (EventKind.NOTICE, NoticeRecord(Severity.WARNING, "wind", 3, 1.0)),
        (EventKind.SNAPSHOT, snapshot()),
        (EventKind.STEP, step_record(1)),
        (EventKind.PICTURES, pictures),
    )
    events = [Event(seq, 100.5 + seq, kind, item) for seq, (kind, item) in enumerate(data, start=1)]
    hold = ActionRecord(7.0, Action.HOLD, (1, 2), (ActionResult(1, True, "holds"),))
    start = ActionRecord(8.0, Action.START, None, (), refusal="it has been started already")
    changed = SettingsRecord(6.0, 2, "return height", {"RTL_ALT": 3000.0})
    outcome = OutcomeRecord(99.0, Outcome.FOUND, {"target_error_m": 0.25})
    async with store.record(seed=3) as recorder:
        for event in events:
            await recorder.record_event(event)
        await recorder.record_step(step_record(1), {"rng": np.random.default_rng(1).bit_generator.state})
        await recorder.record_step(step_record(2), {"velocity": np.eye(2)})
        await recorder.record_action(hold)
        await recorder.record_action(start)
        await recorder.record_settings(changed)
        await recorder.record_settings(replace(changed, is_restored=True))
        await recorder.record_outcome(outcome)
    with store.read() as reader:
        assert reader.manifest() == {"seed": 3}
        assert list(reader.events()) == events
        assert list(reader.events(EventKind.PICTURES)) == events[3:]
        assert reader.last_snapshot() == snapshot()
        assert reader.steps() == (step_record(1), step_record(2))
        assert reader.strategy_state(1)["rng"] == np.random.default_rng(1).bit_generator.state
        assert reader.actions() == (hold, start)
        assert reader.settings() == (changed, replace(changed, is_restored=True))
        assert reader.outcome() == outcome
    assert store.notices == []


async def test_decisions_are_read_back_with_all_that_they_depended_on(store: Store) -> None:
    point = np.array([1.0, 2.0, 30.0])
    request = WaypointRequest(
        vehicle_id=2,
        position_enu_m=point,
        requested_enu_m=point,
        link_age_s=0.1,
        position_age_s=None,
        battery_fraction=0.5,
    )
    traffic = TrafficSituation(
        limits=UNLIMITED, arrival_radius_m=0.5, movable=(request,), left={3: "held"}, obstacles=(Obstacle(4, point),)
    )
    leg = ScanLeg((0.0, 1.0), (0.0, 1.0), 20.0)
    decision = DecisionRecord(
        step=1,
        phase=Phase.SCAN,
        decided=0,
        concluded=0,
        focal_height_m=0.5,
        settled_enu_m=((1.0, 2.0),),
        situation=Situation(3.0, (SwarmPlace(2, (1.0, 2.0, 30.0), 30.0),), traffic),
        following=Phase.CONVERGE,
        marks={2: "0123"},
        line=FormedLine((leg,), 0, leg),
        poses={2: Pose(point, np.eye(3))},
        edits=(Finding(1, FindingStatus.REJECTED, (1.0, 2.0, 0.0), 1.0, 2.0, 1),),
    )
    conclusion = ConclusionRecord(1, 4.0, True, Phase.FOUND, (TargetEstimate((1.0, 2.0, 0.0), None, 3),))
    search = SearchRecord(
        MissionSettings(2, ((0.0, 0.0), (9.0, 0.0), (0.0, 9.0)), ImagingSettings()), capture().position
    )
    async with store.record() as recorder:
        await recorder.record_search(search)
        await recorder.record_decision(decision)
        await recorder.record_decision(replace(decision, step=2))
        await recorder.record_conclusion(conclusion)
    with store.read() as reader:
        assert reader.search() == search
        (first, concluded), second = reader.decision(1), reader.decision(2)
        assert reader.decision(3) is None
    assert encode(first) == encode(decision)
    assert concluded == conclusion
    assert second[1] is None


async def test_frames_are_read_back_with_their_exact_poses(store: Store) -> None:
    async with store.record() as recorder:
        await recorder.record_frame(1, replace(capture(2), time_sigma_s=0.03))
        await recorder.record_frame(1, capture(1))
        await recorder.record_frame(2, capture(1))
    with store.read() as reader:
        assert [entry.time_sigma_s for entry in reader.frames()] == [None, 0.03, None]
        assert [(entry.step, entry.vehicle_id) for entry in reader.frames()] == [(1, 1), (1, 2), (2, 1)]
        (_, entry) = reader.frames(step=1)
        loaded, original = entry.load(), capture(2)
    np.testing.assert_array_equal(loaded.image, original.image)
    np.testing.assert_array_equal(loaded.R_cam2enu, original.R_cam2enu)
    assert loaded.time_sigma_s == 0.03
    for name in ("vehicle_id", "image_index", "utc_s", "bands", "position", "camera"):
        assert getattr(loaded, name) == getattr(original, name)


async def test_other_tools_find_the_orientation_as_a_quaternion(store: Store) -> None:
    async with store.record() as recorder:
        await recorder.record_frame(1, capture())
    connection = sqlite3.connect(store.root / "m" / "mission.sqlite")
    ((quaternion,),) = connection.execute("SELECT q_cam2enu_wxyz FROM frames").fetchall()
    connection.close()
    np.testing.assert_allclose(R_from_quaternion(json.loads(quaternion)), capture().R_cam2enu, atol=1e-12)


async def test_a_second_record_of_a_step_replaces_the_first(store: Store) -> None:
    async with store.record() as recorder:
        await recorder.record_step(step_record(1), {})
        await recorder.record_step(replace(step_record(1), work_ms=75.0), {"best": 2})
    with store.read() as reader:
        assert [step.work_ms for step in reader.steps()] == [75.0]
        assert reader.strategy_state(1) == {"best": 2}


async def test_a_running_mission_shows_what_has_been_flushed(store: Store) -> None:
    async with store.record() as recorder:
        with store.read() as reader:
            for step in range(1, 4):
                await recorder.record_step(step_record(step), {})
                await recorder.flush()
                assert [record.step for record in reader.steps()] == list(range(1, step + 1))
            assert reader.outcome() is None
            assert reader.last_snapshot() is None
    with store.read() as reader:  # closed while somebody was reading
        assert len(reader.steps()) == 3


async def test_readers_and_a_killed_writer_are_covered_by_a_write_ahead_log(
    store: Store, recorder: MissionRecorder
) -> None:
    await recorder.record_event(notice_event(1))
    await recorder.flush()
    connection = sqlite3.connect(store.root / "m" / "mission.sqlite")
    assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    connection.close()


async def test_a_closed_mission_is_one_plain_file(store: Store) -> None:
    async with store.record() as recorder:
        await recorder.record_event(notice_event(1))
    assert sorted(path.name for path in (store.root / "m").iterdir()) == [
        "frames",
        "manifest.json",
        "mavlink",
        "mission.sqlite",
        "pictures",
    ]


async def test_many_events_arrive_in_order(store: Store) -> None:
    async with store.record() as recorder:
        for seq in range(1, 1001):
            await recorder.record_event(notice_event(seq))
    with store.read() as reader:
        assert [event.seq for event in reader.events()] == list(range(1, 1001))


async def test_a_cancelled_mission_keeps_what_was_queued(store: Store) -> None:
    recorded = asyncio.Event()

    async def mission() -> None:
        async with store.record() as recorder:
            for seq in range(1, QUEUE_SIZE):
                await recorder.record_event(notice_event(seq))
            recorded.set()
            await asyncio.Event().wait()

    task = asyncio.create_task(mission())
    await recorded.wait()
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    with store.read() as reader:
        assert len(list(reader.events())) == QUEUE_SIZE - 1


@pytest.mark.parametrize("change", ["UPDATE actions SET utc_s = 0", "DELETE FROM actions"])
async def test_the_audit_log_cannot_be_changed(store: Store, change: str) -> None:
    async with store.record() as recorder:
        await recorder.record_action(ActionRecord(7.0, Action.HOLD, None, ()))
    connection = sqlite3.connect(store.root / "m" / "mission.sqlite")
    with pytest.raises(sqlite3.IntegrityError, match="append-only"):
        connection.execute(change)
    connection.close()


# --- storage that fails or is slow ----------------------------------------------------------------------------------


async def test_a_full_disk_is_told_once_and_costs_records_only(
    store: Store, disk: FullDisk, recorder: MissionRecorder
) -> None:
    disk.full = True
    for seq in (1, 2, 3):
        await recorder.record_event(notice_event(seq))
        with pytest.raises(RecordingError, match="disk is full"):
            await recorder.flush()
    assert [notice.severity for notice in store.notices] == [Severity.CRITICAL]

    disk.full = False
    await recorder.record_event(notice_event(4))
    await recorder.flush()
    assert [notice.severity for notice in store.notices] == [Severity.CRITICAL, Severity.WARNING]
    assert "3 records" in store.notices[-1].text
    with store.read() as reader:
        assert [event.seq for event in reader.events()] == [4]


async def test_one_record_that_fails_does_not_take_its_neighbours(
    store: Store, recorder: MissionRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_room(path: Path, _: bytes) -> int:
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(Path, "write_bytes", no_room)
    await recorder.record_event(notice_event(1))
    await recorder.record_frame(1, capture())
    await recorder.record_event(notice_event(2))
    with pytest.raises(RecordingError, match="No space left"):
        await recorder.flush()
    with store.read() as reader:
        assert [event.seq for event in reader.events()] == [1, 2]
        assert reader.frames() == ()


async def test_a_state_that_cannot_be_encoded_is_reported(store: Store, recorder: MissionRecorder) -> None:
    await recorder.record_step(step_record(1), {"strategy": object()})
    with pytest.raises(RecordingError, match="cannot record a object"):
        await recorder.flush()
    assert len(store.notices) == 1


async def test_a_slow_disk_makes_the_caller_wait_and_loses_nothing(
    store: Store, recorder: MissionRecorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    released = threading.Event()
    write: Callable[..., None] = MissionDatabase.write

    def write_when_released(database: MissionDatabase, writes: Sequence[Write]) -> None:
        released.wait()
        write(database, writes)

    monkeypatch.setattr(MissionDatabase, "write", write_when_released)
    count = 0

    async def record_more_than_fits() -> None:
        nonlocal count
        for seq in range(1, 2 * QUEUE_SIZE + 2):
            await recorder.record_event(notice_event(seq))
            count = seq

    task = asyncio.create_task(record_more_than_fits())
    try:
        for _ in range(10 * QUEUE_SIZE):
            await asyncio.sleep(0)
        assert count <= 2 * QUEUE_SIZE  # one batch at the writer, one queue full
        assert not task.done()
    finally:
        released.set()
    await task
    await recorder.flush()
    with store.read() as reader:
        assert len(list(reader.events())) == 2 * QUEUE_SIZE + 1
