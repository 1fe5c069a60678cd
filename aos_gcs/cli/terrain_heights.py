"""Checks of a terrain against the photographs above it: both must count heights from the same surface."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import typer

from aos_gcs.elevation.geoid import find_geoid
from aos_gcs.elevation.likely_cause import likely_cause
from aos_gcs.errors import InputDataError
from aos_gcs.imaging.surfaces.dem_files import is_geotiff
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.input_values import printable
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.terrain_heights import FlownHeights, flown_heights

MAX_EXCESS_M = 10.0
"""Difference of heights above the terrain and above the place of takeoff from which it is told."""
_MAX_FALL_M = 1000.0
"""Difference of the ground's heights that no flight of a drone has."""
_UNITS = ("feet", "decimetres", "centimetres")


def with_terrain_checked(survey: Survey, terrain: Terrain | None, path: Path | None, offset_m: float | None) -> Survey:
    """Return a survey with warnings of heights that do not fit a GeoTIFF terrain; they are printed on standard error.

    Args:
        survey: recording; those with poses of their own tell no heights above a place of takeoff, and are not checked.
        terrain: terrain in the world of the recording, moved by the offset; None without one.
        path: its file.
        offset_m: offset that the user has given; None where none is given.

    Raises:
        InputDataError: if the photographs lie below the terrain or absurdly far above it, or have no altitudes.
    """
    if terrain is None or path is None or not is_geotiff(path):
        return survey
    flown = list(flown_heights(survey, terrain))
    if survey.lacks_altitudes and offset_m is None:
        raise InputDataError(_no_altitudes(path, flown))
    excesses_m = [heights.excess_m for heights in flown]
    several = bool(flown) and max(excesses_m) - min(excesses_m) > MAX_EXCESS_M
    warnings = []
    for heights in flown if several else flown[:1]:
        text = _text(survey, path, heights, offset_m or 0.0, several=several)
        if heights.above_terrain_m <= 0.0 or abs(heights.excess_m) > _MAX_FALL_M:
            raise InputDataError(text)
        if abs(heights.excess_m) > MAX_EXCESS_M:
            warnings.append(text)
            typer.echo(printable(text), err=True)
    return replace(survey, warnings=(*survey.warnings, *warnings))


def _no_altitudes(path: Path, flown: list[FlownHeights]) -> str:
    """Return why photographs without absolute altitudes cannot be placed above a terrain, and what to do."""
    example = ""
    if flown:
        ground_m = -flown[0].excess_m
        example = f" Below the photographs it has {ground_m:.1f} m in the median: --dem-offset {-ground_m:.1f} there."
    return (
        "The photographs have neither AbsoluteAltitude nor GPSAltitude, so that only their heights above the place of "
        f"takeoff are known: give the height that the terrain {path} has at the place of takeoff, with a minus, as "
        f"--dem-offset.{example}"
    )


def _text(survey: Survey, path: Path, heights: FlownHeights, offset_m: float, *, several: bool) -> str:
    """Return by how much heights differ, the likely cause, and the remedy."""
    side = "above" if heights.above_terrain_m > 0.0 else "below"
    takeoff = f"their place of takeoff (those with {heights.first_name})" if several else "their place of takeoff"
    differ = (
        f"The photographs were taken {abs(heights.above_terrain_m):.1f} m {side} the terrain {path}, but "
        f"{heights.above_takeoff_m:.1f} m above {takeoff} (medians)"
    )
    excess_m, cause = heights.excess_m, "" if survey.lacks_altitudes else _cause(survey, heights, offset_m)
    if cause.endswith(_UNITS):
        return f"{differ}: {cause}. Convert them to metres."
    if excess_m > _MAX_FALL_M:
        return f"{differ}: check the terrain for holes that are not declared (gdal_edit.py -a_nodata 0), and its unit."
    reason = cause or "the two count heights from different surfaces, such as the ellipsoid, or in different units"
    offset = f"--dem-offset {offset_m + excess_m:.1f}"
    remedy = f"{offset} puts the terrain at the height of the place of takeoff"
    if several:
        # The terrain fits other photographs better, so that its heights are not the cause.
        reason = cause or "their altitudes err"
        remedy = f"put these photographs into a folder of their own, and give {offset} for it"
    way = "falls" if excess_m > 0.0 else "rises"
    return f"{differ}. Unless the ground {way} by {abs(excess_m):.1f} m from there, {reason}: {remedy}."


def _cause(survey: Survey, heights: FlownHeights, offset_m: float) -> str:
    geoid = find_geoid()
    undulation_m = None
    if geoid is not None and survey.origin is not None:
        undulation_m = float(geoid.undulation_m(survey.origin.latitude_deg, survey.origin.longitude_deg))
    model_m = heights.takeoff_amsl_m - heights.excess_m - offset_m
    return likely_cause(model_m, heights.takeoff_amsl_m, undulation_m)
