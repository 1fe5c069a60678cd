"""Factory calibration of a lens, which DJI's aircraft write into each photograph that they have not corrected by it."""

from __future__ import annotations

import math
from collections.abc import Mapping

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel

_UNCORRECTED = "0"
_COUNT = 9


def factory_camera(xmp: Mapping[str, str], width_px: int, height_px: int) -> CameraModel | None:
    """Return the calibrated camera of a photograph; None where there is none, or the photograph is corrected by it.

    ``DewarpData`` is a day and, behind a semicolon, focal lengths, the principal point from the middle of the
    picture, in pixels, and OpenCV's k1, k2, p1, p2, k3. ``DewarpFlag`` is 0 where the picture is as the lens made it.

    Args:
        xmp: tags without their namespaces.
        width_px: width of the photograph as it was taken.
        height_px: its height.
    """
    numbers = _numbers(xmp.get("DewarpData", ""))
    if len(numbers) != _COUNT or xmp.get("DewarpFlag") != _UNCORRECTED:
        return None
    fx_px, fy_px, aside_px, below_px, *lens = numbers
    is_plausible = min(fx_px, fy_px) > 0.0 and 2.0 * abs(aside_px) < width_px and 2.0 * abs(below_px) < height_px
    if not is_plausible:
        return None
    # Pixel centres lie at integers.
    centre_px = (width_px - 1) / 2 + aside_px, (height_px - 1) / 2 + below_px
    return CameraModel(
        width_px, height_px, fx_px, fy_px, *centre_px, LensDistortion(LensModel.BROWN_CONRADY, tuple(lens))
    )


def _numbers(text: str) -> list[float]:
    """Return the numbers behind the day; none unless all are finite."""
    try:
        numbers = [float(part) for part in text.rpartition(";")[2].split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []
