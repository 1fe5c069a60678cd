# ruff: noqa: S608 - the names of tables and columns are our own
"""Damaged mission folders are read as far as they go, or refused in words."""

from __future__ import annotations

import asyncio
import shutil
import sqlite3
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import AosError, InputDataError
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.store.codec import encode
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay
from aos_gcs.store.summary import summarise
from tests.fakes.recording import record
from tests.fakes.records import capture, frame_row, step_record
from tests.fuzz import SEED, damage

TABLES = ("events", "steps", "frames", "actions", "settings", "outcome")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small mission folder with something of everything."""
    folder = tmp_path_factory.mktemp("whole") / "mission"
    asyncio.run(record(folder, length_s=25, vehicles=2))
    database = MissionDatabase(folder.parent / "rows", {})
    row = frame_row(folder.parent / "rows", 1, capture(1))
    database.write(
        [
            lambda database: database.add_frame(row),
            lambda database: database.add_step(step_record(1), {"weights": np.ones(3)}),
        ]
    )
    database.close()
    with closing(sqlite3.connect(folder / "mission.sqlite")) as connection:
        connection.execute("ATTACH ? AS rows", [str(folder.parent / "rows" / "mission.sqlite")])
        for table in ("frames", "steps"):
            connection.execute(f"INSERT OR REPLACE INTO {table} SELECT * FROM rows.{table}")
        connection.commit()
    shutil.copytree(folder.parent / "rows" / "frames", folder / "frames", dirs_exist_ok=True)
    return folder


def spoil(folder: Path, rng: np.random.Generator) -> None:
    """Damage one file of a mission, or one value of its database."""
    if rng.random() < 0.5:
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        path = files[rng.integers(len(files))]
        path.write_bytes(damage(path.read_bytes(), rng))
        return
    with closing(sqlite3.connect(folder / "mission.sqlite")) as connection:
        table = TABLES[rng.integers(len(TABLES))]
        rows = [row for (row,) in connection.execute(f"SELECT rowid FROM {table}")]
        columns = [column[1] for column in connection.execute(f"PRAGMA table_info({table})")]
        if not rows:
            return
        row, column = rows[rng.integers(len(rows))], columns[rng.integers(len(columns))]
        (value,) = connection.execute(f"SELECT {column} FROM {table} WHERE rowid = ?", [row]).fetchone()
        with suppress(sqlite3.Error):  # the database has rules of its own
            connection.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", [another(value, rng), row])
            connection.commit()


def another(value: object, rng: np.random.Generator) -> object:
    choices = (None, -1, 2**62, float("inf"), "", "[]", "{}", "null", "1e999", b"\xff", "../../x", "[" * 2000)
    if isinstance(value, str) and rng.random() < 0.7:
        return damage(value.encode(), rng).decode("utf-8", "replace")
    return choices[rng.integers(len(choices))]


async def read_all(folder: Path) -> None:
    """Read everything that the program reads of a mission, each part on its own."""
    with suppress(AosError), MissionReader(folder) as reader:
        for read in (
            lambda: encode(summarise(reader)),
            lambda: list(reader.events()),
            lambda: reader.strategy_state(1),
            lambda: [entry.load() for entry in reader.frames()],
            lambda: [reader.picture(1, kind) for kind in PictureKind],
            lambda: reader.step(1),
        ):
            with suppress(AosError):
                read()
        replay = MissionReplay(reader, LoopClock())
        for time_s in (0.0, 5.0, 1e9):
            with suppress(AosError):
                replay.seek(time_s=time_s)
        with suppress(AosError):
            encode([replay.snapshot(), replay.timeline(), *replay.steps()])
        for kind in PictureKind:
            replay.picture(kind)


def test_a_damaged_schema_that_is_no_text_is_refused_in_words(whole: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(whole, tmp_path / "mission")
    database = folder / "mission.sqlite"
    content = database.read_bytes()
    assert content.count(b"CREATE TABLE steps") == 1
    database.write_bytes(content.replace(b"CREATE TABLE steps", b"CREATE \xd3\xd3\xd3\xd3\xd3 steps"))
    with pytest.raises(InputDataError, match="is damaged"):
        MissionReader(folder)


@pytest.mark.parametrize("column", ["step", "vehicle_id", "time_sigma_s", "digest"])
def test_frames_with_values_of_another_type_are_refused_in_words(whole: Path, tmp_path: Path, column: str) -> None:
    folder = shutil.copytree(whole, tmp_path / "mission")
    with closing(sqlite3.connect(folder / "mission.sqlite")) as connection:
        connection.execute(f"UPDATE frames SET {column} = ?", [b"\xff"])
        connection.commit()
    with MissionReader(folder) as reader, pytest.raises(InputDataError, match=f"frames cannot be read: {column} is"):
        summarise(reader)


@pytest.mark.parametrize("count", [40, pytest.param(6000, marks=[pytest.mark.slow, pytest.mark.timeout(3600)])])
def test_no_damage_of_a_mission_folder_breaks_its_readers(whole: Path, tmp_path: Path, count: int) -> None:
    folder = tmp_path / "mission"
    for number in range(count):
        seed = SEED + number
        rng = np.random.default_rng(seed)
        shutil.copytree(whole, folder)
        for _ in range(rng.integers(1, 4)):
            with suppress(sqlite3.Error):
                spoil(folder, rng)
        try:
            asyncio.run(read_all(folder))
        except Exception as error:
            raise AssertionError(f"AOS_GCS_FUZZ_SEED={seed}") from error
        shutil.rmtree(folder)
