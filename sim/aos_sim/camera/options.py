"""Options that cameras on board and cameras beside a vehicle have in common."""

from __future__ import annotations

import math

from aos_gcs.errors import ConfigurationError


def check_camera_options(image_size_px: int, fov_rad: float, http_port: int) -> None:
    """Check the options of cameras and their image server.

    Raises:
        ConfigurationError: a value is out of its range.
    """
    if not 16 <= image_size_px <= 4096:
        raise ConfigurationError(f"--image-size must lie within 16 and 4096, got {image_size_px}.")
    if not 0.0 < fov_rad < math.pi:
        raise ConfigurationError(f"--fov must lie within 0 and 180 degrees, got {math.degrees(fov_rad):g}.")
    if not 0 <= http_port <= 65535:
        raise ConfigurationError(f"--http-port must lie within 0 and 65535, got {http_port}.")
