"""Focal plane of ``aos-gcs integrate``: options for a given plane and for autofocus."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.cli.output import progress
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.region import FocusRegion, GroundRegion
from aos_gcs.imaging.focus.terrain import find_terrain_focus
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.undistort import seen_pixels
from aos_gcs.input_values import finite_numbers
from aos_gcs.surveys.images import LazyFrames
from aos_gcs.surveys.model import Survey, SurveyImage

PANEL = "Focal surface"

MAX_HEIGHT_M = 100_000.0
"""Heights of focal planes, with some room."""

PlaneZ = Annotated[
    float | None,
    typer.Option(
        metavar="Z",
        help="Height of the focal plane z = Z in the world of the poses, metres. Default for photographs: the ground, "
        "0, unless another surface is given.",
        rich_help_panel=PANEL,
    ),
]
AutofocusRange = Annotated[
    str | None,
    typer.Option(
        metavar="LOW,HIGH",
        help="Range of heights in which to search for the focal plane of the view, metres. With --dem: range of shifts "
        "of the terrain.",
        rich_help_panel=PANEL,
    ),
]
FocusOn = Annotated[
    str | None,
    typer.Option(
        metavar="X0,Y0,X1,Y1",
        help="Rectangle of the ground that autofocus looks at instead of the view, metres in the world of the poses.",
        rich_help_panel=PANEL,
    ),
]
FocusStack = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE.png",
        help="Also write the view integrated at twelve heights of the range of --autofocus, to choose one by eye; it "
        "is written even where autofocus finds nothing.",
        rich_help_panel=PANEL,
    ),
]
FocusTilt = Annotated[
    bool,
    typer.Option("--focus-tilt", help="Also search for the tilt of the focal plane.", rich_help_panel=PANEL),
]


@dataclass(frozen=True, slots=True)
class Autofocus:
    """Values of ``--autofocus``, ``--focus-region`` and ``--focus-tilt``."""

    low_m: float
    high_m: float
    region: GroundRegion | None
    """None: the whole view."""
    tilt: bool

    def plane(self, survey: Survey, region: FocusRegion, *, skip_broken: bool) -> Plane:
        """Return the plane that a region is in focus on; the result is printed on standard error.

        Raises:
            ConfigurationError: if nothing is found.
        """
        frames = _frames(survey, region, Plane((self.low_m + self.high_m) / 2), skip_broken=skip_broken)
        result = find_focus(frames, region, self.low_m, self.high_m, tilt=self.tilt)
        if not result.found:
            raise ConfigurationError(
                f"--autofocus found no focal plane from {self.low_m:g} to {self.high_m:g} m: {result.reason}. Try "
                "another range, view or region, or give --plane-z."
            )
        tilt = "".join(
            f", {math.degrees(math.atan(slope)):+.1f}° along {axis}"
            for axis, slope in (("y", result.plane.slope_y), ("x", result.plane.slope_x))
            if self.tilt
        )
        typer.echo(
            f"autofocus: z = {result.height_m:.2f} ± {result.sigma_m:.2f} m{tilt}, confidence {result.confidence:.2f}",
            err=True,
        )
        return result.plane

    def terrain(self, survey: Survey, region: FocusRegion, terrain: Terrain, *, skip_broken: bool) -> Terrain:
        """Return the terrain at the offset that a region is in focus on; the result is printed on standard error.

        Where the frames tell little, the offset is small, as the terrain is near the right height to begin with.
        """
        frames = _frames(survey, region, terrain, skip_broken=skip_broken)
        result = find_terrain_focus(frames, region, terrain, self.low_m, self.high_m)
        little = "" if result.by_frames else ", mostly from the known terrain: the images contain little information"
        shift = f"{result.offset_m:+.2f} ± {result.sigma_m:.2f} m"
        typer.echo(f"autofocus: terrain shifted by {shift}{little}", err=True)
        return terrain.moved(result.offset_m)


def plane_or_autofocus(
    plane_z: float | None, autofocus: str | None, region: str | None, *, tilt: bool
) -> float | Autofocus:
    """Return the height of the focal plane, or the values for autofocus.

    Raises:
        ConfigurationError: unless exactly one of both is asked for, and well.
        ImagingError: if the region has no area.
    """
    if plane_z is not None and autofocus is None:
        for name, given in (("--focus-region", region is not None), ("--focus-tilt", tilt)):
            if given:
                raise ConfigurationError(f"{name} requires --autofocus.")
        if not abs(plane_z) <= MAX_HEIGHT_M:
            raise ConfigurationError(
                f"--plane-z must lie between {-MAX_HEIGHT_M:,.0f} and {MAX_HEIGHT_M:,.0f} m, got {plane_z:g}."
            )
        return plane_z
    if autofocus is not None and plane_z is None:
        return Autofocus(*_height_range(autofocus), None if region is None else _region(region), tilt)
    problem = "neither is given" if plane_z is None else "both are given"
    raise ConfigurationError(f"Give the focal plane as --plane-z Z, or let --autofocus LOW,HIGH find it: {problem}.")


@dataclass(frozen=True, slots=True)
class _ShownFrames:
    """Frames that show how far each pass through them is."""

    frames: LazyFrames

    def __iter__(self) -> Iterator[Frame]:
        with progress("Focusing", len(self.frames)) as advance:
            for frame in self.frames:
                yield frame
                advance(1)


def _frames(survey: Survey, region: FocusRegion, surface: Plane | Terrain, *, skip_broken: bool) -> _ShownFrames:
    """Return the frames that see a region."""
    points_m = region.points_m(surface)
    seeing = [image for image in survey.images if _sees(image, points_m)]
    return _ShownFrames(LazyFrames(seeing, survey.bands, skip_broken))


def _sees(image: SurveyImage, points_m: NDArray[np.float64]) -> bool:
    pixels = project_points(points_m, image.camera, image.pose)
    return bool(np.any(seen_pixels(pixels, image.camera)))


def _height_range(text: str) -> tuple[float, float]:
    heights_m = finite_numbers(text)
    if len(heights_m) != 2 or heights_m[0] >= heights_m[1]:
        raise ConfigurationError(f"--autofocus needs two heights LOW,HIGH in metres, the lower first, got {text!r}.")
    return heights_m[0], heights_m[1]


def _region(text: str) -> GroundRegion:
    edges_m = finite_numbers(text)
    if len(edges_m) != 4 or edges_m[0] >= edges_m[2] or edges_m[1] >= edges_m[3]:
        raise ConfigurationError(f"--focus-region needs X0,Y0,X1,Y1 in metres, the smaller corner first, got {text!r}.")
    return GroundRegion(*edges_m)
