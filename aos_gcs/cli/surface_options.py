"""The focal surface and the raster of ``aos-gcs integrate``: options for tilt, terrain and maps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aos_gcs.cli.autofocus_options import focal_height_m, focal_height_or_range
from aos_gcs.cli.recordings import RecordedView
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.dem_files import read_dem
from aos_gcs.imaging.model import GroundRaster
from aos_gcs.imaging.views import FocalSurface

MAX_TILT_DEG = 60.0


@dataclass(frozen=True, slots=True)
class FocusOptions:
    """The focal surface as the options name it; files are not read yet."""

    plane: float | tuple[float, float] = 0.0
    """Height of a plane, or the range in which autofocus has to find it; of no meaning with a terrain."""
    slope_x: float = 0.0
    """Of the plane: change of z per metre along x."""
    slope_y: float = 0.0
    dem: Path | None = None
    dem_offset_m: float = 0.0
    dem_origin: GeodeticPosition | None = None

    def surface(self, views: Sequence[RecordedView], camera: CameraModel, pose: Pose) -> FocalSurface:
        """Return the surface; autofocus looks at what ``camera`` sees from ``pose``.

        A tilted plane has its height below the mean of all camera positions.

        Raises:
            ConfigurationError, InputDataError: if a terrain cannot be read or placed, or autofocus finds no height.
        """
        if self.dem is not None:
            return read_dem(self.dem, self.dem_origin).moved(self.dem_offset_m)
        height_m = focal_height_m(self.plane, views, camera, pose)
        x_m, y_m, _ = np.mean([view.pose.position_enu_m for view in views], axis=0)
        return Plane.through([x_m, y_m, height_m], self.slope_x, self.slope_y)


def focus_options(
    *,
    plane_z: float | None,
    autofocus: str | None,
    tilt: str | None,
    dem: Path | None,
    offset_m: float | None,
    at: str | None,
) -> FocusOptions:
    """Return the focal surface that ``--plane-z``, ``--autofocus``, ``--tilt`` and ``--dem`` with companions name.

    Raises:
        ConfigurationError: if a value is not valid, or options exclude each other.
    """
    if dem is None:
        for name, value in (("--dem-offset", offset_m), ("--dem-origin", at)):
            if value is not None:
                raise ConfigurationError(f"{name} is about a terrain: give it together with --dem.")
        return FocusOptions(focal_height_or_range(plane_z, autofocus), *_slopes(tilt))
    for name, value in (("--plane-z", plane_z), ("--autofocus", autofocus), ("--tilt", tilt)):
        if value is not None:
            raise ConfigurationError(f"--dem and {name} exclude each other: focus on a terrain or on a plane.")
    if offset_m is not None and not math.isfinite(offset_m):
        raise ConfigurationError(f"--dem-offset must be a finite number of metres, got {offset_m}.")
    return FocusOptions(dem=dem, dem_offset_m=offset_m or 0.0, dem_origin=None if at is None else _origin(at))


def check_map_options(ortho: float | None, view: int | None, size: int | None, *, autofocus: bool) -> None:
    """Refuse options that do not go with a map or a view.

    Raises:
        ConfigurationError: unless exactly one of both is asked for, and well.
    """
    if ortho is None:
        if view is None:
            raise ConfigurationError("Give the virtual camera as --view INDEX, or ask for a map with --ortho RES.")
        return
    if not (math.isfinite(ortho) and ortho > 0.0):
        raise ConfigurationError(f"--ortho must be a positive number of metres, got {ortho:g}.")
    for name, given in (("--view", view is not None), ("--size", size is not None)):
        if given:
            raise ConfigurationError(f"--ortho and {name} exclude each other: a map has an extent of its own.")
    if autofocus:
        raise ConfigurationError(
            "--ortho and --autofocus exclude each other: focus a --view first, then give the height as --plane-z."
        )


def world_file(raster: GroundRaster) -> str:
    """Return the six lines that tell a GIS where a picture of the map lies."""
    (dx_m, _, x_m), (_, dy_m, y_m), _ = raster.to_plane
    return "".join(f"{value!r}\n" for value in map(float, (dx_m, 0.0, 0.0, dy_m, x_m, y_m)))


def describe_map(raster: GroundRaster) -> str:
    """Return a line about where a map lies."""
    direction = "+y" if raster.rows_along_y else "-y"
    return (
        f"map: {raster.columns} x {raster.rows} cells of {raster.resolution_m:g} m; the outer corner of the first cell "
        f"is x = {raster.x_m:.3f}, y = {raster.y_m:.3f}; columns follow +x, rows {direction}"
    )


def _slopes(tilt: str | None) -> tuple[float, float]:
    """Return the slopes along x and y."""
    if tilt is None:
        return 0.0, 0.0
    angles_deg = _numbers(tilt)
    if len(angles_deg) != 2 or not all(abs(angle) <= MAX_TILT_DEG for angle in angles_deg):
        raise ConfigurationError(
            f"--tilt needs two angles NORTH_DEG,EAST_DEG of at most {MAX_TILT_DEG:g} degrees, got {tilt!r}."
        )
    along_y, along_x = (math.tan(math.radians(angle)) for angle in angles_deg)
    return along_x, along_y


def _origin(text: str) -> GeodeticPosition:
    numbers = _numbers(text)
    if len(numbers) != 3 or not (abs(numbers[0]) <= 90.0 and abs(numbers[1]) <= 180.0):
        raise ConfigurationError(f"--dem-origin needs LATITUDE,LONGITUDE,ALTITUDE in degrees and metres, got {text!r}.")
    return GeodeticPosition(*numbers)


def _numbers(text: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(math.isfinite(number) for number in numbers) else []
