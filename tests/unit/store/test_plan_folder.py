"""Saved plans on a disk that is full."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from aos_gcs.errors import RecordingError
from aos_gcs.store.plan_folder import PlanFolder


def test_a_full_disk_leaves_the_former_plan_and_nothing_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plans = PlanFolder(tmp_path)
    plans.write("north", "before")
    write_text = Path.write_text

    def full(path: Path, text: str, encoding: str) -> int:
        write_text(path, text[:2], encoding=encoding)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(RecordingError, match="No space left on device; free some space"):
        plans.write("north", "after")
    assert [(path.name, path.read_text("utf-8")) for path in tmp_path.iterdir()] == [("north.json", "before")]
