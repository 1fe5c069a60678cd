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

from aos_gcs.cameras.intrinsics import Intrinsics, parse_lens
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.poses import Pose
from aos_gcs.input_values import finite_number, require_folder, shown
from aos_gcs.surveys.apart import far_apart
from aos_gcs.surveys.conventions import PoseConvention
from aos_gcs.surveys.images import SUFFIXES, check_image
from aos_gcs.surveys.kinds import usual_kind
from aos_gcs.surveys.model import Survey, SurveyImage, frames_of
from aos_gcs.surveys.radiometric.settings import TemperatureSettings

ROTATION_TOLERANCE = 1e-3
"""Largest deviation of R R^T from identity: text files carry rotations rounded to a few digits."""

Z_DOWN = (
    "The cameras look along +z: only a world of x east, y north, z up can be placed on the earth. Leave --origin out, "
    "or name the axes of the world (--convention z-down)."
)

LENSES = {"lens": LensModel.BROWN_CONRADY, "fisheye": LensModel.FISHEYE}
"""Fields of the file that may carry the coefficients of a lens."""

MAX_POSITION_M = 1e8
"""Largest coordinate of a position: those about the middle of the earth are smaller."""
MAX_ALTITUDE_M = 20_000.0
MAX_FILE_BYTES = 1_000_000_000

INTRINSICS = ("fx", "fy", "cx", "cy")
"""Fields of the file that describe the camera, in pixels."""
SIZE = ("width", "height")
"""Fields with the size of the images that these are for, pixels; without them it is that of the images at hand."""


def read_poses(
    poses_file: Path,
    image_folder: Path,
    optics: float | Intrinsics | None = None,
    *,
    lens: LensDistortion | None = None,
    origin: GeodeticPosition | None = None,
    convention: PoseConvention | None = None,
    frames: slice = slice(None),
    temperatures: TemperatureSettings | None = None,
    skip_broken: bool = False,
) -> Survey:
    """Read ``{"images": [{"imagefile": name, "M3x4": rows}, ...]}``.

    ``M3x4`` is row-major and takes world points to the camera, x_cam = R x + t, with camera axes right, down and
    forward, unless another convention is named. Its entries are numbers, or texts of numbers. The camera may stand
    beside ``images``: ``fx``, ``fy``, ``cx`` and ``cy`` in pixels of images of ``width`` and ``height``, and the
    coefficients of the lens as ``"lens": [k1, k2, p1, p2, k3]`` or ``"fisheye": [k1, k2, k3, k4]``; and the place of
    an east-north-up world's origin as ``"origin": [latitude, longitude, altitude]``. Images may have the time of their
    exposure, ``time_s``.
    Names may have another ending than the files: lists of poses are often made of other copies of the images.

    Args:
        poses_file: the JSON file.
        image_folder: folder of the images; all have the size and the channels of most.
        optics: full horizontal field of view of the images, distortion left out, or their intrinsics. They replace
            the file's own, which must be there without them.
        lens: replaces the lens of the intrinsics and of the file.
        origin: origin of the world, where that is east-north-up; replaces the file's own.
        convention: meaning of the matrices.
        frames: entries that are used, in the order of the file.
        temperatures: settings under which temperatures are read from radiometric photographs; None: pictures are read.
        skip_broken: leave out images that are missing or incomplete, or have no usable pose, instead of refusing the
            recording.

    Raises:
        InputDataError: naming the file, the entry, and what is wrong with it.
    """
    require_folder(image_folder, f"The image folder {image_folder}")
    document = read_document(poses_file)
    entries = document.get("images")
    if not isinstance(entries, list) or not entries:
        raise InputDataError(f"The poses file {poses_file} needs a non-empty list 'images'.")
    named = _named(entries, poses_file)
    chosen = frames_of(list(named.items()), frames, f"images of {poses_file}")
    convention = convention or PoseConvention()
    folder = _Folder(image_folder)
    left_out: dict[str, str] = {}
    placed: list[tuple[Path, Pose]] = []
    times_s: dict[Path, float] = {}
    origin = _own_origin(document, poses_file) if origin is None else origin
    for name, (entry, place) in chosen:
        try:
            path, pose = folder.find(name, place), _pose(entry, f"{place} ({name})", convention)
            time_s = _time_s(entry, f"{place} ({name})")
            check_image(path)
        except InputDataError as error:
            if not skip_broken:
                raise
            left_out[name] = str(error)
        else:
            placed.append((path, pose))
            times_s |= {} if time_s is None else {path: time_s}
    for index, reason in far_apart([pose.position_enu_m for _, pose in placed]).items():
        if not skip_broken:
            raise InputDataError(f"{poses_file}: the image {placed[index][0].name} {reason}")
        left_out[placed[index][0].name] = f"it {reason}"
    placed = [(path, pose) for path, pose in placed if path.name not in left_out]
    _refuse_repeated(placed, poses_file)
    convention.check([pose for _, pose in placed])
    if origin is not None:
        _refuse_downward_z([pose for _, pose in placed])
    if not placed:
        name, reason = next(iter(left_out.items()))
        raise InputDataError(f"None of the {len(left_out)} images can be used; {name}: {reason}")
    # An image that differs, or cannot be read, is named when it is read.
    kind = usual_kind([path for path, _ in placed], temperatures, f"images in {image_folder}").kind
    camera = _camera(document, poses_file, kind.size_px, optics)
    camera = replace(camera, distortion=lens or camera.distortion)
    images = tuple(
        SurveyImage(path, pose, camera, kind.dtype, times_s.get(path), temperatures) for path, pose in placed
    )
    return Survey(
        images,
        kind.bands,
        origin,
        left_out,
        folder.names_beside([path for path, _ in placed], named),
        convention.R_file2world,
    )


def read_document(poses_file: Path) -> Mapping[str, Any]:
    """Return the content of a poses file, not looked at yet; an empty one if it is no object.

    Raises:
        InputDataError: if it is unreadable, too large, or no JSON.
    """
    try:
        with poses_file.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
        if len(content) > MAX_FILE_BYTES:
            raise InputDataError(
                f"The poses file {poses_file} has more than {MAX_FILE_BYTES / 1e6:.0f} MB, too many for a poses file."
            )
        document = json.loads(content.decode("utf-8-sig"))
    except OSError as error:
        raise InputDataError(f"The poses file {poses_file} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise InputDataError(f"The poses file {poses_file} is not valid JSON: {error}.") from error
    except RecursionError as error:
        raise InputDataError(f"The poses file {poses_file} is nested too deeply to be a list of poses.") from error
    return document if isinstance(document, dict) else {}


def _camera(
    document: Mapping[str, Any], poses_file: Path, size_px: tuple[int, int], optics: float | Intrinsics | None
) -> CameraModel:
    """Return the camera of images of a height and a width; the lens of the file applies unless intrinsics are given."""
    height_px, width_px = size_px
    if isinstance(optics, Intrinsics):
        return optics.camera(width_px, height_px)
    own_lens = _own_lens(document, poses_file)
    if optics is not None:
        return replace(CameraModel.from_fov(width_px, height_px, optics), distortion=own_lens)
    place = f"The poses file {poses_file}"
    given = {name: _length(document[name], name, place) for name in INTRINSICS if document.get(name) is not None}
    if "fx" not in given:
        raise InputDataError(
            f"{place} does not describe the camera: give the field of view (--fov DEG), a camera file (--camera FILE), "
            "or 'fx' beside 'images'."
        )
    fx_px = given["fx"]
    sizes = [_length(document[name], name, place) for name in SIZE if document.get(name) is not None]
    if len(sizes) == 1:
        raise InputDataError(f"{place} has one of 'width' and 'height': give both, or none.")
    told_px = (round(sizes[0]), round(sizes[1])) if sizes else None
    own = Intrinsics(fx_px, given.get("fy", fx_px), given.get("cx"), given.get("cy"), told_px, own_lens, place)
    return own.camera(width_px, height_px)


def _length(value: object, name: str, place: str) -> float:
    """Return a length in pixels."""
    number = finite_number(value)
    if number is None or number <= 0.0:
        raise InputDataError(f"{place}: '{name}' must be a positive number of pixels, got {shown(value)}.")
    return number


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


def _own_origin(document: Mapping[str, Any], poses_file: Path) -> GeodeticPosition | None:
    place = document.get("origin")
    if place is None:
        return None
    numbers = [finite_number(value) for value in place] if isinstance(place, list) else []
    known = [number for number in numbers if number is not None]
    if len(numbers) != 3 or len(known) != 3 or not is_place(*known):
        raise InputDataError(
            f"The poses file {poses_file}: 'origin' must be [latitude, longitude, altitude] in degrees and metres, got "
            f"{shown(place)}."
        )
    latitude_deg, longitude_deg, altitude_m = known
    return GeodeticPosition(latitude_deg, longitude_deg, AmslM(altitude_m))


def is_place(latitude_deg: float, longitude_deg: float, altitude_m: float = 0.0) -> bool:
    """Tell whether coordinates are those of a place where aircraft fly."""
    return abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0 and abs(altitude_m) <= MAX_ALTITUDE_M


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
        try:
            if path.is_file():
                return path
        except OSError as error:
            raise InputDataError(f"{place} names the image {shown(name)}: {error.strerror}.") from error
        others = [file for file in self._files.values() if file.stem == path.stem and file.is_file()]
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


def _pose(entry: Mapping[str, Any], place: str, convention: PoseConvention) -> Pose:
    M = _matrix(entry.get("M3x4"), place)
    R, t = M[:, :3], M[:, 3]
    if np.abs(t).max() > MAX_POSITION_M:
        raise InputDataError(
            f"{place}: 'M3x4' moves the world by {np.abs(t).max():.3g} m: positions are metres, of at most "
            f"{MAX_POSITION_M:g}."
        )
    if np.abs(R @ R.T - np.eye(3)).max() > ROTATION_TOLERANCE or np.linalg.det(R) < 0.0:
        raise InputDataError(f"{place}: the left 3x3 part of 'M3x4' is not a rotation matrix.")
    return convention.pose(R, t)


def _time_s(entry: Mapping[str, Any], place: str) -> float | None:
    value = entry.get("time_s")
    if value is None:
        return None
    time_s = finite_number(value)
    if time_s is None:
        raise InputDataError(f"{place}: 'time_s' must be a finite number of seconds, got {shown(value)}.")
    return time_s


def _matrix(rows: object, place: str) -> NDArray[np.float64]:
    shape = [len(row) if isinstance(row, list) else 0 for row in rows] if isinstance(rows, list) else []
    if not isinstance(rows, list) or shape != [4, 4, 4]:
        raise InputDataError(f"{place}: 'M3x4' must be three rows of four numbers.")
    return np.array([[_number(value, place) for value in row] for row in rows])


def _number(value: object, place: str) -> float:
    try:
        number = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise InputDataError(f"{place}: 'M3x4' contains {shown(value)}, which is not a finite number.")
    return number
