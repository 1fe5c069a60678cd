"""The sorties of an operation, as their folders tell."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.mission.model.operation import SortieRecord
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.schema import DATABASE_NAME, MANIFEST_NAME

_MAX_SORTIES: Final = 100
"""Sorties that are listed, the latest ones."""


def read_operation(folder: Path) -> tuple[SortieRecord, ...]:
    """Return the sorties of the operation that a mission belongs to, in the order of their numbers.

    A mission that no other one has followed is the only sortie of its operation. Sorties whose folders cannot be read
    are left out.

    Args:
        folder: folder of one mission; those of the others lie beside it.

    Raises:
        InputDataError: the mission itself cannot be read.
    """
    operation, number = _place_of(folder)
    sorties = [_sortie(folder, number)]
    for other in folder.resolve().parent.iterdir():
        if other.name == folder.resolve().name or not (other / DATABASE_NAME).is_file():
            continue
        try:
            its_operation, its_number = _place_of(other)
            if its_operation == operation:
                sorties.append(_sortie(other, its_number))
        except InputDataError:
            continue
    return tuple(sorted(sorties, key=lambda sortie: (sortie.number, sortie.mission_id))[-_MAX_SORTIES:])


def _place_of(folder: Path) -> tuple[str, int]:
    """Return the operation of a mission, and its number there."""
    path = folder / MANIFEST_NAME
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputDataError(f"cannot read {path}: {error}") from error
    if not isinstance(manifest, dict):
        raise InputDataError(f"cannot read {path}: it is not a JSON object")
    operation, number = manifest.get("operation"), manifest.get("sortie")
    is_told = isinstance(operation, str) and isinstance(number, int) and number > 0
    return (str(operation), int(number)) if is_told else (folder.resolve().name, 1)  # type: ignore[arg-type]


def _sortie(folder: Path, number: int) -> SortieRecord:
    with MissionReader(folder) as reader:
        last, outcome, index = reader.last_snapshot(), reader.outcome(), reader.event_index()
    own = [] if last is None else [finding for finding in last.findings if not finding.found_in]
    return SortieRecord(
        mission_id=folder.resolve().name if last is None else last.mission_id,
        number=number,
        folder=folder.resolve().name,
        start_utc_s=index[0].utc_s if index else 0.0,
        duration_s=0.0 if last is None else last.elapsed_s,
        outcome=Outcome.OPEN if outcome is None else outcome.outcome,
        steps=0 if last is None else last.step,
        covered_fraction=None if last is None else last.covered_fraction,
        findings=len(own),
        confirmed=sum(finding.status is FindingStatus.CONFIRMED for finding in own),
    )
