"""Focal surface and raster of ``aos-gcs integrate``: options for planes, terrain, views and maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from aos_gcs.cli.autofocus_options import PANEL, Autofocus, plane_or_autofocus
from aos_gcs.cli.focus_stack import stack_heights_m, write_focus_stack
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focus.region import FocusRegion, ViewRegion
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.surfaces.dem_files import is_geotiff, read_dem
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.input_values import finite_numbers
from aos_gcs.surveys.model import Survey

MAX_TILT_DEG = 60.0
MAX_SIZE_PX = 16_384
DEFAULT_SIZE_PX = 512

RASTER_PANEL = "View or map"

Tilt = Annotated[
    str | None,
    typer.Option(
        metavar="NORTH_DEG,EAST_DEG",
        help="Tilt of the plane: its slopes along y and along x are the tangents of these angles. Its height is Z (or "
        "that of autofocus) below the mean of all cameras.",
        rich_help_panel=PANEL,
    ),
]
Dem = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Terrain to focus on instead of a plane: .obj, .obj.gz or GeoTIFF (.tif). With --autofocus, the shift is "
        "searched.",
        rich_help_panel=PANEL,
    ),
]
DemOffset = Annotated[
    float | None,
    typer.Option(metavar="DZ", help="Shift of the terrain along z, metres.", show_default="0", rich_help_panel=PANEL),
]
View = Annotated[
    int | None,
    typer.Option(
        metavar="INDEX",
        help="Image whose pose the virtual camera takes, counted from 0.",
        rich_help_panel=RASTER_PANEL,
    ),
]
Ortho = Annotated[
    float | None,
    typer.Option(
        metavar="RES",
        help="Resolution of an orthographic map of all that is seen, instead of a view; metres per cell.",
        rich_help_panel=RASTER_PANEL,
    ),
]
Size = Annotated[
    int | None,
    typer.Option(
        help="Width and height of a view, pixels.", show_default=str(DEFAULT_SIZE_PX), rich_help_panel=RASTER_PANEL
    ),
]


@dataclass(frozen=True, slots=True)
class FocusOptions:
    """Focal surface as given by the options; files are not read yet."""

    plane: float | Autofocus = 0.0
    """Height of the plane or how to find it; with a terrain only the latter is used."""
    slopes: tuple[float, float] = (0.0, 0.0)
    """Slopes of the plane: change of z per metre along x and along y."""
    dem: Path | None = None
    dem_offset_m: float | None = None
    """Shift of the terrain along z; None: none was given."""
    stack: Path | None = None
    """Contact sheet to write."""

    def surface(
        self, survey: Survey, terrain: Terrain | None, virtual: tuple[CameraModel, Pose] | None, *, skip_broken: bool
    ) -> FocalSurface:
        """Return the surface.

        A plane tilted by hand has its height below the mean of all camera positions.

        Args:
            survey: recording whose frames autofocus compares.
            terrain: the terrain of these options, as :meth:`terrain` returns it.
            virtual: camera whose view autofocus looks at unless it has a region of its own; None for maps.
            skip_broken: skip images that cannot be read.

        Raises:
            ConfigurationError, InputDataError: if autofocus finds no height.
        """
        if not isinstance(self.plane, Autofocus):
            return self._tilted(survey, self.plane) if terrain is None else terrain
        if self.stack is not None:
            self._write_stack(self.stack, self.plane, survey, virtual, terrain, skip_broken=skip_broken)
        region = _focus_region(self.plane, virtual)
        if terrain is not None:
            return self.plane.terrain(survey, region, terrain, skip_broken=skip_broken)
        plane = self.plane.plane(survey, region, skip_broken=skip_broken)
        return plane if self.plane.tilt else self._tilted(survey, plane.height_m)

    def terrain(self, survey: Survey) -> Terrain | None:
        """Return the terrain in the world of a recording, before autofocus; None without one.

        Raises:
            ConfigurationError, InputDataError: if it cannot be read or placed.
        """
        if self.dem is None:
            return None
        # A mesh has the coordinates of the poses already.
        origin = survey.origin if is_geotiff(self.dem) else None
        return read_dem(self.dem, origin, survey.R_file2world).moved(self.dem_offset_m or 0.0)

    def _write_stack(
        self,
        path: Path,
        autofocus: Autofocus,
        survey: Survey,
        virtual: tuple[CameraModel, Pose] | None,
        terrain: Terrain | None,
        *,
        skip_broken: bool,
    ) -> None:
        if virtual is None:
            raise ConfigurationError("--focus-stack shows a view: give the virtual camera as --view INDEX.")
        surfaces: list[tuple[str, FocalSurface]] = [
            (f"z = {height_m:.2f} m", self._tilted(survey, height_m))
            if terrain is None
            else (f"terrain {height_m:+.2f} m", terrain.moved(height_m))
            for height_m in stack_heights_m(autofocus.low_m, autofocus.high_m)
        ]
        write_focus_stack(path, survey, virtual, surfaces, skip_broken=skip_broken)

    def _tilted(self, survey: Survey, height_m: float) -> Plane:
        x_m, y_m, _ = np.mean([image.pose.position_enu_m for image in survey.images], axis=0)
        return Plane.through([x_m, y_m, height_m], *self.slopes)


def _focus_region(autofocus: Autofocus, virtual: tuple[CameraModel, Pose] | None) -> FocusRegion:
    if autofocus.region is not None:
        return autofocus.region
    if virtual is not None:
        return ViewRegion.whole(*virtual)
    raise ConfigurationError("--autofocus of a map needs the place to focus on: --focus-region X0,Y0,X1,Y1.")


def focus_options(
    *,
    plane_z: float | None,
    autofocus: str | None,
    focus_region: str | None,
    focus_tilt: bool,
    tilt: str | None,
    dem: Path | None,
    offset_m: float | None,
    stack: Path | None,
) -> FocusOptions:
    """Return the focal surface that ``--plane-z``, ``--autofocus``, ``--tilt`` and ``--dem`` with companions name.

    Raises:
        ConfigurationError: if a value is not valid, or options exclude each other.
    """
    if stack is not None and autofocus is None:
        raise ConfigurationError("--focus-stack requires the range of heights: --autofocus LOW,HIGH.")
    if stack is not None and stack.suffix.lower() != ".png":
        raise ConfigurationError(f"--focus-stack must name a .png file, got {stack}.")
    if dem is None:
        if offset_m is not None:
            raise ConfigurationError("--dem-offset requires --dem.")
        if focus_tilt and tilt is not None:
            raise ConfigurationError("--tilt and --focus-tilt exclude each other: give the tilt, or search for it.")
        plane = plane_or_autofocus(plane_z, autofocus, focus_region, tilt=focus_tilt)
        return FocusOptions(plane, _slopes(tilt), stack=stack)
    others = {
        "--plane-z": plane_z is not None,
        "--focus-tilt": focus_tilt,
        "--tilt": tilt is not None,
    }
    for name, given in others.items():
        if given:
            raise ConfigurationError(f"--dem and {name} exclude each other: focus on a terrain or on a plane.")
    if offset_m is not None and not math.isfinite(offset_m):
        raise ConfigurationError(f"--dem-offset must be a finite number of metres, got {offset_m}.")
    if autofocus is None and focus_region is not None:
        raise ConfigurationError("--focus-region requires --autofocus.")
    found = 0.0 if autofocus is None else plane_or_autofocus(None, autofocus, focus_region, tilt=False)
    return FocusOptions(found, dem=dem, dem_offset_m=offset_m, stack=stack)


def check_raster_options(ortho: float | None, view: int | None, size: int | None) -> None:
    """Refuse options that do not go with a map or a view.

    Raises:
        ConfigurationError: unless exactly one of both is asked for, and well.
    """
    if size is not None and not 1 <= size <= MAX_SIZE_PX:
        raise ConfigurationError(f"--size must lie between 1 and {MAX_SIZE_PX} pixels, got {size}.")
    if ortho is None:
        if view is None:
            raise ConfigurationError("Give the virtual camera as --view INDEX, or ask for a map with --ortho RES.")
        return
    if not (math.isfinite(ortho) and ortho > 0.0):
        raise ConfigurationError(f"--ortho must be a positive number of metres, got {ortho:g}.")
    for name, given in (("--view", view is not None), ("--size", size is not None)):
        if given:
            raise ConfigurationError(f"--ortho and {name} exclude each other: a map has an extent of its own.")


def virtual_camera(survey: Survey, view: int | None, size: int | None) -> tuple[CameraModel, Pose]:
    """Return the ideal camera of a view, with the field of view of the image whose pose it takes.

    Raises:
        ConfigurationError: if there is no such image.
    """
    if view is None or not 0 <= view < len(survey.images):
        raise ConfigurationError(
            f"--view {view} is out of range: the recording has the views 0 to {len(survey.images) - 1}."
        )
    image = survey.images[view]
    edge_px = DEFAULT_SIZE_PX if size is None else size
    return CameraModel.from_fov(edge_px, edge_px, image.camera.horizontal_fov_rad), image.pose


def describe_map(raster: MapRaster) -> str:
    """Return a line that describes the place of a map."""
    direction = "+y" if raster.rows_along_y else "-y"
    return (
        f"map: {raster.columns} x {raster.rows} cells of {raster.resolution_m:g} m; the outer corner of the first cell "
        f"is x = {raster.x_m:.3f}, y = {raster.y_m:.3f}; columns follow +x, rows {direction}"
    )


def _slopes(tilt: str | None) -> tuple[float, float]:
    """Return the slopes along x and y."""
    if tilt is None:
        return 0.0, 0.0
    angles_deg = finite_numbers(tilt)
    if len(angles_deg) != 2 or not all(abs(angle) <= MAX_TILT_DEG for angle in angles_deg):
        raise ConfigurationError(
            f"--tilt needs two angles NORTH_DEG,EAST_DEG of at most {MAX_TILT_DEG:g} degrees, got {tilt!r}."
        )
    along_y, along_x = (math.tan(math.radians(angle)) for angle in angles_deg)
    return along_x, along_y
