"""Result of a calibration: intrinsics, mount and clock of a camera, as a file that is a camera file as well."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.cameras.intrinsics import Intrinsics
from aos_gcs.cameras.lens_files import read_document, read_lens_file
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, Pose
from aos_gcs.geometry.rotations import R_from_yaw_pitch_roll
from aos_gcs.input_values import finite_number, printable

PARAMETERS = ("yaw_deg", "pitch_deg", "roll_deg", "focal_px", "k1", "k2", "clock_offset_s")
"""Order of the covariance."""

MAX_TURN_DEG, MAX_OFFSET_S = 45.0, 10.0
"""Largest corrections that are credible."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """Camera, mount and clock."""

    intrinsics: Intrinsics
    boresight_rad: tuple[float, float, float]
    """Turn of the optical axis against its recorded attitude: yaw, pitch, roll about down, right, forward."""
    clock_offset_s: float
    """Addition to the times of images that makes them times of the poses."""
    doubts: tuple[str, ...] = ()
    """Reasons why its own computation doubts it; it was written nevertheless, as somebody asked for it."""

    @property
    def R_calibrated2recorded(self) -> NDArray[np.float64]:
        """Rotation from the camera's true axes to those that are recorded, shape (3, 3)."""
        R_frd = R_from_yaw_pitch_roll(self.boresight_rad)
        return np.asarray(R_CAM2SENSOR_FRD.T @ R_frd @ R_CAM2SENSOR_FRD)

    def pose(self, recorded: Pose) -> Pose:
        """Return the camera's pose for a recorded one; the clock is not corrected."""
        return Pose(recorded.position_enu_m, recorded.R_cam2enu @ self.R_calibrated2recorded)


def calibration_document(
    camera: CameraModel,
    boresight_rad: tuple[float, float, float],
    clock_offset_s: float,
    covariance: NDArray[np.float64],
    statistics: dict[str, Any],
) -> dict[str, Any]:
    """Return the content of a calibration's file.

    Args:
        camera: calibrated camera.
        boresight_rad: yaw, pitch, roll of the mount.
        clock_offset_s: offset of the clock; 0 where it is not known.
        covariance: of :data:`PARAMETERS`, in their units.
        statistics: further fields.
    """
    lens = camera.distortion
    yaw_deg, pitch_deg, roll_deg = (math.degrees(angle) for angle in boresight_rad)
    return {
        "image_width": camera.width_px,
        "image_height": camera.height_px,
        "camera_matrix": camera.K.tolist(),
        **(
            {}
            if lens is None
            else {"distortion_model": str(lens.model), "distortion_coefficients": list(lens.coefficients)}
        ),
        "boresight_deg": [yaw_deg, pitch_deg, roll_deg],
        "clock_offset_s": clock_offset_s,
        "parameters": list(PARAMETERS),
        "covariance": covariance.tolist(),
        **statistics,
    }


def encode_calibration(document: dict[str, Any]) -> bytes:
    """Return the bytes of a calibration's file."""
    return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()


def read_calibration(path: Path) -> Calibration:
    """Read the result of ``aos-gcs calibrate``.

    Raises:
        InputDataError: naming the file, the field, and what is wrong with it.
    """
    document = read_document(path)
    angles, offset = document.get("boresight_deg"), document.get("clock_offset_s", 0.0)
    numbers: list[Any] = angles if isinstance(angles, list) and len(angles) == 3 else [None]
    if not all(_is_number(angle) and abs(angle) <= MAX_TURN_DEG for angle in numbers):
        raise InputDataError(
            f"The calibration {path}: 'boresight_deg' must be yaw, pitch and roll of at most {MAX_TURN_DEG:g} degrees, "
            f"got {angles!r}. A camera file without it goes with --camera."
        )
    if not _is_number(offset) or abs(offset) > MAX_OFFSET_S:
        raise InputDataError(
            f"The calibration {path}: 'clock_offset_s' must be a number of at most {MAX_OFFSET_S:g} s, got {offset!r}."
        )
    doubts = document.get("doubts", [])
    if not (isinstance(doubts, list) and all(isinstance(doubt, str) for doubt in doubts)):
        raise InputDataError(f"The calibration {path}: 'doubts' must be a list of texts, got {doubts!r}.")
    yaw_rad, pitch_rad, roll_rad = (math.radians(angle) for angle in numbers)
    return Calibration(read_lens_file(path), (yaw_rad, pitch_rad, roll_rad), float(offset), tuple(doubts))


def warning(calibration: Calibration, path: Path) -> str | None:
    """Return what the user of a calibration's file must be told; None where it is not doubted."""
    if not calibration.doubts:
        return None
    return printable(f"The calibration {path} is doubtful and was written with --force: {' '.join(calibration.doubts)}")


def _is_number(value: Any) -> bool:
    return finite_number(value) is not None
