"""A recorded mission in one object."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from aos_gcs.mission.model.actions import ActionRecord
from aos_gcs.mission.model.events import EventKind, NoticeRecord
from aos_gcs.mission.model.phase import OutcomeRecord, Phase
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord
from aos_gcs.store.reader import MissionReader


@dataclass(frozen=True, slots=True)
class PhaseSpan:
    """A phase that the mission went through."""

    phase: Phase
    start_s: float
    """Clock seconds since the start action, as of the first recorded snapshot in this phase."""
    end_s: float
    """Clock seconds since the start action, as of the last snapshot in this phase."""


@dataclass(frozen=True, slots=True)
class FileSize:
    """A file of the mission, or a folder of it with all its files."""

    path: str
    """Relative to the mission's folder."""
    files: int
    size_bytes: int


@dataclass(frozen=True, slots=True)
class FrameCount:
    """Number of frames of one vehicle."""

    vehicle_id: int
    frames: int
    time_sigma_s: tuple[float, float] | None
    """Smallest and largest standard deviation of the times that the poses are of; None where none was reported."""


@dataclass(frozen=True, slots=True)
class MissionSummary:
    """Summary of a recorded mission."""

    folder: str
    manifest: Mapping[str, object]
    phases: tuple[PhaseSpan, ...]
    steps: tuple[StepRecord, ...]
    final: MissionSnapshot | None
    """The last recorded snapshot, with vehicles and target estimate."""
    notices: tuple[NoticeRecord, ...]
    actions: tuple[ActionRecord, ...]
    settings: tuple[SettingsRecord, ...]
    frames: tuple[FrameCount, ...]
    outcome: OutcomeRecord | None
    """None while the mission goes on, and when its program was killed."""
    files: tuple[FileSize, ...]


def summarise(reader: MissionReader) -> MissionSummary:
    """Return the summary of a mission.

    Raises:
        InputDataError: a part of the mission is damaged.
    """
    return MissionSummary(
        folder=str(reader.folder),
        manifest=reader.manifest(),
        phases=tuple(_phases(reader)),
        steps=reader.steps(),
        final=reader.last_snapshot(),
        notices=tuple(event.data for event in reader.events(EventKind.NOTICE) if isinstance(event.data, NoticeRecord)),
        actions=reader.actions(),
        settings=reader.settings(),
        frames=tuple(_frame_counts(reader)),
        outcome=reader.outcome(),
        files=tuple(_file_size(reader.folder, path) for path in sorted(reader.folder.iterdir())),
    )


def _phases(reader: MissionReader) -> Iterator[PhaseSpan]:
    snapshots = (event.data for event in reader.events(EventKind.SNAPSHOT) if isinstance(event.data, MissionSnapshot))
    for phase, group in groupby(snapshots, key=lambda snapshot: snapshot.phase):
        times_s = [snapshot.elapsed_s for snapshot in group]
        yield PhaseSpan(phase, times_s[0], times_s[-1])


def _frame_counts(reader: MissionReader) -> Iterator[FrameCount]:
    entries = sorted(reader.frames(), key=lambda entry: entry.vehicle_id)
    for vehicle_id, group in groupby(entries, key=lambda entry: entry.vehicle_id):
        sigmas_s = [entry.time_sigma_s for entry in group]
        told_s = [sigma_s for sigma_s in sigmas_s if sigma_s is not None]
        yield FrameCount(vehicle_id, len(sigmas_s), (min(told_s), max(told_s)) if told_s else None)


def _file_size(folder: Path, path: Path) -> FileSize:
    sizes = [_size_bytes(path)] if path.is_file() else [_size_bytes(file) for file in path.rglob("*") if file.is_file()]
    return FileSize(path.relative_to(folder).as_posix(), len(sizes), sum(sizes))


def _size_bytes(path: Path) -> int:
    try:
        return path.stat().st_size
    except FileNotFoundError:  # a temporary file of a mission that is being recorded
        return 0
