"""Temperatures of a radiometric photograph of any make that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.surveys.radiometric.dji import ThermalSdk, thermal_sdk
from aos_gcs.surveys.radiometric.flir import read_flir
from aos_gcs.surveys.radiometric.settings import TemperatureSettings

_HEAD_BYTES = 65_536
"""Part of a file in which a camera writes its make."""


@dataclass(frozen=True, slots=True, eq=False)
class ThermalCamera:
    """What the data of the temperatures tell of their camera."""

    height_px: int
    """May differ from that of the picture in the same file."""
    width_px: int
    horizontal_fov_rad: float | None
    """Full horizontal field of view; None where it is not told."""


def read_temperatures(content: bytes, settings: TemperatureSettings) -> NDArray[np.float32]:
    """Read the temperatures of objects in a JPEG file, degrees Celsius, shape (H, W).

    Raises:
        InputDataError: with the reason alone, so that it can stand behind the file's name.
        ConfigurationError: if DJI's Thermal SDK is not usable.
    """
    flir = read_flir(content)
    return flir.celsius(settings.conditions) if flir else _sdk(content, settings).celsius(content, settings.conditions)


def read_thermal_camera(content: bytes, settings: TemperatureSettings) -> ThermalCamera:
    """Read what a JPEG file tells of the camera of its temperatures, which those of DJI are not measured for.

    Raises:
        InputDataError: with the reason alone, if it has no temperatures, or they cannot be had under these settings.
        ConfigurationError: if DJI's Thermal SDK is not usable.
    """
    flir = read_flir(content)
    if flir:
        height_px, width_px = flir.celsius(settings.conditions).shape
        return ThermalCamera(height_px, width_px, flir.horizontal_fov_rad)
    height_px, width_px = _sdk(content, settings).size_px(content, settings.conditions)
    return ThermalCamera(height_px, width_px, None)


def _sdk(content: bytes, settings: TemperatureSettings) -> ThermalSdk:
    """Return what reads the temperatures of a file that has none of FLIR."""
    if b"DJI" not in content[:_HEAD_BYTES]:
        raise InputDataError("it has no radiometric data of FLIR or DJI")
    if settings.dji_library is None:
        raise InputDataError(
            "it is a picture of DJI, whose temperatures are read by DJI's Thermal SDK: give its folder (--dji-sdk), or "
            "convert the photographs to TIFF of floating-point numbers in a folder of their own"
        )
    return thermal_sdk(settings.dji_library)
