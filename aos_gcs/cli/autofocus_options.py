"""The focal plane of ``aos-gcs integrate``: given, or found by autofocus."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import typer

from aos_gcs.cli.output import progress
from aos_gcs.cli.recordings import RecordedView, read_frames
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.autofocus import find_focus
from aos_gcs.imaging.focus_region import ViewRegion
from aos_gcs.imaging.model import Frame


@dataclass(frozen=True, slots=True)
class RecordedFrames:
    """The frames of a recording, read anew each time they are gone through, so that memory holds one of them."""

    views: Sequence[RecordedView]
    horizontal_fov_rad: float

    def __iter__(self) -> Iterator[Frame]:
        """Read one frame after the other, and show how far it is."""
        with progress("Focusing", len(self.views)) as advance:
            for frame in read_frames(self.views, self.horizontal_fov_rad):
                yield frame
                advance(1)


def focal_height_or_range(plane_z: float | None, autofocus: str | None) -> float | tuple[float, float]:
    """Return the height of the focal plane, or the range in which autofocus has to find it.

    Raises:
        ConfigurationError: unless exactly one of both options is given, and well.
    """
    if plane_z is not None and autofocus is None:
        if not math.isfinite(plane_z):
            raise ConfigurationError(f"--plane-z must be a finite number of metres, got {plane_z}.")
        return plane_z
    if autofocus is not None and plane_z is None:
        return _height_range(autofocus)
    problem = "neither is given" if plane_z is None else "both are given"
    raise ConfigurationError(f"Give the focal plane as --plane-z Z, or let --autofocus LOW,HIGH find it: {problem}.")


def focal_height_m(
    focus: float | tuple[float, float], views: Sequence[RecordedView], camera: CameraModel, pose: Pose
) -> float:
    """Return the height of the focal plane; what autofocus has found is told on standard error.

    Args:
        focus: as :func:`focal_height_or_range` has given it.
        views: of the recording, with the horizontal field of view of the virtual camera.
        camera: the virtual camera, whose whole view has to be in focus.
        pose: of the virtual camera.

    Raises:
        ConfigurationError: if autofocus finds no height.
    """
    if not isinstance(focus, tuple):
        return focus
    frames = RecordedFrames(views, camera.horizontal_fov_rad)
    result = find_focus(frames, ViewRegion.whole(camera, pose), *focus)
    if not result.found:
        raise ConfigurationError(
            f"--autofocus found no focal plane from {focus[0]:g} to {focus[1]:g} m: {result.reason}. Try another range "
            "or view, or give --plane-z."
        )
    typer.echo(
        f"autofocus: z = {result.height_m:.2f} ± {result.sigma_m:.2f} m, confidence {result.confidence:.2f}", err=True
    )
    return result.height_m


def _height_range(text: str) -> tuple[float, float]:
    try:
        low_m, high_m = (float(part) for part in text.split(","))
    except ValueError:
        low_m = high_m = math.nan
    if not (math.isfinite(low_m) and math.isfinite(high_m) and low_m < high_m):
        raise ConfigurationError(f"--autofocus needs two heights LOW,HIGH in metres, the lower first, got {text!r}.")
    return low_m, high_m
