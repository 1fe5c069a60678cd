"""Telemetry in the subtitles of a drone's video: SubRip files of DJI, or the same lines as a track of the video.

A cue holds named values, such as ``[latitude: 47.5] [longitude: 14.2] [rel_alt: 35.1 abs_alt: 612.4] [gb_yaw: 12.0
gb_pitch: -90.0 gb_roll: 0.0]``. Which of them there are differs between aircraft; only some have the gimbal's angles.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.errors import InputDataError

MAX_BYTES = 200_000_000
"""Largest subtitle file that is read: four hours at 60 cues a second take less."""

_CUE = re.compile(
    r"(\d+):([0-5]?\d):([0-5]?\d)[,.](\d{3})\s*-->\s*\d+:\d+:\d+[,.]\d{3}[^\n]*\n(.*?)(?=\n\s*\n|\Z)", re.DOTALL
)
_VALUE = re.compile(r"([A-Za-z_]+)\s*:\s*(-?\d+(?:\.\d+)?)(?![\d./])")
_LONGITUDE = ("longitude", "longtitude")
"""``longtitude`` is what the firmware of some aircraft says."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Telemetry of one cue; None where it is not recorded."""

    time_s: float
    """Time in the video at which the cue begins."""
    latitude_deg: float
    longitude_deg: float
    relative_altitude_m: float | None
    """Height above the place of takeoff."""
    altitude_amsl_m: float | None
    """Altitude as recorded by the aircraft, in its own altitude reference."""
    gimbal_deg: tuple[float, float, float] | None
    """Yaw, pitch and roll of the optical axis about north, east and down; -90 is down."""
    zoom: float


def read_subtitle_file(path: Path) -> list[Sample]:
    """Read the telemetry of a SubRip file, in the order of its times; cues without a fix are left out.

    Raises:
        InputDataError: if it cannot be read, or no cue has a position.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputDataError(f"The subtitle file {path} has more than {MAX_BYTES / 1e6:.0f} MB: it is none.")
        text = path.read_text(encoding="utf-8-sig", errors="replace")
    except OSError as error:
        raise InputDataError(f"The subtitle file {path} cannot be read: {error.strerror}.") from error
    return samples_of(_cues(text.replace("\r\n", "\n")), str(path))


def samples_of(cues: Iterator[tuple[float, str]], source: str) -> list[Sample]:
    """Return the telemetry of cues, times (s) and texts; ``source`` names them in errors.

    Raises:
        InputDataError: if no cue has a position.
    """
    samples: list[Sample] = []
    count = 0
    for time_s, text in cues:
        count += 1
        sample = _sample(time_s, {name.lower(): float(value) for name, value in _VALUE.findall(text)})
        if sample is not None:
            samples.append(sample)
    if not samples:
        raise InputDataError(
            f"None of the {count} cues of {source} has a position ('[latitude: ...] [longitude: ...]'): the aircraft "
            "had no fix, or writes its positions in another way."
        )
    return sorted(samples, key=lambda sample: sample.time_s)


def _cues(text: str) -> Iterator[tuple[float, str]]:
    for cue in _CUE.finditer(text):
        hours, minutes, seconds, thousandths, lines = cue.groups()
        yield 3600.0 * int(hours) + 60.0 * int(minutes) + int(seconds) + int(thousandths) / 1000.0, lines


def _sample(time_s: float, values: Mapping[str, float]) -> Sample | None:
    latitude_deg = values.get("latitude", math.nan)
    longitude_deg = next((values[name] for name in _LONGITUDE if name in values), math.nan)
    is_place = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
    if not is_place or latitude_deg == longitude_deg == 0.0:
        return None
    gimbal = [values.get(name, math.nan) for name in ("gb_yaw", "gb_pitch", "gb_roll")]
    return Sample(
        time_s,
        latitude_deg,
        longitude_deg,
        values.get("rel_alt"),
        values.get("abs_alt", values.get("altitude")),
        None if any(map(math.isnan, gimbal)) else (gimbal[0], gimbal[1], gimbal[2]),
        values.get("dzoom_ratio", 1.0),
    )
