"""Position, time and camera of a photograph from its EXIF."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from aos_gcs.geometry.heights import AmslM

FULL_FRAME_DIAGONAL_MM = math.hypot(36.0, 24.0)
"""EXIF compares focal lengths with 35 mm film by the diagonals of the pictures (CIPA DCG-001)."""

EXIF_IFD, GPS_IFD = 0x8769, 0x8825

_MILLIMETRES = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}
"""Per unit of the focal plane's resolution: inch, cm, mm, µm."""

_MODEL, _ORIENTATION, _SOFTWARE = 0x0110, 0x0112, 0x0131
_FOCAL_LENGTH, _FOCAL_LENGTH_35MM, _DIGITAL_ZOOM = 0x920A, 0xA405, 0xA404
_FOCAL_PLANE_X, _FOCAL_PLANE_UNIT, _ORIGINAL_WIDTH = 0xA20E, 0xA210, 0xA002
_TAKEN_AT, _TAKEN_AT_FRACTION, _TAKEN_AT_ZONE = 0x9003, 0x9291, 0x9011
_GPS_TIME, _GPS_DATE = 7, 29
_LATITUDE_REF, _LATITUDE, _LONGITUDE_REF, _LONGITUDE, _ALTITUDE_REF, _ALTITUDE = range(1, 7)


@dataclass(frozen=True, slots=True)
class ExifTags:
    """EXIF tags of a photograph; None where one is missing."""

    latitude_deg: float | None
    longitude_deg: float | None
    altitude_amsl_m: AmslM | None
    orientation: int
    """1: the rows of the file are those that the camera saw."""
    original_width_px: int
    """Width when it was taken; focal lengths in pixels refer to it."""
    digital_zoom: float
    focal_per_width: float | None
    """Focal length divided by the width of the sensor."""
    focal_per_diagonal: float | None
    """Focal length divided by the diagonal of the sensor."""
    utc_s: float | None
    """Time of exposure since the Unix epoch: of the camera if its time zone is known, else of the GPS."""
    model: str | None
    """Name of the camera's model."""
    software: str | None
    """Program that has written the file last; cameras write their firmware's version."""


def exif_tags(exif: Any, width_px: int) -> ExifTags:
    """Return the tags.

    Args:
        exif: ``PIL.Image.Exif``.
        width_px: width of the photograph; taken for the original width where EXIF has none.
    """
    camera: Mapping[int, Any] = exif.get_ifd(EXIF_IFD)
    gps: Mapping[int, Any] = exif.get_ifd(GPS_IFD)
    altitude_m = _number(gps.get(_ALTITUDE))
    if altitude_m is not None and gps.get(_ALTITUDE_REF) in (1, b"\x01"):
        altitude_m = -altitude_m
    equivalent_mm = _positive(camera.get(_FOCAL_LENGTH_35MM))
    original_width_px = int(_positive(camera.get(_ORIGINAL_WIDTH)) or width_px)
    return ExifTags(
        latitude_deg=_angle(gps.get(_LATITUDE), gps.get(_LATITUDE_REF), "S"),
        longitude_deg=_angle(gps.get(_LONGITUDE), gps.get(_LONGITUDE_REF), "W"),
        altitude_amsl_m=None if altitude_m is None else AmslM(altitude_m),
        orientation=int(_number(exif.get(_ORIENTATION)) or 1),
        original_width_px=original_width_px,
        digital_zoom=_positive(camera.get(_DIGITAL_ZOOM)) or 1.0,
        focal_per_width=_focal_per_width(camera, original_width_px),
        focal_per_diagonal=None if equivalent_mm is None else equivalent_mm / FULL_FRAME_DIAGONAL_MM,
        utc_s=_camera_utc_s(camera) or _gps_utc_s(gps),
        model=_text(exif.get(_MODEL)),
        software=_text(exif.get(_SOFTWARE)),
    )


def _focal_per_width(camera: Mapping[int, Any], width_px: int) -> float | None:
    focal_mm, pixels_per_unit = _positive(camera.get(_FOCAL_LENGTH)), _positive(camera.get(_FOCAL_PLANE_X))
    unit_mm = _MILLIMETRES.get(int(_number(camera.get(_FOCAL_PLANE_UNIT)) or 2))
    if focal_mm is None or pixels_per_unit is None or unit_mm is None:
        return None
    return focal_mm / (width_px / pixels_per_unit * unit_mm)


def _camera_utc_s(camera: Mapping[int, Any]) -> float | None:
    """Return the camera's time; without a zone it is that of a place nobody knows."""
    text, fraction = f"{camera.get(_TAKEN_AT)} {camera.get(_TAKEN_AT_ZONE)}", camera.get(_TAKEN_AT_FRACTION)
    digits = fraction.strip() if isinstance(fraction, str) and fraction.strip().isdecimal() else "0"
    try:
        return datetime.strptime(text, "%Y:%m:%d %H:%M:%S %z").timestamp() + float(f"0.{digits}")
    except ValueError:
        return None


def _gps_utc_s(gps: Mapping[int, Any]) -> float | None:
    parts = gps.get(_GPS_TIME)
    numbers = [_number(part) for part in parts] if isinstance(parts, tuple | list) else []
    try:
        day = datetime.strptime(f"{gps.get(_GPS_DATE)} +0000", "%Y:%m:%d %z")
    except ValueError:
        return None
    if len(numbers) != 3 or any(number is None for number in numbers):
        return None
    hours, minutes, seconds = (number or 0.0 for number in numbers)
    return day.timestamp() + 3600.0 * hours + 60.0 * minutes + seconds


def _angle(parts: Any, reference: Any, negative: str) -> float | None:
    """Return degrees from degrees, minutes and seconds; without its hemisphere an angle is not known."""
    numbers = [_number(part) for part in parts] if isinstance(parts, tuple | list) else []
    if len(numbers) != 3 or not isinstance(reference, str) or not reference.strip():
        return None
    degrees, minutes, seconds = numbers
    if degrees is None or minutes is None or seconds is None:
        return None
    angle = degrees + minutes / 60.0 + seconds / 3600.0
    return -angle if reference.strip().upper().startswith(negative) else angle


def _number(value: Any) -> float | None:
    """Return a finite number; EXIF's rationals may be 0/0."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if math.isfinite(number) else None


def _text(value: Any) -> str | None:
    """Return a text without the zeros and spaces that fill it up; None where nothing is left."""
    text = value.partition("\0")[0].strip() if isinstance(value, str) else ""
    return text or None


def _positive(value: Any) -> float | None:
    number = _number(value)
    return number if number is not None and number > 0.0 else None
