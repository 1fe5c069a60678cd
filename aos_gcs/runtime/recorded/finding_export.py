"""Findings of a recorded mission as files."""

from __future__ import annotations

from pathlib import Path

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.exports.finding_files import FORMATS, PlacedFinding
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.store.reader import MissionReader


def encode_findings(folder: Path, suffix: str) -> str:
    """Return the findings of a mission folder as a file of the format that a suffix names, such as ``.kml``.

    Raises:
        ConfigurationError: there is no such format.
        InputDataError: the record is damaged, or its place on the earth is not known.
    """
    name = suffix.removeprefix(".").lower()
    if name not in FORMATS:
        raise ConfigurationError(
            f"--findings: {suffix or 'a file without suffix'} is not among .{', .'.join(FORMATS)}."
        )
    with MissionReader(folder) as reader:
        snapshot = reader.last_snapshot()
    if snapshot is None or snapshot.origin is None:
        raise InputDataError(f"{folder} does not say where on the earth it was flown; its findings have no place")
    frame = LocalFrame(snapshot.origin)
    _, write = FORMATS[name]
    started_utc_s = snapshot.started_utc_s
    return write(
        [PlacedFinding(one, frame.to_geodetic(one.position_enu_m), started_utc_s) for one in snapshot.findings]
    )
