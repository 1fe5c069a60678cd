"""Errors of a sensor: from what a scene looks like to what a camera delivers of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_sim.errors.optics import FloatArray, OpticsErrors, blurred, compressed, lagged, smeared, vignette
from aos_sim.errors.thermal import ThermalErrors, draw_thermal_pattern, thermal_drift_k

_KEPT_PATTERNS = 128


@dataclass(frozen=True, slots=True, eq=False)
class RenderedFrame:
    """One exposure of a camera whose colour and thermal images share their pixels."""

    rgb: NDArray[np.uint8]
    """Shape (H, W, 3)."""
    thermal_celsius: FloatArray
    """Apparent temperature, shape (H, W)."""


class CameraSensor:
    """The sensors of all cameras. Equal arguments give equal frames; any number of threads may call it at once.

    Args:
        thermal: errors of the thermal cameras.
        optics: errors of lenses, exposures and files.
        seed: of the cameras' fixed patterns and drifts.
    """

    def __init__(self, thermal: ThermalErrors, optics: OpticsErrors, seed: int = 0) -> None:
        self._thermal, self._optics, self._seed = thermal, optics, seed
        self._pattern = lru_cache(maxsize=_KEPT_PATTERNS)(self._draw_pattern)

    def expose(
        self,
        view: FloatArray,
        rng: np.random.Generator,
        *,
        camera_id: int = 0,
        at_s: float = 0.0,
        speed_pxps: tuple[float, float] = (0.0, 0.0),
    ) -> RenderedFrame:
        """Return the frame of one exposure.

        Args:
            view: what the scene looks like: red, green, blue (0 to 255) and degrees Celsius, shape (H, W, 4).
            rng: draws the noise.
            camera_id: whose sensors these are.
            at_s: seconds since the camera has started.
            speed_pxps: velocity of the image on the sensor, right and down.
        """
        optics, shape = self._optics, (view.shape[0], view.shape[1])
        colour = smeared(_colours(view), _moved(speed_pxps, optics.exposure_s))
        thermal = lagged(np.ascontiguousarray(view[..., 3]), _moved(speed_pxps, optics.thermal_lag_s))
        colour = blurred(colour, optics.colour_blur_px)
        thermal = blurred(thermal, optics.thermal_blur_px)
        if optics.vignetting:
            colour = colour * vignette(shape, optics.vignetting)
        noise = rng.standard_normal((*shape, 4), dtype=np.float32)
        # Adds, limits to 0 to 255 and rounds in one pass.
        noisy = cv2.addWeighted(colour, 1.0, _colours(noise), optics.colour_noise, 0.0, dtype=cv2.CV_8U)
        rgb = np.asarray(noisy, dtype=np.uint8)
        thermal = thermal + noise[..., 3] * np.float32(self._thermal.netd_k)
        drift_k = thermal_drift_k(self._thermal, (self._seed, camera_id), at_s)
        thermal = thermal + (self._pattern(camera_id, shape) + np.float32(drift_k))
        return RenderedFrame(compressed(rgb, optics.jpeg_quality) if optics.jpeg_quality else rgb, thermal)

    def _draw_pattern(self, camera_id: int, shape: tuple[int, int]) -> FloatArray:
        return draw_thermal_pattern(np.random.default_rng([self._seed, 0xF2, camera_id]), self._thermal, shape)


def _colours(image: FloatArray) -> FloatArray:
    """Return the first three of four channels."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGRA2BGR), dtype=np.float32)


def _moved(speed_pxps: tuple[float, float], duration_s: float) -> tuple[float, float]:
    right, down = speed_pxps
    return right * duration_s, down * duration_s
