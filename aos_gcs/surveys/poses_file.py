"""Recordings with a JSON file of poses beside a folder of images."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import COEFFICIENTS, LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.images import SUFFIXES, bands_of, check_image, read_image
from aos_gcs.surveys.model import Survey, SurveyImage

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from identity: text files carry rotations rounded to a few digits."""

Z_DOWN = (
    "The cameras look along +z: only a world of x east, y north, z up can be placed on the earth. Leave --origin out, "
    "or turn the poses."
)

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
    ``"lens": [k1, k2, p1, p2, k3]`` or ``"fisheye": [k1, k2, k3, k4]``. Names may have another ending than the files:
    lists of poses are often made of other copies of the images.

    Args:
        poses_file: the JSON file.
        image_folder: folder of the images; all have the size and the channels of the first.
        horizontal_fov_rad: full field of view of the images, distortion left out.
        lens: replaces the file's own.
        origin: origin of the world, where that is east-north-up.
        skip_broken: leave out images that are missing or incomplete, or have no usable pose, instead of refusing the
            recording.

    Raises:
        InputDataError: naming the file, the entry, and what is wrong with it.
    """
    if not image_folder.is_dir():
        raise InputDataError(f"The image folder {image_folder} does not exist; check the path.")
    document = _document(poses_file)
    entries = document.get("images")
    if not isinstance(entries, list) or not entries:
        raise InputDataError(f"The poses file {poses_file} needs a non-empty list 'images'.")
    named = _named(entries, poses_file)
    folder = _Folder(image_folder)
    left_out: dict[str, str] = {}
    placed: list[tuple[Path, Pose]] = []
    for name, (entry, place) in named.items():
        try:
            path, pose = folder.find(name, place), _pose(entry, f"{place} ({name})")
            check_image(path)
        except InputDataError as error:
            if not skip_broken:
                raise
            left_out[name] = str(error)
        else:
            placed.append((path, pose))
    _refuse_repeated(placed, poses_file)
    if origin is not None:
        _refuse_downward_z([pose for _, pose in placed])
    first = _first_image([path for path, _ in placed], left_out, skip_broken=skip_broken)
    height_px, width_px, _ = first.shape
    camera = CameraModel.from_fov(width_px, height_px, horizontal_fov_rad)
    camera = replace(camera, distortion=lens or _own_lens(document, poses_file))
    images = tuple(SurveyImage(path, pose, camera, first.dtype) for path, pose in placed if path.name not in left_out)
    return Survey(images, bands_of(first), origin, left_out, folder.names_beside([path for path, _ in placed], named))


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
    except RecursionError as error:
        raise InputDataError(f"The poses file {poses_file} is nested too deeply to be a list of poses.") from error
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


class _Folder:
    """The image files of a folder."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._files = {file.name: file for file in sorted(path.iterdir()) if file.suffix.lower() in SUFFIXES}

    def find(self, name: str, place: str) -> Path:
        """Return the file of this name, or the only one of this name with another ending.

        Raises:
            InputDataError: if there is none, or more than one.
        """
        path = self._path / name
        if path.is_file():
            return path
        others = [file for file in self._files.values() if file.stem == path.stem]
        if len(others) > 1:
            names = ", ".join(file.name for file in others)
            raise InputDataError(f"{place} names the image {name}, but {self._path} has {names}: which one is meant?")
        if not others or path.parent != self._path or path.suffix.lower() not in SUFFIXES:
            raise InputDataError(f"{place} names the image {name}, which is not in {self._path}.")
        return others[0]

    def names_beside(self, paths: Sequence[Path], names: Collection[str]) -> tuple[str, ...]:
        """Return the names of the images that neither are among some paths nor have one of some names."""
        used = {path.name for path in paths}
        return tuple(name for name in self._files if name not in used and name not in names)


def _named(entries: Sequence[object], poses_file: Path) -> dict[str, tuple[Mapping[str, Any], str]]:
    """Return the entries and their places in the file by the names of their images."""
    named: dict[str, tuple[Mapping[str, Any], str]] = {}
    for index, entry in enumerate(entries):
        place = f"{poses_file}, images[{index}]"
        name = entry.get("imagefile") if isinstance(entry, dict) else None
        if not isinstance(entry, dict) or not isinstance(name, str) or not name:
            raise InputDataError(f"{place}: 'imagefile' must name an image.")
        if name in named:
            raise InputDataError(f"{place} names the image {name} again: each image counts once, with one pose.")
        named[name] = entry, place
    return named


def _refuse_repeated(placed: Sequence[tuple[Path, Pose]], poses_file: Path) -> None:
    """Refuse images that are named twice in different ways, such as with another ending."""
    counts = Counter(path.resolve() for path, _ in placed)
    for path, count in counts.items():
        if count > 1:
            raise InputDataError(
                f"The poses file {poses_file} names the image {path.name} {count} times, in other words."
            )


def _refuse_downward_z(poses: Sequence[Pose]) -> None:
    """Refuse a world whose z points down, of which an origin on the earth would make a mirror image."""
    if poses and np.median([pose.R_cam2enu[2, 2] for pose in poses]) > 0.0:
        raise InputDataError(Z_DOWN)


def _first_image(paths: Sequence[Path], left_out: dict[str, str], *, skip_broken: bool) -> NDArray[Any]:
    """Return the first image that can be decoded; those before it are left out."""
    for path in paths:
        try:
            return read_image(path)
        except InputDataError as error:
            if not skip_broken:
                raise
            left_out[path.name] = str(error)
    name, reason = next(iter(left_out.items()))
    raise InputDataError(f"None of the {len(left_out)} images can be used; {name}: {reason}")


def _pose(entry: Mapping[str, Any], place: str) -> Pose:
    M = _matrix(entry.get("M3x4"), place)
    R, t = M[:, :3], M[:, 3]
    if np.abs(R @ R.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise InputDataError(f"{place}: the left 3x3 part of 'M3x4' is no rotation matrix.")
    return Pose(-R.T @ t, R.T)


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
