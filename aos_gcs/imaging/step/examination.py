"""Examination of single images: all that the analysis of a step needs of them, found before the others are there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.detection.detectors import detect
from aos_gcs.imaging.model import AnomalySource, Frame, Pixels
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.workers import parallel_map

_STRIDE = 16
"""Distance between the pixels that are looked at first: an image that varies among them is not constant."""


@dataclass(frozen=True, slots=True, eq=False)
class ExaminedFrame:
    """A frame without its image, and what that shows: implements :class:`~aos_gcs.imaging.model.Viewpoint`.

    Nothing of it but the pose depends on where the frame was taken: with a corrected one, it stays as it is.
    """

    vehicle_id: int
    bands: tuple[str, ...]
    pose: Pose
    camera: CameraModel
    time_sigma_s: float | None
    shape: tuple[int, ...]
    """Shape of the image."""
    fault: str
    """Reason why the image shows nothing; empty where it shows something."""
    marked: NDArray[np.int32]
    """Pixels that the detector marks, shape (n,): their indices in the image, row by row."""
    undetectable: str
    """Reason why the detector cannot be applied to the image; empty where it can."""
    gaps: NDArray[np.uint8] | None
    """Pixels with a band that is not finite, one bit for each, row by row; None where there is none."""
    speed_mps: float = 0.0
    tells_temperatures: bool = False
    """Whether its band ``thermal`` holds temperatures, and no grey levels."""

    def mask(self) -> NDArray[np.uint8]:
        """Return what the detector marks, shape (H, W), 1 where the image is anomalous.

        Raises:
            ImagingError: the detector cannot be applied to the image.
        """
        if self.undetectable:
            raise ImagingError(self.undetectable)
        mask = np.zeros(self.shape[:2], dtype=np.uint8)
        mask.reshape(-1)[self.marked] = 1
        return mask

    def validity(self) -> NDArray[np.float32]:
        """Return an image, shape (H, W, C), to be warped in place of its own: NaN in the gaps, else 0."""
        if self.gaps is None:
            return np.zeros((*self.shape[:2], 1), dtype=np.float32)
        # In as many bands as its own: OpenCV rounds differently with others.
        image = np.zeros(self.shape, dtype=np.float32)
        image[np.unpackbits(self.gaps, count=math.prod(self.shape[:2])).view(np.bool_).reshape(self.shape[:2])] = np.nan
        return image


def examine(frame: Frame, settings: ImagingSettings) -> ExaminedFrame:
    """Look for anomalies in a frame, unless they are looked for in the integral, and for what makes it unusable."""
    image = frame.image
    fits = image.shape == (frame.camera.height_px, frame.camera.width_px, len(frame.bands))
    marked, undetectable, fault = np.empty(0, dtype=np.int32), "", _fault(image) if fits else ""
    if fits and not fault and settings.anomaly_source is AnomalySource.MASKS:
        try:
            # Before any warp: interpolated pixels are correlated, and smoother than the background.
            mask = detect(
                image, frame.bands, settings.detector_of(frame.bands), settings.rx_quantile, settings.rx_min_score
            )
        except ImagingError as error:
            undetectable = str(error)
        else:
            # Ten times as fast as OpenCV's findNonZero where little is marked.
            marked = np.flatnonzero(mask.view(np.bool_)).astype(np.int32)
    return ExaminedFrame(
        vehicle_id=frame.vehicle_id,
        bands=frame.bands,
        pose=frame.pose,
        camera=frame.camera,
        time_sigma_s=frame.time_sigma_s,
        shape=image.shape,
        fault=fault,
        marked=marked,
        undetectable=undetectable,
        gaps=_gaps(image) if fits and not fault else None,
        speed_mps=frame.speed_mps,
        tells_temperatures="thermal" in frame.bands and image.dtype.kind == "f",
    )


def examine_all(frames: Sequence[Frame], settings: ImagingSettings) -> list[ExaminedFrame]:
    """Examine frames, in parallel; see :func:`examine`."""
    return parallel_map(partial(examine, settings=settings), frames)


def _fault(image: Pixels) -> str:
    """Return why an image shows nothing and would only take contrast from the integral, or an empty text."""
    if _varies(image[::_STRIDE, ::_STRIDE]):
        return ""
    finite = image[np.isfinite(image).all(axis=2)]
    if not finite.size:
        return "its image has no finite pixel"
    if (finite == finite[0]).all():
        values = ", ".join(f"{value:g}" for value in finite[0])
        return f"its image is the same everywhere ({values})"
    return ""


def _varies(image: Pixels) -> bool:
    finite = image[np.isfinite(image).all(axis=2)]
    return bool(finite.size) and not bool((finite == finite[0]).all())


def _gaps(image: Pixels) -> NDArray[np.uint8] | None:
    """Return the field of the same name."""
    # Few images have gaps: a sum tells so in a tenth of the time.
    if image.dtype.kind != "f" or math.isfinite(cv2.sumElems(image.reshape(image.shape[0], -1))[0]):
        return None
    return np.packbits(~np.isfinite(image).all(axis=2))
