"""Return settings of vehicles that missions before have changed and not restored, as when their program was killed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from aos_gcs.errors import InputDataError
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
    for file in sorted(missions.glob(f"*/{DATABASE_NAME}"))[-_MISSIONS:]:
        try:
            with MissionReader(file.parent) as reader:
                records = reader.settings()
        except InputDataError:
            continue
        for record in records:
            if record.is_restored:
                unrestored.pop(record.vehicle_id, None)
            else:
                unrestored.setdefault(record.vehicle_id, record.former)
    return unrestored
