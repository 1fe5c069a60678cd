import os
from pathlib import Path

from aos_gcs.store.changes import RecordChanges
from aos_gcs.store.schema import DATABASE_NAME
from tests.fakes.wall import START_UTC_S, GrowingRecord


def test_a_record_is_read_once_more_after_each_change_and_then_left(tmp_path: Path) -> None:
    changes = RecordChanges()
    record = GrowingRecord(tmp_path)
    assert [changes.may_have_come(record.folder) for _ in range(4)] == [True, True, False, False]
    record.add(1, START_UTC_S)
    assert [changes.may_have_come(record.folder) for _ in range(3)] == [True, True, False]
    record.close()


def test_a_change_that_leaves_the_size_is_noticed(tmp_path: Path) -> None:
    file = tmp_path / DATABASE_NAME
    file.write_bytes(b"one")
    changes = RecordChanges()
    assert [changes.may_have_come(tmp_path) for _ in range(3)] == [True, True, False]
    os.utime(file, ns=(1, file.stat().st_mtime_ns + 1))
    assert changes.may_have_come(tmp_path)


def test_another_folder_is_another_record(tmp_path: Path) -> None:
    changes = RecordChanges()
    assert [changes.may_have_come(tmp_path / "first") for _ in range(3)] == [True, True, False]
    assert changes.may_have_come(tmp_path / "second")
