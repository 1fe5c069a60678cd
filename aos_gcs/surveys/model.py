"""Data types of a recorded flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose


@dataclass(frozen=True, slots=True, eq=False)
class SurveyImage:
    """One image of a recording, not read yet."""

    path: Path
    pose: Pose
    """Pose in the world of the recording, whose axes need not be east-north-up."""
    camera: CameraModel


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """A recorded flight."""

    images: tuple[SurveyImage, ...]
    bands: tuple[str, ...]
    """Bands of every image."""
    origin: GeodeticPosition | None
    """Origin of the world, which is then east-north-up; None where it is not known."""
    left_out: Mapping[str, str]
    """Reasons why images take no part, by file name."""
