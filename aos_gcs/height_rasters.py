"""Heights in raster files, as rasterio opens them: refused where they are none, in metres where they are scaled."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.input_values import require_file

LEAST_M, GREATEST_M = -500.0, 9000.0
"""Heights on the earth, with some room."""
_METRES = frozenset({"", "m", "metre", "meter", "metres", "meters"})
_COLOURS = frozenset({"palette", "red", "green", "blue", "alpha", "cyan", "magenta", "yellow", "black"})
_LEAST_TEXT_BYTES = 2
"""Bytes of a height in a text file: a digit and what parts it from the next."""


def check_file(path: Path, name: str) -> None:
    """Refuse what GDAL would wait for, or fetch from elsewhere.

    Args:
        path: raster file.
        name: what it is called in errors.

    Raises:
        InputDataError: it is no file, or GDAL cannot open files of that name.
    """
    try:
        str(path).encode()
    except UnicodeEncodeError:
        raise InputDataError(f"{name!a} cannot be read: its name is not UTF-8. Rename it.") from None
    require_file(path, name)


def check_heights(dataset: Any, path: Path, name: str) -> None:
    """Refuse rasters that hold something other than heights in metres.

    Args:
        dataset: rasterio's dataset.
        path: its file.
        name: what it is called in errors.

    Raises:
        InputDataError: it is a picture, has several bands, a place or scale of no use, another unit, or lacks its end.
    """
    colours = {getattr(colour, "name", "") for colour in dataset.colorinterp} & _COLOURS
    if colours or (dataset.count > 1 and dataset.dtypes[0] == "uint8"):
        raise InputDataError(f"{name} is a picture ({dataset.count} bands of {dataset.dtypes[0]}), not heights.")
    if dataset.count != 1:
        raise InputDataError(
            f"{name} has {dataset.count} bands: extract the one with the heights (gdal_translate -b 1 IN OUT)."
        )
    if "complex" in dataset.dtypes[0]:
        raise InputDataError(f"{name} has complex numbers, which are not heights.")
    transform = dataset.transform
    if not all(math.isfinite(value) for value in transform) or transform.determinant == 0.0:
        raise InputDataError(f"{name} has no cells of a finite size: its place is not known.")
    if not (math.isfinite(dataset.scales[0]) and dataset.scales[0] != 0.0 and math.isfinite(dataset.offsets[0])):
        raise InputDataError(
            f"{name} states the scale {dataset.scales[0]:g} and the offset {dataset.offsets[0]:g}, which are invalid."
        )
    unit = (dataset.units[0] or "").lower()
    if unit not in _METRES:
        raise InputDataError(f"The heights of {path} are in {unit!r}, not in metres: convert them.")
    # GDAL would look for rows that are not there, with gigabytes of memory.
    if dataset.driver == "AAIGrid" and path.stat().st_size < _LEAST_TEXT_BYTES * dataset.width * dataset.height - 1:
        raise InputDataError(f"{name} is incomplete: it is too small for {dataset.width} x {dataset.height} heights.")


def read_heights(dataset: Any, window: Any = None) -> NDArray[np.floating[Any]]:
    """Return heights in metres, with the scale and the offset that the file states; NaN where they are not known.

    They have the precision of the file, or more.

    Raises:
        rasterio.errors.RasterioError: they cannot be read.
    """
    heights: NDArray[Any] = dataset.read(1, window=window)
    if _may_have_holes(dataset, heights):
        masked = dataset.read(1, window=window, masked=True)
        heights = np.ma.filled(masked.astype(np.float64), np.nan)
        heights[~np.isfinite(heights)] = np.nan
    scale, offset = dataset.scales[0], dataset.offsets[0]
    if (scale, offset) != (1.0, 0.0):
        heights = heights * np.float64(scale) + np.float64(offset)
    return np.asarray(heights) if heights.dtype.kind == "f" else heights.astype(np.float64)


def _may_have_holes(dataset: Any, heights: NDArray[Any]) -> bool:
    """Return whether a look at the mask is needed, which takes several times as long as reading."""
    flags = {flag.name for flag in dataset.mask_flag_enums[0]}
    least, most = float(heights.min()), float(heights.max())
    if not (math.isfinite(least) and math.isfinite(most)) or not flags <= {"all_valid", "nodata"}:
        return True
    # GDAL compares with a tolerance; a value that is rounded in the file still counts as a hole.
    return "nodata" in flags and not math.isnan(dataset.nodata) and _spans(least, most, dataset.nodata)


def _spans(least: float, most: float, value: float) -> bool:
    slack = 1.0 + 1e-3 * abs(value)
    return least - slack <= value <= most + slack


def refuse_impossible(heights: NDArray[np.floating[Any]], name: str) -> None:
    """Refuse heights that no place on earth has; what is not known, NaN, is none.

    Args:
        heights: heights in metres.
        name: what their file is called in errors.

    Raises:
        InputDataError: there are some, most likely holes that the file does not declare, or feet.
    """
    least, most = float(np.fmin.reduce(heights, axis=None)), float(np.fmax.reduce(heights, axis=None))
    if least < LEAST_M:
        raise InputDataError(
            f"{name} has heights of {least:g} m: declare them as holes (gdal_edit -a_nodata {least:g})."
        )
    if most > GREATEST_M:
        raise InputDataError(
            f"{name} has heights of {most:g}: no place on earth is so high. Are they in feet? Convert them to metres."
        )


def unwrapped(longitudes: NDArray[np.float64], about: float, turn: float = 360.0) -> NDArray[np.float64]:
    """Return longitudes across the meridian where they end, within half a turn of another.

    Those that are not finite stay as they are.

    Args:
        longitudes: longitudes in units of which a turn has so many.
        about: longitude to be near to.
        turn: a whole turn.
    """
    with np.errstate(invalid="ignore"):
        turned = longitudes - turn * np.rint((longitudes - about) / turn)
    return np.where(np.isfinite(turned), turned, longitudes)


def gdal_reason(error: Exception) -> str:
    """Return what GDAL says of a file, to stand before a full stop."""
    text = str(error).strip().rstrip(".")
    if "Read failed" in text or "Failed to read" in text:
        return "it is damaged or incomplete: copy it again from its source"
    return text
