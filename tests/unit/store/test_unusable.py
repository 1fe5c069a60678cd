"""Mission folders that cannot be used: what is refused, and how it is said."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from tests.fakes.mission_store import Store
from tests.fakes.records import capture, notice_event, step_record


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "missions")


@pytest.mark.parametrize("mission_id", ["../m", "a/b", "", ".."])
async def test_a_mission_id_is_a_folder_name(store: Store, mission_id: str) -> None:
    with pytest.raises(ConfigurationError, match="not a valid folder name"):
        async with store.record(mission_id):
            pass


async def test_a_mission_is_never_written_over_another(store: Store) -> None:
    async with store.record():
        pass
    with pytest.raises(ConfigurationError, match="exists already"):
        async with store.record():
            pass


async def test_a_root_that_is_a_file_is_refused(store: Store) -> None:
    store.root.write_text("")
    with pytest.raises(ConfigurationError, match="cannot be made"):
        async with store.record():
            pass


def test_a_folder_without_a_mission_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputDataError, match=r"not a mission folder: it contains no mission\.sqlite"):
        MissionReader(tmp_path)


@pytest.mark.parametrize("content", [b"", b"not a database, but long enough to be taken for one" * 50])
def test_a_file_that_is_no_mission_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "mission.sqlite").write_bytes(content)
    with pytest.raises(InputDataError, match="damaged or not a mission"):
        MissionReader(tmp_path)


@pytest.mark.parametrize(
    ("damage", "reading", "reason"),
    [
        ("UPDATE steps SET record = '{'", MissionReader.steps, "step 1 cannot be read"),
        ("UPDATE steps SET record = '{}'", MissionReader.steps, "StepRecord: missing"),
        ("UPDATE events SET kind = 'song'", lambda reader: list(reader.events()), "event 1 cannot be read"),
        ("DROP TABLE frames", MissionReader.frames, "no such table"),
    ],
)
async def test_damaged_rows_name_themselves(
    store: Store, damage: str, reading: Callable[[MissionReader], object], reason: str
) -> None:
    async with store.record() as recorder:
        await recorder.record_event(notice_event(1))
        await recorder.record_step(step_record(1), {})
    connection = sqlite3.connect(store.root / "m" / "mission.sqlite")
    connection.execute(damage)
    connection.commit()
    connection.close()
    with store.read() as reader, pytest.raises(InputDataError, match=reason):
        reading(reader)


async def test_damaged_files_name_themselves(store: Store) -> None:
    async with store.record() as recorder:
        await recorder.record_frame(1, capture())
    with store.read() as reader:
        (entry,) = reader.frames()
        entry.path.write_bytes(entry.path.read_bytes()[:50])
        with pytest.raises(InputDataError, match=entry.path.name):
            entry.load()
        entry.path.unlink()
        with pytest.raises(InputDataError, match=entry.path.name):
            entry.load()
        (reader.folder / "manifest.json").write_text("[]")
        with pytest.raises(InputDataError, match=r"manifest\.json: it is not a JSON object"):
            reader.manifest()
        with pytest.raises(InputDataError, match="no step 7"):
            reader.strategy_state(7)


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), sqlite3.OperationalError("disk is full")])
async def test_a_folder_that_cannot_be_filled_is_not_left_behind(
    store: Store, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def full(*_: object) -> None:
        raise error

    with monkeypatch.context() as patched:
        patched.setattr(MissionDatabase, "_connect", full)
        with pytest.raises(ConfigurationError, match="and the space on the disk"):
            async with store.record("m"):
                pass
    assert not (store.root / "m").exists()
    async with store.record("m"):
        pass
