"""A flight above textured hills whose recorded poses have a wrong mount, clock and focal length, rendered."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, Pose, nadir_pose
from aos_gcs.geometry.rotations import R_from_rotation_vector, R_from_yaw_pitch_roll
from tests.fakes.photographs import exif_block, write_photograph, xmp_packet

SPEED_MPS = 5.0
INTERVAL_S = 0.8
FRAMES = 4
"""Images of a line."""
TEXEL_M = 0.06
FOV_DEG = 60.0


@dataclass(frozen=True, slots=True)
class Truth:
    """What calibration must find."""

    boresight_deg: tuple[float, float, float] = (1.2, -2.0, 1.6)
    """Yaw, pitch, roll of the true camera against the recorded one."""
    clock_offset_s: float = 0.08
    focal_error: float = 0.02
    """True focal length over the one that is told, minus 1."""
    lens: tuple[float, ...] = (-0.04, 0.0, 0.0, 0.0, 0.0)
    heights_m: tuple[float, ...] = (20.0, 28.0)
    size_px: tuple[int, int] = (144, 108)
    position_sigma_m: float = 0.02
    attitude_sigma_deg: float = 0.05
    drift_m: float = 0.0
    """Standard deviation of an error of the recorded positions that is the same along a line."""
    headings_deg: tuple[float, ...] = field(default=(0.0, 180.0, 90.0, 270.0))


def hill_m(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(0.8 * np.sin(0.23 * x) * np.cos(0.19 * y) + 0.02 * x)


@cache
def _texture() -> NDArray[np.float64]:
    noise = np.random.default_rng(7).normal(size=(1500, 1500))
    texture = sum(cv2.GaussianBlur(noise, (0, 0), sigma) * sigma for sigma in (1.0, 2.5, 6.0))
    return np.asarray(120.0 + 38.0 * texture / np.std(texture))


class CalibrationFlight:
    """Lines in several directions at several heights, as images and a poses file with times."""

    def __init__(self, folder: Path, truth: Truth) -> None:
        self.images = folder / "images"
        self.images.mkdir()
        self.poses = folder / "poses.json"
        self.document: dict[str, list[dict[str, Any]]] = {"images": []}
        self.true_poses: list[Pose] = []
        rng, self._texture = np.random.default_rng(8), _texture()
        width, height = truth.size_px
        told = CameraModel.from_fov(width, height, math.radians(FOV_DEG))
        focal_px = told.fx_px * (1.0 + truth.focal_error)
        lens = LensDistortion(LensModel.BROWN_CONRADY, truth.lens) if any(truth.lens) else None
        self.camera = CameraModel(width, height, focal_px, focal_px, told.cx_px, told.cy_px, lens)
        boresight = R_from_yaw_pitch_roll(tuple(math.radians(angle) for angle in truth.boresight_deg))
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        normalised = self.camera.from_pixels(np.stack((u.ravel(), v.ravel()), axis=1))
        self._rays_cam = np.column_stack((normalised, np.ones(u.size)))
        R_true2recorded = R_CAM2SENSOR_FRD.T @ boresight @ R_CAM2SENSOR_FRD
        time_s = 0.0
        for line, (height_m, heading_deg) in enumerate(
            (height_m, heading_deg) for height_m in truth.heights_m for heading_deg in truth.headings_deg
        ):
            heading_rad = math.radians(heading_deg)
            along = np.array([math.sin(heading_rad), math.cos(heading_rad), 0.0])
            aside = np.array([along[1], -along[0], 0.0]) * (2.0 if line % 2 else -2.0)
            drift_m = rng.normal(scale=truth.drift_m, size=3) if truth.drift_m else np.zeros(3)
            time_s += 30.0
            for step in range(FRAMES):
                time_s += INTERVAL_S
                recorded_m = along * SPEED_MPS * INTERVAL_S * (step - (FRAMES - 1) / 2) + aside + [0.0, 0.0, height_m]
                R_recorded = nadir_pose(recorded_m, heading_rad).R_cam2enu
                R_error = R_from_rotation_vector(rng.normal(scale=math.radians(truth.attitude_sigma_deg), size=3))
                centre_m = recorded_m + along * SPEED_MPS * truth.clock_offset_s
                centre_m = centre_m + rng.normal(scale=truth.position_sigma_m, size=3)
                self.true_poses.append(Pose(centre_m, R_recorded @ R_true2recorded @ R_error))
                self._write(line, step, centre_m, self.true_poses[-1].R_cam2enu, rng)
                rows = np.column_stack((R_recorded, recorded_m + drift_m)).tolist()
                self.document["images"].append(
                    {"imagefile": f"{line}_{step}.png", "M3x4": rows, "time_s": round(time_s, 6)}
                )
        self.save()

    def save(self) -> None:
        self.poses.write_text(json.dumps(self.document))

    def write_photographs(self, folder: Path) -> None:
        """Write the images into a folder, with their recorded poses as DJI's tags."""
        folder.mkdir()
        takeoff = LocalFrame(GeodeticPosition(48.3069, 14.2858, AmslM(310.0)))
        focal_px = CameraModel.from_fov(self.camera.width_px, 1, math.radians(FOV_DEG)).fx_px
        for entry in self.document["images"]:
            M = np.array(entry["M3x4"])
            place = takeoff.to_geodetic(M[:, 3])
            up_of_image = -M[:, 1]
            tags = {
                "drone-dji:GpsLatitude": f"{place.latitude_deg:.9f}",
                "drone-dji:GpsLongitude": f"{place.longitude_deg:.9f}",
                "drone-dji:RelativeAltitude": f"+{M[2, 3]:.3f}",
                "drone-dji:GimbalYawDegree": math.degrees(math.atan2(up_of_image[0], up_of_image[1])),
                "drone-dji:GimbalPitchDegree": -90.0,
                "drone-dji:CalibratedFocalLength": focal_px,
            }
            image = cv2.imread(str(self.images / entry["imagefile"]), cv2.IMREAD_GRAYSCALE)
            path = (folder / entry["imagefile"]).with_suffix(".jpg")
            write_photograph(path, np.asarray(image, np.uint8), exif_block(), xmp_packet(tags))

    def _write(
        self, line: int, step: int, centre_m: NDArray[np.float64], R: NDArray[np.float64], rng: np.random.Generator
    ) -> None:
        rays = self._rays_cam @ R.T
        depth_m = -centre_m[2] / rays[:, 2]
        for _ in range(5):
            points_m = centre_m + depth_m[:, np.newaxis] * rays
            depth_m = (hill_m(points_m[:, 0], points_m[:, 1]) - centre_m[2]) / rays[:, 2]
        points_m = centre_m + depth_m[:, np.newaxis] * rays
        texels = points_m[:, 1::-1].T / TEXEL_M + np.array(self._texture.shape)[:, np.newaxis] / 2
        values = map_coordinates(self._texture, texels, order=1, mode="reflect").reshape(
            self.camera.height_px, self.camera.width_px
        )
        image = np.clip(np.round(values + rng.normal(scale=1.5, size=values.shape)), 0, 255).astype(np.uint8)
        cv2.imwrite(str(self.images / f"{line}_{step}.png"), image)

    def arguments(self, out: Path, *options: object) -> list[str]:
        given = ("--poses", self.poses, "--convention", "camera-to-world,enu", "--fov", FOV_DEG, "--out", out, *options)
        return ["calibrate", str(self.images), *map(str, given)]
