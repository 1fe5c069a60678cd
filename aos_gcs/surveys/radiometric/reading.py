"""Temperatures of a radiometric photograph of any make that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.surveys.radiometric.dji import thermal_sdk
from aos_gcs.surveys.radiometric.flir import read_flir
from aos_gcs.surveys.radiometric.settings import TemperatureSettings

_HEAD_BYTES = 65_536
"""Part of a file in which a camera writes its make."""


@dataclass(frozen=True, slots=True, eq=False)
class Temperatures:
    """Temperatures of objects in a photograph, and what the same data tell of its camera."""

    celsius: NDArray[np.float32]
    """Degrees Celsius, shape (H, W), which may differ from the size of the picture."""
    horizontal_fov_rad: float | None
    """Full horizontal field of view; None where it is not told."""


def read_temperatures(content: bytes, settings: TemperatureSettings) -> Temperatures:
    """Read the temperatures of a JPEG file.

    Raises:
        InputDataError: with the reason alone, so that it can stand behind the file's name.
        ConfigurationError: if DJI's Thermal SDK is not usable.
    """
    flir = read_flir(content)
    if flir is not None:
        return Temperatures(flir.celsius(settings.scene), flir.horizontal_fov_rad)
    if b"DJI" not in content[:_HEAD_BYTES]:
        raise InputDataError("it has no radiometric data of FLIR or DJI")
    if settings.dji_library is None:
        raise InputDataError(
            "it is a picture of DJI, whose temperatures are read by DJI's Thermal SDK: give its folder (--dji-sdk), or "
            "convert the photographs to TIFF of floating-point numbers in a folder of their own"
        )
    return Temperatures(thermal_sdk(settings.dji_library).celsius(content, settings.scene), None)
