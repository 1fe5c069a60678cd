"""Recordings with a JSON file of poses beside a folder of images."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import COEFFICIENTS, LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.images import BANDS_OF_CHANNELS, check_image, read_image
from aos_gcs.surveys.model import Survey, SurveyImage

_Result = TypeVar("_Result")

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from identity: text files carry rotations rounded to a few digits."""

LENSES = {"lens": LensModel.BROWN_CONRADY, "fisheye": LensModel.FISHEYE}
"""Fields of the file that may carry the coefficients of a lens."""


def read_poses(
    poses_file: Path,
    image_folder: Path,
    horizontal_fov_rad: float,
    *,
    lens: LensDistortion | None = None,
    origin: GeodeticPosition | None = None,
    skip_broken: bool = False,
) -> Survey:
    """Read ``{"images": [{"imagefile": name, "M3x4": rows}, ...]}``.

    ``M3x4`` is row-major and takes world points to the camera, x_cam = R x + t, with camera axes right, down and
    forward. Its entries are numbers, or texts of numbers. The coefficients of the lens may stand beside ``images`` as
    ``"lens": [k1, k2, p1, p2, k3]`` or ``"fisheye": [k1, k2, k3, k4]``.

    Args:
        poses_file: the JSON file.
        image_folder: folder of the images; all have the size and the channels of the first.
        horizontal_fov_rad: full field of view of the images, distortion left out.
        lens: replaces the file's own.
        origin: origin of the world, where that is east-north-up.
        skip_broken: leave out images that are missing or incomplete, instead of refusing the recording.

    Raises:
        InputDataError: naming the file, the entry, and what is wrong with it.
    """
    if not image_folder.is_dir():
        raise InputDataError(f"The image folder {image_folder} does not exist; check the path.")
    document = _document(poses_file)
    entries = document.get("images")
    if not isinstance(entries, list) or not entries:
        raise InputDataError(f"The poses file {poses_file} needs a non-empty list 'images'.")
    placed = [_entry(entry, f"{poses_file}, images[{index}]", image_folder) for index, entry in enumerate(entries)]
    left_out: dict[str, str] = {}
    for path, _ in placed:
        _tried(check_image, path, left_out, skip_broken=skip_broken)
    shape = _shape([path for path, _ in placed], left_out, skip_broken=skip_broken)
    camera = CameraModel.from_fov(shape[1], shape[0], horizontal_fov_rad)
    camera = replace(camera, distortion=lens or _own_lens(document, poses_file))
    images = tuple(SurveyImage(path, pose, camera) for path, pose in placed if path.name not in left_out)
    return Survey(images, BANDS_OF_CHANNELS[shape[2]], origin, left_out)


def parse_lens(model: LensModel, coefficients: list[Any], name: str) -> LensDistortion:
    """Return a lens; trailing coefficients may be left out.

    Raises:
        InputDataError: naming what is wrong with them.
    """
    most = COEFFICIENTS[model]
    try:
        values = [math.nan if isinstance(value, bool) else float(value) for value in coefficients]
    except (TypeError, ValueError):
        values = []
    # Four is the least that either model is calibrated with.
    if not 4 <= len(values) <= most or not all(map(math.isfinite, values)):
        count = "4" if most == 4 else f"4 to {most}"
        raise InputDataError(f"{name} needs {count} finite coefficients, got {coefficients}.")
    return LensDistortion(model, (*values, *[0.0] * (most - len(values))))


def _document(poses_file: Path) -> Mapping[str, Any]:
    try:
        document = json.loads(poses_file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputDataError(f"The poses file {poses_file} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise InputDataError(f"The poses file {poses_file} is not valid JSON: {error}.") from error
    return document if isinstance(document, dict) else {}


def _own_lens(document: Mapping[str, Any], poses_file: Path) -> LensDistortion | None:
    given = [name for name in LENSES if document.get(name) is not None]
    if len(given) > 1:
        raise InputDataError(f"The poses file {poses_file} has both 'lens' and 'fisheye': a camera has one of them.")
    if not given:
        return None
    coefficients = document[given[0]]
    return parse_lens(
        LENSES[given[0]],
        coefficients if isinstance(coefficients, list) else [coefficients],
        f"'{given[0]}' of the poses file {poses_file}",
    )


def _shape(paths: list[Path], left_out: dict[str, str], *, skip_broken: bool) -> tuple[int, ...]:
    """Return the shape of the first image that can be decoded."""
    for path in paths:
        if path.name not in left_out:
            image = _tried(read_image, path, left_out, skip_broken=skip_broken)
            if image is not None:
                return tuple(image.shape)
    name, reason = next(iter(left_out.items()))
    raise InputDataError(f"None of the {len(paths)} images can be used; {name}: {reason}")


def _tried(
    read: Callable[[Path], _Result], path: Path, left_out: dict[str, str], *, skip_broken: bool
) -> _Result | None:
    """Read a file; None, and a note of the reason, where that fails and broken files are skipped."""
    try:
        return read(path)
    except InputDataError as error:
        if not skip_broken:
            raise
        left_out[path.name] = str(error)
        return None


def _entry(entry: object, place: str, image_folder: Path) -> tuple[Path, Pose]:
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
    return path, Pose(-R.T @ t, R.T)


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
