"""Vertical datums: the surface that the heights of an elevation model count from."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from aos_gcs.errors import InputDataError

_EPSG_EGM96, _EPSG_EGM2008 = 5773, 3855
_METRE = "metre"


class VerticalDatum(StrEnum):
    """Surface that heights count from."""

    EGM96 = "egm96"
    """Geoid of 1996, which the mean sea level of GPS receivers, and so of autopilots, refers to."""
    EGM2008 = "egm2008"
    """Geoid of 2008, within about a metre of the former."""
    NATIONAL = "national"
    """Mean sea level of a country's survey, within about a metre of the geoids."""
    ELLIPSOID = "ellipsoid"
    """WGS84 ellipsoid: tens of metres from mean sea level."""


SIGMA_TO_EGM96_M = {
    VerticalDatum.EGM96: 0.0,
    VerticalDatum.EGM2008: 0.5,
    VerticalDatum.NATIONAL: 0.5,
    VerticalDatum.ELLIPSOID: 0.5,
}
"""Standard deviations of heights above EGM96 that are made of heights above another datum. Guesses, from the
differences of the geoids; for the ellipsoid, the error of the geoid that is taken off."""

SIGMA_THROUGH_GRIDS_M = 0.1
"""The same for heights above EGM2008 that are changed by the grids of both geoids: a guess from how far interpolations
of the coarser one differ."""


@dataclass(frozen=True, slots=True)
class StatedDatum:
    """Vertical datum that a file states."""

    datum: VerticalDatum
    name: str
    """Name in the file, such as that of a country's heights."""


def stated_datum(crs: Any, file: str) -> StatedDatum | None:
    """Return the vertical datum of a file's coordinate system; None if it has none.

    Args:
        crs: ``pyproj.CRS``.
        file: name of the file, for errors.

    Raises:
        InputDataError: if its heights are not in metres.
    """
    vertical = next((part for part in crs.sub_crs_list if part.is_vertical), None)
    if vertical is None:
        has_heights = len(crs.axis_info) == 3
        return StatedDatum(VerticalDatum.ELLIPSOID, f"{crs.name}, ellipsoidal heights") if has_heights else None
    unit = vertical.axis_info[0].unit_name
    if unit != _METRE:
        raise InputDataError(
            f"The heights of {file} are in {unit} ({vertical.name}), not in metres: convert them, for example by "
            "gdal_calc, and state their datum."
        )
    known = {_EPSG_EGM96: VerticalDatum.EGM96, _EPSG_EGM2008: VerticalDatum.EGM2008}
    return StatedDatum(known.get(vertical.to_epsg(), VerticalDatum.NATIONAL), vertical.name)
