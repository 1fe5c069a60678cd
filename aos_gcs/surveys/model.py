"""Data types of a recorded flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.radiometric.settings import TemperatureSettings
from aos_gcs.surveys.takeoffs import TakeoffSite

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class SurveyImage:
    """One image of a recording, not read yet."""

    path: Path
    pose: Pose
    """Pose in the world of the recording, whose axes need not be east-north-up."""
    camera: CameraModel
    dtype: np.dtype[np.generic] | None = None
    """Type of its values; None: any that is read."""
    taken_at_s: float | None = None
    """Time of exposure by the camera's clock, from an arbitrary start; None where it is not recorded."""
    temperatures: TemperatureSettings | None = None
    """Settings under which its temperatures are read; None: its picture is read."""
    position_sigma_m: tuple[float, float, float] | None = None
    """Standard deviations of the position along x, y and z; None where they are not recorded."""
    relative_altitude_m: float | None = None
    """Height above the place of takeoff as the image tells it; None where it does not."""


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
    without_pose: tuple[str, ...] = ()
    """Names of the images beside those of a poses file that it does not name."""
    R_file2world: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    """Rotation from the axes of the poses file, which meshes share, to those of the world, shape (3, 3)."""
    remarks: tuple[str, ...] = ()
    """Remarks on the recording as a whole, for its operator."""
    warnings: tuple[str, ...] = ()
    """What may make the result wrong, with the remedy; shown beside the result, too."""
    takeoffs: tuple[TakeoffSite, ...] = ()
    """Places of takeoff of photographs; none where their altitudes are not told."""
    not_chosen: frozenset[str] = frozenset()
    """Names of the images that are left out because others were asked for."""

    @property
    def lacks_altitudes(self) -> bool:
        """Whether images tell heights above their place of takeoff, but not its altitude: it counts as sea level."""
        return not self.takeoffs and any(image.relative_altitude_m is not None for image in self.images)


def frames_of(items: list[T], frames: slice, whole: str) -> list[T]:
    """Return the items of a range.

    Args:
        items: all of them, one at least.
        frames: range, counted from 0.
        whole: what all of them are, for the message.

    Raises:
        InputDataError: the range begins or ends behind the last one.
    """
    if (frames.start or 0) >= len(items) or (frames.stop or 0) > len(items):
        raise InputDataError(
            f"The range of frames goes beyond the {len(items)} {whole}: it must begin before {len(items)}, and end at "
            f"{len(items)} at the latest, or be left open."
        )
    return items[frames]
