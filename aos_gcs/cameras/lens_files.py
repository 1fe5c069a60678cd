"""Files with the intrinsics of a camera: of OpenCV (YAML, XML, JSON), ROS and OpenDroneMap.

| file | fields |
|---|---|
| OpenCV, ROS | ``camera_matrix`` (``K``, ``cameraMatrix``), ``distortion_coefficients`` (``D``, ``dist_coeffs``, ``distCoeffs``), ``image_width``, ``image_height``, ``distortion_model`` |
| OpenDroneMap ``cameras.json`` | per camera ``projection_type``, ``width``, ``height``, ``focal_x``, ``focal_y`` or ``focal``, ``c_x``, ``c_y``, ``k1`` … |

OpenDroneMap's lengths are shares of the larger edge of the image, its principal point is relative to the centre.
"""  # noqa: E501 - a table

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from aos_gcs.cameras.intrinsics import Intrinsics, parse_lens
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.input_values import finite_number, shown

MAX_BYTES = 1_000_000
"""Largest file that is read: all of them are short."""

_MATRIX = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "intrinsic_matrix")
_COEFFICIENTS = ("distortion_coefficients", "Distortion_Coefficients", "dist_coeffs", "distCoeffs", "D")
_WIDTH, _HEIGHT = ("image_width", "image_Width", "width"), ("image_height", "image_Height", "height")
_MODELS = {
    "plumb_bob": LensModel.BROWN_CONRADY,
    "brown-conrady": LensModel.BROWN_CONRADY,
    "rational_polynomial": LensModel.BROWN_CONRADY,
    "equidistant": LensModel.FISHEYE,
    "fisheye": LensModel.FISHEYE,
}
_PROJECTIONS = {
    "perspective": ("k1", "k2"),
    "simple_radial": ("k1",),
    "radial": ("k1", "k2"),
    "brown": ("k1", "k2", "p1", "p2", "k3"),
    "fisheye": ("k1", "k2"),
    "fisheye_opencv": ("k1", "k2", "k3", "k4"),
}
"""OpenDroneMap's projections that are pinholes or equidistant, with their coefficients."""

Document = Mapping[str, Any]


def read_lens_file(path: Path) -> Intrinsics:
    """Read the intrinsics of a camera from a file of OpenCV, ROS or OpenDroneMap.

    Raises:
        InputDataError: naming the file, the field, and what is wrong with it.
    """
    document = read_document(path)
    if any(name in document for name in _MATRIX):
        return _of_opencv(document, path)
    cameras = {
        name: value for name, value in document.items() if isinstance(value, dict) and "projection_type" in value
    }
    if not cameras:
        raise InputDataError(
            f"The camera file {path} has neither 'camera_matrix' (OpenCV, ROS) nor cameras with 'projection_type' "
            "(OpenDroneMap)."
        )
    if len(cameras) > 1:
        raise InputDataError(
            f"The camera file {path} has {len(cameras)} cameras ({', '.join(sorted(cameras))}): leave only one in it."
        )
    return _of_opendronemap(next(iter(cameras.values())), path)


def read_document(path: Path) -> Document:
    """Return the fields of a JSON, YAML or XML file; matrices as lists of rows.

    Raises:
        InputDataError: if it cannot be read, or is none of them.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputDataError(f"The camera file {path} cannot be read: {error.strerror}.") from error
    text = content.decode("utf-8", "replace").lstrip("\ufeff \t\r\n")
    if len(content) > MAX_BYTES or not text:
        raise InputDataError(f"The camera file {path} is {'too long' if text else 'empty'}.")
    try:
        document = _json(text) if text.startswith(("{", "[")) else _file_storage(text)
    except (ValueError, RecursionError, cv2.error, SystemError) as error:
        raise InputDataError(f"The camera file {path} is not valid JSON, YAML or XML.") from error
    if not isinstance(document, dict):
        raise InputDataError(f"The camera file {path} needs named fields at its top.")
    return document


def _json(text: str) -> Any:
    return json.loads(text, object_hook=_plain_matrix)


def _plain_matrix(table: dict[str, Any]) -> Any:
    """Return a matrix as OpenCV and ROS write it as a list of its rows; other tables as they are."""
    rows, columns, data = table.get("rows"), table.get("cols"), table.get("data")
    if not isinstance(data, list) or not isinstance(rows, int | float) or not isinstance(columns, int | float):
        return table
    if int(rows) * int(columns) != len(data) or not data:
        return None
    return [data[start : start + int(columns)] for start in range(0, len(data), int(columns))]


def _file_storage(text: str) -> Any:
    if not text.startswith(("%YAML", "<?xml")):
        # ROS writes YAML without the line by which OpenCV knows it.
        text = "%YAML:1.0\n---\n" + text.removeprefix("---")
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    try:
        return _node(storage.root())
    finally:
        storage.release()


def _node(node: Any) -> Any:
    if node.isMap():
        return _plain_matrix({key: _node(node.getNode(key)) for key in node.keys()})  # noqa: SIM118 - no mapping
    if node.isSeq():
        return [_node(node.at(index)) for index in range(node.size())]
    return node.string() if node.isString() else node.real() if node.isReal() or node.isInt() else None


def _of_opencv(document: Document, path: Path) -> Intrinsics:
    name, matrix = _field(document, _MATRIX)
    try:
        K = np.array(matrix, dtype=np.float64).reshape(3, 3)
    except (TypeError, ValueError, OverflowError):
        K = np.full((3, 3), np.nan)
    if not np.isfinite(K).all() or K[0, 0] <= 0.0 or K[1, 1] <= 0.0 or not np.allclose(K[2], (0.0, 0.0, 1.0)):
        raise InputDataError(f"The camera file {path}: '{name}' must be three rows fx 0 cx, 0 fy cy, 0 0 1 in pixels.")
    if abs(K[0, 1]) > 1e-3 * K[0, 0]:
        raise InputDataError(f"The camera file {path}: '{name}' has a skew of {K[0, 1]:g}, which is not supported.")
    size = _size(document, path, _WIDTH, _HEIGHT)
    return Intrinsics(
        float(K[0, 0]),
        float(K[1, 1]),
        float(K[0, 2]),
        float(K[1, 2]),
        size,
        _opencv_lens(document, path),
        f"The camera file {path}",
    )


def _opencv_lens(document: Document, path: Path) -> LensDistortion | None:
    name, values = _field(document, _COEFFICIENTS)
    if name is None:
        return None
    coefficients = _flat(values)
    told = document.get("distortion_model", "fisheye" if document.get("fisheye_model") else "plumb_bob")
    if told not in _MODELS:
        raise InputDataError(
            f"The camera file {path}: 'distortion_model' is {told!r}; known are {', '.join(sorted(_MODELS))}."
        )
    model = _MODELS[told]
    most = 4 if model is LensModel.FISHEYE else 5
    while len(coefficients) > most and coefficients[-1] == 0.0:
        coefficients = coefficients[:-1]
    if len(coefficients) > most:
        raise InputDataError(
            f"The camera file {path}: '{name}' has {len(coefficients)} coefficients; of the model {model} at most "
            f"{most} are used. Calibrate again without the rational, thin-prism and tilted models."
        )
    return parse_lens(model, coefficients, f"'{name}' of the camera file {path}") if any(coefficients) else None


def _of_opendronemap(camera: Document, path: Path) -> Intrinsics:
    place = f"The camera file {path}"
    projection = camera["projection_type"]
    if projection not in _PROJECTIONS:
        raise InputDataError(
            f"{place}: 'projection_type' is {projection!r}; known are {', '.join(sorted(_PROJECTIONS))}."
        )
    size = _size(camera, path, ("width",), ("height",))
    if size is None:
        raise InputDataError(f"{place} needs 'width' and 'height', of which its other lengths are shares.")
    edge_px = max(size)
    fx = _number(camera, place, "focal_x" if "focal_x" in camera else "focal")
    fy = _number(camera, place, "focal_y" if "focal_y" in camera else "focal" if "focal" in camera else "focal_x")
    if fx <= 0.0 or fy <= 0.0:
        raise InputDataError(f"{place}: the focal lengths must be positive, got {fx:g} and {fy:g}.")
    coefficients = [_number(camera, place, name, 0.0) for name in _PROJECTIONS[projection]]
    model = LensModel.FISHEYE if projection.startswith("fisheye") else LensModel.BROWN_CONRADY
    has_lens = any(coefficients) or model is LensModel.FISHEYE
    return Intrinsics(
        fx * edge_px,
        fy * edge_px,
        _number(camera, place, "c_x", 0.0) * edge_px + (size[0] - 1) / 2,
        _number(camera, place, "c_y", 0.0) * edge_px + (size[1] - 1) / 2,
        size,
        parse_lens(model, [*coefficients, *[0.0] * (4 - len(coefficients))], place) if has_lens else None,
        place,
    )


def _field(document: Document, names: Sequence[str]) -> tuple[str | None, Any]:
    """Return the first of some names that is there, and its value."""
    return next(((name, document[name]) for name in names if document.get(name) is not None), (None, None))


def _size(document: Document, path: Path, widths: Sequence[str], heights: Sequence[str]) -> tuple[int, int] | None:
    (width_name, width), (height_name, height) = _field(document, widths), _field(document, heights)
    if width_name is None and height_name is None:
        return None
    for name, value in ((width_name or widths[0], width), (height_name or heights[0], height)):
        if isinstance(value, bool) or not isinstance(value, int | float) or not 1 <= value < 1e9 or value % 1:
            raise InputDataError(f"The camera file {path}: '{name}' must be a whole number of pixels, got {value!r}.")
    return int(width), int(height)


def _flat(values: Any) -> list[float]:
    """Return the numbers of a list or matrix in their order; NaN where one is no number."""
    if isinstance(values, list):
        return [number for value in values for number in _flat(value)]
    number = finite_number(values)
    return [math.nan if number is None else number]


def _number(table: Document, place: str, name: str, default: float | None = None) -> float:
    value = table.get(name, default)
    number = finite_number(value)
    if number is None:
        raise InputDataError(f"{place}: '{name}' must be a finite number, got {shown(value)}.")
    return number
