"""Recorded flights: a folder of images and a JSON file with one world-to-camera pose per image."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.model import Frame

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from identity: text files carry rotations rounded to a few digits."""

BANDS_OF_CHANNELS = {1: ("grey",), 3: ("red", "green", "blue")}

END_MARKERS = {b"\x89PNG": b"IEND\xaeB`\x82", b"\xff\xd8": b"\xff\xd9"}
"""First and last bytes of PNG and JPEG files; decoders fill up truncated ones without a word."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedView:
    """One image of a recording, not read yet."""

    path: Path
    pose: Pose
    """In the world of the recording, whose axes need not be east-north-up."""


def read_poses(poses_file: Path, image_folder: Path) -> list[RecordedView]:
    """Read ``{"images": [{"imagefile": name, "M3x4": rows}, ...]}``.

    ``M3x4`` is row-major and takes world points to the camera, x_cam = R x + t, with camera axes right, down and
    forward. Its entries are numbers, or texts of numbers.

    Raises:
        InputDataError: naming the file, the entry, and what is wrong with it.
    """
    if not image_folder.is_dir():
        raise InputDataError(f"The image folder {image_folder} does not exist; check the path.")
    try:
        document = json.loads(poses_file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputDataError(f"The poses file {poses_file} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise InputDataError(f"The poses file {poses_file} is not valid JSON: {error}.") from error
    entries = document.get("images") if isinstance(document, dict) else None
    if not isinstance(entries, list) or not entries:
        raise InputDataError(f"The poses file {poses_file} needs a non-empty list 'images'.")
    return [_view(entry, f"{poses_file}, images[{index}]", image_folder) for index, entry in enumerate(entries)]


def recorded_camera(view: RecordedView, horizontal_fov_rad: float) -> CameraModel:
    """Return the camera of an image, whose size is found by reading it.

    Raises:
        InputDataError: see :func:`read_image`.
    """
    height_px, width_px, _ = read_image(view.path).shape
    return CameraModel.from_fov(width_px, height_px, horizontal_fov_rad)


def read_frames(views: Sequence[RecordedView], horizontal_fov_rad: float) -> Iterator[Frame]:
    """Read images one after the other; all must have the size and the channels of the first.

    Raises:
        InputDataError: if an image is missing, unreadable, incomplete, or differs from the first.
    """
    first: NDArray[Any] | None = None
    for index, view in enumerate(views):
        image = read_image(view.path)
        if first is None:
            first = image
            camera = CameraModel.from_fov(image.shape[1], image.shape[0], horizontal_fov_rad)
        elif image.shape != first.shape:
            raise InputDataError(
                f"The image {view.path} has {_size(image)}, but {views[0].path.name} has {_size(first)}: "
                "one field of view cannot fit both."
            )
        yield Frame(index, image, BANDS_OF_CHANNELS[image.shape[2]], view.pose, camera)


def read_image(path: Path) -> NDArray[Any]:
    """Return an image of 8 or 16 bit, shape (H, W, C): grey or red, green, blue; an alpha channel is dropped.

    Raises:
        InputDataError: if it is missing, unreadable or incomplete.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error
    for start, end in END_MARKERS.items():
        if content.startswith(start) and end not in content[-64:]:
            raise InputDataError(f"The image {path} is incomplete: its end is missing. Copy it again from its source.")
    image = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_UNCHANGED) if content else None
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise InputDataError(f"The image {path} is not an image of 8 or 16 bit that can be decoded.")
    if image.ndim == 2:
        return np.asarray(image[:, :, np.newaxis])
    return np.ascontiguousarray(image[:, :, 2::-1])


def _view(entry: object, place: str, image_folder: Path) -> RecordedView:
    name = entry.get("imagefile") if isinstance(entry, dict) else None
    if not isinstance(name, str) or not name:
        raise InputDataError(f"{place}: 'imagefile' must name an image.")
    path = image_folder / name
    if not path.is_file():
        raise InputDataError(f"{place} names the image {name}, which is not in {image_folder}.")
    M = _matrix(entry["M3x4"] if isinstance(entry, dict) and "M3x4" in entry else None, f"{place} ({name})")
    R, t = M[:, :3], M[:, 3]
    if np.abs(R @ R.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise InputDataError(f"{place} ({name}): the left 3x3 part of 'M3x4' is no rotation matrix.")
    return RecordedView(path, Pose(-R.T @ t, R.T))


def _matrix(rows: object, place: str) -> NDArray[np.float64]:
    shape = [len(row) if isinstance(row, list) else 0 for row in rows] if isinstance(rows, list) else []
    if not isinstance(rows, list) or shape != [4, 4, 4]:
        raise InputDataError(f"{place}: 'M3x4' must be three rows of four numbers, world to camera.")
    return np.array([[_number(value, place) for value in row] for row in rows])


def _number(value: object, place: str) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputDataError(f"{place}: 'M3x4' contains {value!r}, which is no finite number.")
    return number


def _size(image: NDArray[Any]) -> str:
    height, width, channels = image.shape
    return f"{width} x {height} pixels and {channels} channel{'s' if channels > 1 else ''}"
