"""Ground that a scene stands on, by the option ``--terrain``: level, hills, a slope, or that of a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.world.relief import Relief

FLAT = "flat"
HILLS = "hills"
SLOPE = "slope:"
FILE_ENDINGS = (".tif", ".tiff", ".asc")
MAX_SLOPE_PERCENT = 50.0

CELL_M = 2.0
SURROUNDINGS_M = 200.0
"""Distance around the box of a scene to which its ground is shaped."""
FILE_SURROUNDINGS_M = 100.0
"""Distance around the box of a scene that a file must cover."""

HILLS_RELIEF_M = 80.0
"""Difference between the highest and the lowest place of the hills."""
_WAVES = 12
_WAVE_LENGTHS_M = (450.0, 900.0)
_LAUNCH_SITE_M = (-50.0, -22.0, 50.0, 0.0)
"""Edges of the level part of hills, west, south, east and north: a hundred vehicles stand there."""
_RISE_M = 90.0
"""Distance from it at which hills have their full height."""

_MAX_ORIGIN_OFF_M = 10.0
"""Largest difference of an origin's altitude from a file, as preflight allows it."""
_EARTH_RADIUS_M = 6_371_000.0

Box = tuple[float, float, float, float]
"""Western, southern, eastern and northern edge, metres."""


def check_terrain(text: str) -> None:
    """Refuse what is no terrain.

    Raises:
        ConfigurationError: the text is none, or its slope is out of range; it names the option.
    """
    if text.startswith(SLOPE):
        _slope(text)
    elif text not in (FLAT, HILLS) and not is_file(text):
        raise ConfigurationError(
            f"--terrain must be {FLAT}, {HILLS}, {SLOPE}PERCENT or a GeoTIFF or ASC file "
            f"({', '.join(FILE_ENDINGS)}), got {text!r}."
        )


def is_file(text: str) -> bool:
    """Whether a terrain is that of a file."""
    return text.lower().endswith(FILE_ENDINGS)


def make_relief(
    text: str, seed: int, box_enu_m: Box, *, level_north_m: float, origin: GeodeticPosition | None
) -> Relief | None:
    """Return the shape of the ground; None where it is level.

    Args:
        text: as of :func:`check_terrain`.
        seed: of the hills.
        box_enu_m: what the scene needs, the launch site at the origin included.
        level_north_m: northern edge of the launch site, where a slope begins.
        origin: origin of the scene, which a file needs.

    Raises:
        ConfigurationError: the text is no terrain, or the file cannot be used; it names the option.
    """
    check_terrain(text)
    if text == FLAT:
        return None
    if is_file(text):
        return _from_file(Path(text), box_enu_m, origin)
    west_m, south_m, east, north = _raster(box_enu_m, SURROUNDINGS_M)
    heights_m = _hills(seed, east, north) if text == HILLS else _slope(text) * np.maximum(north - level_north_m, 0.0)
    return Relief(heights_m, west_m, south_m, CELL_M)


def _raster(box_enu_m: Box, margin_m: float) -> tuple[float, float, NDArray[np.float64], NDArray[np.float64]]:
    """Return western and southern edge, and the places of all corners of cells, two arrays (rows, columns).

    Edges lie at multiples of a cell.
    """
    west_m, south_m = (CELL_M * math.floor((edge_m - margin_m) / CELL_M) for edge_m in box_enu_m[:2])
    east_m, north_m = (CELL_M * math.ceil((edge_m + margin_m) / CELL_M) for edge_m in box_enu_m[2:])
    east, north = np.meshgrid(
        np.arange(west_m, east_m + CELL_M / 2, CELL_M), np.arange(south_m, north_m + CELL_M / 2, CELL_M)
    )
    return west_m, south_m, east, north


def _slope(text: str) -> float:
    """Return the rise of ``slope:PERCENT``, metres per metre."""
    try:
        percent = float(text.removeprefix(SLOPE))
    except ValueError as error:
        raise ConfigurationError(
            f"--terrain {SLOPE}PERCENT needs a number, such as {SLOPE}20, got {text!r}."
        ) from error
    if not abs(percent) <= MAX_SLOPE_PERCENT:
        raise ConfigurationError(
            f"--terrain {SLOPE}PERCENT must lie within -{MAX_SLOPE_PERCENT:g} and {MAX_SLOPE_PERCENT:g}, got {text!r}."
        )
    return percent / 100.0


def _hills(seed: int, east_m: NDArray[np.float64], north_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the heights of waves of random directions, level at the launch site."""
    rng = np.random.default_rng([seed, 0x7E])
    lengths_m = rng.uniform(*_WAVE_LENGTHS_M, _WAVES)
    directions_rad, phases_rad = rng.uniform(0.0, 2 * math.pi, (2, _WAVES))
    heights = np.zeros(east_m.shape)
    for length_m, direction_rad, phase_rad in zip(lengths_m, directions_rad, phases_rad, strict=True):
        along_m = east_m * math.sin(direction_rad) + north_m * math.cos(direction_rad)
        wave_rad = 2 * math.pi * along_m / length_m + phase_rad
        heights += length_m * (np.sin(wave_rad) - math.sin(phase_rad))
    west_m, south_m, east_edge_m, north_edge_m = _LAUNCH_SITE_M
    beside_m = np.maximum(np.maximum(west_m - east_m, east_m - east_edge_m), 0.0)
    beyond_m = np.maximum(np.maximum(south_m - north_m, north_m - north_edge_m), 0.0)
    away = np.minimum(np.hypot(beside_m, beyond_m) / _RISE_M, 1.0)
    heights *= away**2 * (3.0 - 2.0 * away)
    return np.asarray(heights * (HILLS_RELIEF_M / np.ptp(heights)))


def _from_file(path: Path, box_enu_m: Box, origin: GeodeticPosition | None) -> Relief:
    """Return the ground of an elevation model, relative to its height at the origin."""
    if origin is None:
        raise ConfigurationError(f"--terrain {path} needs the place of the origin: give --origin LAT,LON,ALT.")
    west_m, south_m, east, north = _raster(box_enu_m, FILE_SURROUNDINGS_M)
    try:
        pyproj: Any = load_extra("pyproj", "geo", "--terrain with a file")
        to_degrees = pyproj.Transformer.from_crs(local_projection(origin), "EPSG:4326", always_xy=True)
        longitude, latitude = (axis.reshape(east.shape) for axis in to_degrees.transform(east.ravel(), north.ravel()))
        amsl_m, at_origin_m, bounds_deg = _read(path, latitude, longitude, origin)
    except AosError as error:
        raise ConfigurationError(f"--terrain {path}: {error}") from error
    if np.isnan(at_origin_m):
        raise ConfigurationError(
            f"--terrain {path} has no height at the origin ({_text_deg(origin.latitude_deg, origin.longitude_deg)}): "
            "give the place of a launch site within it (--origin)."
        )
    missing = np.argwhere(np.isnan(amsl_m))
    if len(missing):
        row, column = missing[0]
        south, west, north_deg, east_deg = bounds_deg
        is_inside = south <= latitude[row, column] <= north_deg and west <= longitude[row, column] <= east_deg
        raise ConfigurationError(
            f"--terrain {path} {'has a hole' if is_inside else 'ends'} at {east[row, column]:.0f} m east and "
            f"{north[row, column]:.0f} m north of the origin "
            f"({_text_deg(latitude[row, column], longitude[row, column])}): {len(missing)} of {amsl_m.size} places "
            f"within {FILE_SURROUNDINGS_M:g} m of the scene have no height."
        )
    if abs(at_origin_m - origin.altitude_amsl_m) > _MAX_ORIGIN_OFF_M:
        raise ConfigurationError(
            f"--terrain {path} lies {at_origin_m:.1f} m above sea level at the origin, not "
            f"{origin.altitude_amsl_m:g}: give --origin that altitude."
        )
    heights_m = amsl_m - at_origin_m - drop_of_earth_m(east, north)
    return Relief(heights_m, west_m, south_m, CELL_M)


def _read(
    path: Path, latitude: NDArray[np.float64], longitude: NDArray[np.float64], origin: GeodeticPosition
) -> tuple[NDArray[np.float64], float, tuple[float, float, float, float]]:
    """Return heights above sea level of places and of the origin, NaN where there is none, and the file's bounds.

    Raises:
        AosError: the file cannot be used.
    """
    # Only files need their libraries.
    from aos_gcs.elevation.datum import VerticalDatum  # noqa: PLC0415
    from aos_gcs.elevation.geoid import find_egm2008, find_geoid  # noqa: PLC0415
    from aos_gcs.elevation.model import ElevationModel, ModelKind  # noqa: PLC0415
    from aos_gcs.elevation.tile import ElevationTile  # noqa: PLC0415

    tile = ElevationTile(path)
    stated = tile.stated_datum
    tile.close()
    # The heights of a file that states no datum are taken as they are.
    datum = VerticalDatum.EGM96 if stated is None else None
    model = ElevationModel([path], ModelKind.TERRAIN, datum=datum, geoid=find_geoid(), egm2008=find_egm2008())
    try:
        heights_m = model.heights_amsl_m(latitude, longitude)
        at_origin_m = float(model.heights_amsl_m(origin.latitude_deg, origin.longitude_deg))
        return heights_m, at_origin_m, model.bounds_deg()
    finally:
        model.close()


def local_projection(origin: GeodeticPosition) -> str:
    """Return the projection, in PROJ's words, whose axes are east and north of the origin within millimetres."""
    place = f"+lat_0={origin.latitude_deg!r} +lon_0={origin.longitude_deg!r}"
    return f"+proj=tmerc {place} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +type=crs"


def drop_of_earth_m(east_m: NDArray[np.float64], north_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far the earth curves away below the plane of east and north."""
    return np.asarray((east_m**2 + north_m**2) / (2 * _EARTH_RADIUS_M))


def _text_deg(latitude_deg: float, longitude_deg: float) -> str:
    return f"{latitude_deg:.5f}, {longitude_deg:.5f}"
