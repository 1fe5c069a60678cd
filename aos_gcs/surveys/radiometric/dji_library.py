"""The library of DJI's Thermal SDK, which alone knows what the counts in DJI's radiometric JPEG files mean.

Source: DJI, *Thermal SDK*, ``tsdk-core/api/dirp_api.h`` (versions 1.4 to 1.7).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.surveys.radiometric.settings import MeasurementConditions

_NO_TEMPERATURES = frozenset({-4, -5, -6, -7})
_UNUSABLE = {
    -14: "it is not activated",
    -15: "its libv_list.ini is not valid",
    -16: "libraries that it needs are missing",
}
_CONDITIONS = ("distance", "humidity", "emissivity", "reflected", "air")
"""Conditions in the order of the library's structure, by the names of ``--degrees``; version 1.4 has no air."""


def picture_size(path: str, content: bytes, conditions: MeasurementConditions) -> tuple[int, int]:
    """Return height and width of the temperatures of a file, pixels, which takes a hundredth of measuring them.

    Arguments and errors are those of :func:`measure`.
    """
    with _opened(path, content, conditions) as (_, _, size_px):
        return size_px


def measure(path: str, content: bytes, conditions: MeasurementConditions) -> NDArray[np.float32]:
    """Return the temperatures of objects, degrees Celsius, shape (H, W).

    The library may end this process, or take it over, where a file is damaged.

    Args:
        path: the library.
        content: a JPEG file.
        conditions: conditions of the measurement.

    Raises:
        InputDataError: with the reason alone, if the file has none, or the library refuses it or the conditions.
        ConfigurationError: if the library cannot be used.
    """
    with _opened(path, content, conditions) as (library, handle, size_px):
        celsius = np.empty(size_px, np.float32)
        pixels = celsius.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
        _check(library.dirp_measure_ex(handle, pixels, ctypes.c_int32(celsius.nbytes)))
    return celsius


@contextmanager
def _opened(
    path: str, content: bytes, conditions: MeasurementConditions
) -> Iterator[tuple[ctypes.CDLL, ctypes.c_void_p, tuple[int, int]]]:
    """Open a file under some conditions: the library, its handle, and height and width in pixels."""
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        raise ConfigurationError(f"The library of DJI's Thermal SDK cannot be loaded: {error}.") from error
    handle = ctypes.c_void_p()
    # The library reads from it until the handle is destroyed.
    data = ctypes.create_string_buffer(content, len(content))
    _check(library.dirp_create_from_rjpeg(data, ctypes.c_int32(len(content)), ctypes.byref(handle)))
    try:
        _set_conditions(library, handle, conditions)
        size = (ctypes.c_int32 * 2)()
        _check(library.dirp_get_rjpeg_resolution(handle, size))
        width_px, height_px = size
        yield library, handle, (height_px, width_px)
    finally:
        library.dirp_destroy(handle)


def _set_conditions(library: ctypes.CDLL, handle: ctypes.c_void_p, conditions: MeasurementConditions) -> None:
    """Replace conditions that the camera was set to."""
    percent = None if conditions.humidity is None else 100.0 * conditions.humidity
    given = (conditions.distance_m, percent, conditions.emissivity, conditions.reflected_c, conditions.air_c)
    if all(value is None for value in given):
        return
    wanted = [None if value is None else ctypes.c_float(value).value for value in given]
    values = (ctypes.c_float * len(wanted))(*[math.nan] * len(wanted))
    limits = (ctypes.c_float * (2 * len(wanted)))(*[math.nan] * (2 * len(wanted)))
    _check(library.dirp_get_measurement_params(handle, values))
    _check(library.dirp_get_measurement_params_range(handle, limits))
    for index, (name, value) in enumerate(zip(_CONDITIONS, wanted, strict=True)):
        if value is None:
            continue
        least, most = limits[2 * index : 2 * index + 2]
        if not least < most:
            raise InputDataError(f"DJI's Thermal SDK takes no {name} for it; leave {name} out of --degrees")
        if not least <= value <= most:
            scale = 0.01 if name == "humidity" else 1.0
            raise InputDataError(
                f"DJI's Thermal SDK takes a value of {name} from {scale * least:g} to {scale * most:g} for it, not "
                f"{scale * value:g}; change --degrees"
            )
        values[index] = value
    _check(library.dirp_set_measurement_params(handle, values))


def _check(code: int) -> None:
    if code in _UNUSABLE:
        raise ConfigurationError(f"The library of DJI's Thermal SDK cannot be used: {_UNUSABLE[code]}.")
    if code in _NO_TEMPERATURES:
        raise InputDataError("it has no radiometric data of DJI, or damaged ones")
    if code != 0:
        raise InputDataError(f"DJI's Thermal SDK refuses it, or the conditions of --degrees (error {code})")
