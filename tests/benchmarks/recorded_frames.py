"""Frames of a recorded flight as a mission's steps have them, for benchmarks on real pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame
from aos_gcs.surveys.conventions import parse_convention
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.poses_file import read_poses

SCALES_PX = (1.0, 2.0, 4.0)
"""Standard deviations of the Gaussians that the other three bands are smoothed by: grey recordings have one band."""


def recorded_frames(
    folder: Path, count: int, *, fov_deg: float, convention: str, plane_z_m: float, bands: tuple[str, ...]
) -> list[Frame]:
    """Return consecutive frames from the middle of a recording, in bytes, above the plane z = 0.

    The last band is the grey picture, the others are the same at coarser scales: their values are those of the forest,
    with its edges, its heavy tails and its correlation of bands.
    """
    survey = read_poses(
        folder / "poses.json", folder / "images", np.radians(fov_deg), convention=parse_convention(convention)
    )
    first = max(0, (len(survey.images) - count) // 2)
    frames = []
    for index, image in enumerate(survey.images[first : first + count]):
        frame = read_frame(image, survey.bands, index)
        grey = np.ascontiguousarray(frame.image[:, :, 0])
        scales = [cv2.GaussianBlur(grey, (0, 0), scale_px) for scale_px in SCALES_PX]
        pose = Pose(frame.pose.position_enu_m - [0.0, 0.0, plane_z_m], frame.pose.R_cam2enu)
        frames.append(replace(frame, image=np.dstack([*scales, grey]), bands=bands, pose=pose))
    return frames
