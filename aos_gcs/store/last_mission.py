"""The mission recorded last, and whether it ended."""

from __future__ import annotations

from pathlib import Path

from aos_gcs.errors import InputDataError
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import DATABASE_NAME


def unfinished_mission(missions: Path) -> str | None:
    """Return the name of the mission recorded last if it has no outcome: its program was killed, or still runs.

    A record that cannot be read counts as unfinished.

    Args:
        missions: folder of all missions, which need not exist.
    """
    folders = sorted(file.parent for file in missions.glob(f"*/{DATABASE_NAME}"))
    if not folders:
        return None
    try:
        with MissionReader(folders[-1]) as reader:
            has_ended = reader.outcome() is not None
    except InputDataError:
        has_ended = False
    return None if has_ended else folders[-1].name
