"""A record that grows, and a wall on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from aos_gcs.wall.board import Wall
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.wall import CountedWorker, GrowingRecord, make_wall


@pytest.fixture
def record(tmp_path: Path) -> Iterator[GrowingRecord]:
    record = GrowingRecord(tmp_path)
    yield record
    record.close()


@pytest.fixture
def worker() -> CountedWorker:
    return CountedWorker()


@pytest.fixture
def wall(record: GrowingRecord, worker: CountedWorker) -> Wall:
    return make_wall(ScriptedMission(HandClock()), record.folder, worker)
