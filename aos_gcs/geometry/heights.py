"""Heights above different surfaces, each a type of its own, and the only conversions between them.

All are floats in metres when the program runs. For the type checker a height of one kind is none of another, and a
plain number is none of any: where a height enters the program, ``AmslM(...)`` states what it counts from, and whoever
passes it on as another kind has to convert it here. What is added to a height or taken off it is a plain number, so
that the sum has to be stated again.
"""

from __future__ import annotations

from typing import NewType

AmslM = NewType("AmslM", float)
"""Altitude above mean sea level, the geoid EGM96: MAVLink, configuration, EXIF, KML, elevation models."""

SEA_LEVEL = AmslM(0.0)

EllipsoidalM = NewType("EllipsoidalM", float)
"""Height above the WGS84 ellipsoid: Cursor on Target, and the axes of a local frame."""

AboveHomeM = NewType("AboveHomeM", float)
"""Height above a vehicle's own home: MAVLink's relative altitudes, take-offs, return heights."""

AboveGroundM = NewType("AboveGroundM", float)
"""Height above the ground of an elevation model."""


def ellipsoidal_m(altitude_m: AmslM, undulation_m: float) -> EllipsoidalM:
    """Return the height above the ellipsoid, where the geoid is ``undulation_m`` above it."""
    return EllipsoidalM(altitude_m + undulation_m)


def amsl_m(height_m: EllipsoidalM, undulation_m: float) -> AmslM:
    """Return the altitude above mean sea level, where the geoid is ``undulation_m`` above the ellipsoid."""
    return AmslM(height_m - undulation_m)


def amsl_above_home_m(home_m: AmslM, height_m: AboveHomeM) -> AmslM:
    """Return the altitude of what is at a height above a home."""
    return AmslM(home_m + height_m)


def home_below_m(altitude_m: AmslM, height_m: AboveHomeM) -> AmslM:
    """Return the altitude of the home that something at an altitude has a height above."""
    return AmslM(altitude_m - height_m)


def above_home_m(altitude_m: AmslM, home_m: AmslM) -> AboveHomeM:
    """Return the height above a home."""
    return AboveHomeM(altitude_m - home_m)
