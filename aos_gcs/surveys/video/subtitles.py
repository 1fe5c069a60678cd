"""Telemetry in the subtitles of a drone's video: SubRip files of DJI, or the same lines as a track of the video.

A cue holds named values, such as ``[latitude: 47.5] [longitude: 14.2] [rel_alt: 35.1 abs_alt: 612.4] [gb_yaw: 12.0
gb_pitch: -90.0 gb_roll: 0.0]``. Which of them there are differs between aircraft; only some have the gimbal's angles.
Others write a list, such as ``GPS (14.200000, 47.500000, 16), D 80.50m, H 35.10m, G.PRY (-90.0°, 0.0°, 12.0°)``, with
the longitude first, the height above the place of takeoff, and the gimbal's pitch, roll and yaw.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.heights import AboveHomeM, AmslM

MAX_BYTES = 200_000_000
"""Largest subtitle file that is read: four hours at 60 cues a second take less."""

_CUE_TIMES = re.compile(
    r"^[ \t]*(\d{1,4}):([0-5]?\d):([0-5]?\d)[,.](\d{3})[ \t]*-->[ \t]*\d{1,4}:\d{1,2}:\d{1,2}[,.]\d{3}", re.MULTILINE
)
_VALUE = re.compile(r"(?<![A-Za-z_])([A-Za-z_]{1,40})\s{0,8}:\s{0,8}(-?\d{1,20}(?:\.\d{1,20})?)(?![\d./]|,\d)")
"""Name and number. A decimal comma is none: what stands before it would be taken for the whole."""
_LISTED_PLACE = re.compile(r"\bGPS \((-?\d{1,3}\.\d{5,15}), (-?\d{1,3}\.\d{5,15}), \d{1,3}\)")
"""Place in a list; with four decimals, 11 m, it is none."""
_LISTED_HEIGHT = re.compile(r"\bH (-?\d{1,6}(?:\.\d{1,9})?)m\b")
_ANGLE = r"(-?\d{1,3}(?:\.\d{1,9})?)°"
_LISTED_GIMBAL = re.compile(rf"\bG\.PRY \({_ANGLE}, {_ANGLE}, {_ANGLE}\)")
_LISTED = (
    (_LISTED_PLACE, ("longitude", "latitude")),
    (_LISTED_HEIGHT, ("rel_alt",)),
    (_LISTED_GIMBAL, ("gb_pitch", "gb_roll", "gb_yaw")),
)
"""Values of a list, and the names that they have in other cues."""
MAX_ALTITUDE_M = 20_000.0
"""Altitudes beyond are errors of the recording."""
MAX_BACK_S = 1.0
"""Cues may stand this much before the one in front of them."""
_LONGITUDE = ("longitude", "longtitude")
"""``longtitude`` is what the firmware of some aircraft says."""
_ANGLES = ("gb_yaw", "gb_pitch", "gb_roll")
_FULL_TURN_DEG = 360.0


@dataclass(frozen=True, slots=True)
class CueTelemetry:
    """Telemetry of one cue; None where it is not recorded."""

    time_s: float
    """Time in the video at which the cue begins."""
    latitude_deg: float
    longitude_deg: float
    relative_altitude_m: AboveHomeM | None
    """Height above the place of takeoff."""
    altitude_amsl_m: AmslM | None
    """Altitude as recorded by the aircraft, in its own altitude reference."""
    gimbal_deg: tuple[float, float, float] | None
    """Yaw, pitch and roll of the optical axis about north, east and down; -90 is down."""
    zoom: float


@dataclass(frozen=True, slots=True)
class Attitude:
    """Attitude of a camera whose gimbal's angles are not recorded, degrees; -90 is down."""

    yaw_deg: float | None
    """None: along the course."""
    pitch_deg: float
    roll_deg: float = 0.0


def read_subtitle_file(path: Path) -> list[CueTelemetry]:
    """Read the telemetry of a SubRip file, in the order of its times; cues without a fix are left out.

    Raises:
        InputDataError: if it cannot be read, or no cue has a position.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputDataError(f"The subtitle file {path} cannot be read: {error.strerror}.") from error
    if len(content) > MAX_BYTES:
        raise InputDataError(
            f"The subtitle file {path} has more than {MAX_BYTES / 1e6:.0f} MB, too many for subtitles."
        )
    text = content.decode(encoding="utf-8-sig", errors="replace")
    return samples_of(_cues(text.replace("\r\n", "\n").replace("\r", "\n")), str(path))


def samples_of(cues: Iterator[tuple[float, str]], source: str) -> list[CueTelemetry]:
    """Return the telemetry of cues, times (s) and texts; ``source`` names them in errors.

    Raises:
        InputDataError: if no cue has a position, or they are those of several videos.
    """
    samples: list[CueTelemetry] = []
    count, latest_s = 0, -math.inf
    for time_s, text in cues:
        count += 1
        if time_s < latest_s - MAX_BACK_S:
            raise InputDataError(
                f"The times of {source} go back from {latest_s:.1f} s to {time_s:.1f} s at cue {count}: it belongs to "
                "several videos. Extract each video with its own subtitles."
            )
        latest_s = max(latest_s, time_s)
        sample = _sample(time_s, _values(text))
        if sample is not None:
            samples.append(sample)
    if not samples:
        raise InputDataError(
            f"None of the {count} cues of {source} has a position ('[latitude: ...] [longitude: ...]', or 'GPS (...)' "
            "to five decimals or more): the aircraft had no fix, or writes its positions in another way."
        )
    return sorted(samples, key=lambda sample: sample.time_s)


def _cues(text: str) -> Iterator[tuple[float, str]]:
    times = None
    for following in _CUE_TIMES.finditer(text):
        if times is not None:
            yield _time_s(times), text[times.end() : following.start()]
        times = following
    if times is not None:
        yield _time_s(times), text[times.end() :]


def _time_s(times: re.Match[str]) -> float:
    hours, minutes, seconds, thousandths = map(int, times.groups())
    return 3600.0 * hours + 60.0 * minutes + seconds + thousandths / 1000.0


def _values(text: str) -> dict[str, float]:
    """Return the values of a cue by name; those of a list by the names that others have."""
    values = {name.lower(): float(value) for name, value in _VALUE.findall(text)}
    for pattern, names in _LISTED:
        if (found := pattern.search(text)) is not None:
            values |= zip(names, map(float, found.groups()), strict=True)
    return values


def _sample(time_s: float, values: Mapping[str, float]) -> CueTelemetry | None:
    latitude_deg = values.get("latitude", math.nan)
    longitude_deg = next((values[name] for name in _LONGITUDE if name in values), math.nan)
    is_place = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
    if not is_place or latitude_deg == longitude_deg == 0.0:
        return None
    gimbal = [values.get(name, math.nan) for name in _ANGLES]
    relative_m = _altitude_m(values.get("rel_alt"))
    altitude_m = _altitude_m(values.get("abs_alt", values.get("altitude")))
    return CueTelemetry(
        time_s,
        latitude_deg,
        longitude_deg,
        None if relative_m is None else AboveHomeM(relative_m),
        None if altitude_m is None else AmslM(altitude_m),
        None if any(not abs(angle) <= _FULL_TURN_DEG for angle in gimbal) else (gimbal[0], gimbal[1], gimbal[2]),
        values.get("dzoom_ratio", 1.0),
    )


def _altitude_m(value: float | None) -> float | None:
    return value if value is not None and abs(value) <= MAX_ALTITUDE_M else None
