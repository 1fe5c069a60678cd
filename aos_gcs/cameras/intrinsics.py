"""Intrinsics of a camera, as calibrations give them: for one size of its images, and valid for others of its shape."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import COEFFICIENTS, LensDistortion, LensModel
from aos_gcs.input_values import shown

_SHAPE_TOLERANCE = 0.01
"""Relative difference of aspect ratios that is left to rounding."""


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Focal lengths, principal point and lens of a camera."""

    fx_px: float
    fy_px: float
    cx_px: float | None = None
    """None: the centre of the image."""
    cy_px: float | None = None
    size_px: tuple[int, int] | None = None
    """Width and height of the images that the values hold for; None: of those at hand."""
    distortion: LensDistortion | None = None
    source: str = "the camera"
    """File that the values come from, for messages."""

    def camera(self, width_px: int, height_px: int) -> CameraModel:
        """Return the camera for images of a size; values for another size of the same shape are scaled.

        Raises:
            InputDataError: if the images have another shape, or the principal point lies outside of them.
        """
        width, height = self.size_px or (width_px, height_px)
        scale_u, scale_v = width_px / width, height_px / height
        if abs(scale_u / scale_v - 1.0) > _SHAPE_TOLERANCE:
            raise InputDataError(
                f"{self.source} is for images of {width} x {height} pixels; the images have {width_px} x {height_px}, "
                "which is another shape. Calibrate the camera with images of this kind."
            )
        centre_u = (width - 1) / 2 if self.cx_px is None else self.cx_px
        centre_v = (height - 1) / 2 if self.cy_px is None else self.cy_px
        if not (0.0 <= centre_u <= width and 0.0 <= centre_v <= height):
            raise InputDataError(
                f"{self.source} has its principal point at ({centre_u:g}, {centre_v:g}), outside of images of "
                f"{width} x {height} pixels."
            )
        return CameraModel(
            width_px,
            height_px,
            self.fx_px * scale_u,
            self.fy_px * scale_v,
            # Pixel centres lie at integers: the image begins half a pixel before the first.
            (centre_u + 0.5) * scale_u - 0.5,
            (centre_v + 0.5) * scale_v - 0.5,
            self.distortion,
        )


def parse_lens(model: LensModel, coefficients: Sequence[object], name: str) -> LensDistortion:
    """Return a lens; trailing coefficients may be left out.

    Raises:
        InputDataError: naming what is wrong with them.
    """
    most = COEFFICIENTS[model]
    try:
        values = [math.nan if isinstance(value, bool) else float(value) for value in coefficients]  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        values = []
    # Four is the least that either model is calibrated with.
    if not 4 <= len(values) <= most or not all(map(math.isfinite, values)):
        count = "4" if most == 4 else f"4 to {most}"
        raise InputDataError(f"{name} needs {count} finite coefficients, got {shown(list(coefficients))}.")
    return LensDistortion(model, (*values, *[0.0] * (most - len(values))))
