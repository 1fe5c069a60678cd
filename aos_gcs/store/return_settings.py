"""Return settings of vehicles that missions before have changed and not restored, as when their program was killed."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from pathlib import Path

from aos_gcs.errors import InputDataError, RecordingError
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.store.database import MissionDatabase
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import DATABASE_NAME

_MISSIONS = 20
"""Number of missions, from the latest on, that are looked at."""


def unrestored_settings(missions: Path) -> dict[int, Mapping[str, float]]:
    """Return the settings that vehicles had before a mission changed them and did not restore them, by vehicle.

    Records that cannot be read are skipped.

    Args:
        missions: folder of all missions, which need not exist.
    """
    unrestored: dict[int, Mapping[str, float]] = {}
    for _, records in _latest(missions):
        for record in records:
            if record.is_restored:
                unrestored.pop(record.vehicle_id, None)
            else:
                unrestored.setdefault(record.vehicle_id, record.former)
    return unrestored


def note_restored(missions: Path, record: SettingsRecord) -> None:
    """Note in the record of the last mission that has changed a vehicle's settings that they are its own again.

    Raises:
        RecordingError: the record cannot be written.
    """
    changing = [folder for folder, records in _latest(missions) if record.vehicle_id in {r.vehicle_id for r in records}]
    for folder in changing[-1:]:
        try:
            database = MissionDatabase.open_ended(folder)
            try:
                database.write([lambda opened: opened.add_settings(record)])
            finally:
                database.close()
        except (OSError, sqlite3.Error) as error:
            raise RecordingError(f"it was set back, but that cannot be noted in {folder}: {error}") from error


def _latest(missions: Path) -> list[tuple[Path, tuple[SettingsRecord, ...]]]:
    """Return the folders of the latest missions, oldest first, with what each has changed."""
    found = []
    for file in sorted(missions.glob(f"*/{DATABASE_NAME}"))[-_MISSIONS:]:
        try:
            with MissionReader(file.parent) as reader:
                found.append((file.parent, reader.settings()))
        except InputDataError:
            continue
    return found
