"""A place on the globe as search teams write it; all notations are WGS84."""

from __future__ import annotations

from enum import StrEnum

import mgrs
import utm

_MGRS = mgrs.MGRS()
_UTM_LATITUDES_DEG = (-80.0, 84.0)


class Notation(StrEnum):
    """Notation of a place; the dashboard has the same ones."""

    DECIMAL = "decimal"
    DMS = "dms"
    UTM = "utm"
    MGRS = "mgrs"


def written(latitude_deg: float, longitude_deg: float, notation: Notation) -> str:
    """Return a place in a notation; nearer to the poles than UTM reaches, in decimal degrees instead of UTM."""
    match notation:
        case Notation.DMS:
            return dms(latitude_deg, longitude_deg)
        case Notation.MGRS:
            return mgrs_text(latitude_deg, longitude_deg)
        case Notation.UTM:
            return utm_text(latitude_deg, longitude_deg) or decimal(latitude_deg, longitude_deg)
        case Notation.DECIMAL:
            return decimal(latitude_deg, longitude_deg)


def decimal(latitude_deg: float, longitude_deg: float) -> str:
    """Return a place in degrees to 0.000001 (0.1 m)."""
    return f"{abs(latitude_deg):.6f}° {'NS'[latitude_deg < 0]}, {abs(longitude_deg):.6f}° {'EW'[longitude_deg < 0]}"


def dms(latitude_deg: float, longitude_deg: float) -> str:
    """Return a place in degrees, minutes and seconds, to 0.01 seconds (0.3 m)."""
    return f"{_dms(latitude_deg, 'NS')} {_dms(longitude_deg, 'EW')}"


def utm_text(latitude_deg: float, longitude_deg: float) -> str | None:
    """Return zone, easting and northing in whole metres; None nearer to the poles than UTM reaches."""
    low_deg, high_deg = _UTM_LATITUDES_DEG
    if not low_deg <= latitude_deg <= high_deg:
        return None
    east_m, north_m, zone, letter = utm.from_latlon(latitude_deg, longitude_deg)
    return f"{zone}{letter} {east_m:.0f} {north_m:.0f}"


def mgrs_text(latitude_deg: float, longitude_deg: float) -> str:
    """Return the reference of a square of one metre, in groups as it is read out: ``32T MT 23974 05649``."""
    code = _MGRS.toMGRS(latitude_deg, longitude_deg)
    square, digits = code[:-10], code[-10:]
    return f"{square[:-2]} {square[-2:]} {digits[:5]} {digits[5:]}"


def _dms(angle_deg: float, hemispheres: str) -> str:
    degrees, rest = divmod(round(abs(angle_deg) * 360_000), 360_000)
    minutes, hundredths = divmod(rest, 6_000)
    return f"{degrees}°{minutes:02d}'{hundredths / 100:05.2f}\"{hemispheres[angle_deg < 0]}"
