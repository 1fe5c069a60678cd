"""Image files as frames, read when they are needed."""

from __future__ import annotations

import mmap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.equal_bands import COLOURS, GREY, without_equal_bands
from aos_gcs.errors import InputDataError
from aos_gcs.image_headers import FileContent, TornImageError, as_stored, is_cut_off, picture_sizes
from aos_gcs.imaging.model import Frame
from aos_gcs.jpeg_damage import is_damaged
from aos_gcs.surveys.model import SurveyImage
from aos_gcs.surveys.radiometric.reading import read_temperatures
from aos_gcs.surveys.radiometric.settings import TemperatureSettings

SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".tif", ".tiff"})
"""Endings of the names of image files that can be read."""

MAX_PIXELS = 250_000_000
"""Largest image that is decoded; a small file can claim, and compress, far more."""

THERMAL = ("thermal",)

# TIFF files of cameras have tags that OpenCV does not know, and would name one by one for each file.
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)

_VALUES = {"uint8": "8-bit", "uint16": "16-bit", "float32": "32-bit floating-point"}
"""Names of the types of values that are read."""


@dataclass(frozen=True, slots=True)
class LazyFrames:
    """Frames that are read anew each time they are gone through, so that memory holds one of them."""

    images: Sequence[SurveyImage]
    bands: tuple[str, ...]
    skip_broken: bool = False
    """Pass over images that cannot be read, instead of failing."""

    def __len__(self) -> int:
        """Return the number of images, broken ones included."""
        return len(self.images)

    def __iter__(self) -> Iterator[Frame]:
        """Read one image after the other."""
        for index, image in enumerate(self.images):
            try:
                frame = read_frame(image, self.bands, index)
            except InputDataError:
                if not self.skip_broken:
                    raise
                continue
            yield frame


def read_frame(image: SurveyImage, bands: tuple[str, ...], vehicle_id: int = 0) -> Frame:
    """Read an image of a survey.

    Raises:
        InputDataError: if it is missing, unreadable, incomplete, or has not the size of its camera, the bands, or the
            type of values of its recording. Three equal bands are no colours.
    """
    pixels = read_pixels(image.path, image.temperatures)
    if bands == GREY:
        pixels = without_equal_bands(pixels)
    elif bands == COLOURS and pixels.shape[2] == len(COLOURS) and bands_of(pixels) == GREY:
        # The sample that tells the kind of a recording has not seen it.
        raise InputDataError(
            f"The image {image.path} is grey in three equal bands, but the recording is in colour: what it shows "
            "cannot be averaged with colours, nor compared with them. Leave it out of the recording."
        )
    expected = image.camera.height_px, image.camera.width_px, len(bands)
    if pixels.shape != expected:
        raise InputDataError(
            f"The image {image.path} has {_size(pixels.shape)}, but {_size(expected)} are expected: all images of a "
            "recording must be alike, or name their own cameras."
        )
    if image.dtype is not None and pixels.dtype != image.dtype:
        raise InputDataError(
            f"The image {image.path} has {_VALUES[pixels.dtype.name]} values, but the recording has "
            f"{_VALUES[image.dtype.name]} ones: grey levels of different depths cannot be averaged."
        )
    return Frame(vehicle_id, pixels, bands, image.pose, image.camera)


def read_pixels(path: Path, temperatures: TemperatureSettings | None) -> NDArray[Any]:
    """Return an image as :func:`read_image` does, or its temperatures as :func:`read_celsius` does."""
    return read_image(path) if temperatures is None else read_celsius(path, temperatures)


def bands_of(pixels: NDArray[Any]) -> tuple[str, ...]:
    """Return the bands of a recording by one of its images: one where all three of its channels are the same picture.

    Thermal cameras write such pictures; as three bands they would be the same evidence three times.
    """
    return GREY if without_equal_bands(pixels).shape[2] == 1 else COLOURS


def read_image(path: Path) -> NDArray[Any]:
    """Return an image of 8 or 16 bit or of floating-point numbers, shape (H, W, C): grey, or red, green, blue.

    An alpha channel is dropped. Pixels stay as they are stored, whatever an Orientation tag says.

    Raises:
        InputDataError: if it is missing, unreadable, incomplete, damaged or too large, or has values that are no
            numbers.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error
    _check(path, content)
    if is_damaged(content):
        raise InputDataError(f"The image {path} is damaged: a part of its data is lost. Copy it again from its source.")
    try:
        image = cv2.imdecode(np.frombuffer(as_stored(content), dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise InputDataError(f"The image {path} cannot be decoded: {error.err}.") from error
    if image is None or image.dtype.name not in _VALUES:
        raise InputDataError(f"The image {path} is not an image of 8, 16 or 32 bit that can be decoded.")
    if image.dtype == np.float32 and not np.isfinite(image).all():
        raise InputDataError(f"The image {path} has values that are not finite numbers.")
    if image.ndim == 2:
        return np.asarray(image[:, :, np.newaxis])
    return np.ascontiguousarray(image[:, :, 2::-1])


def read_celsius(path: Path, settings: TemperatureSettings) -> NDArray[np.float32]:
    """Return the temperatures of a radiometric photograph, degrees Celsius, shape (H, W, 1).

    Raises:
        InputDataError: if it is missing, or has none that can be read.
        ConfigurationError: if DJI's Thermal SDK is not usable.
    """
    try:
        return read_temperatures(path.read_bytes(), settings)[:, :, np.newaxis]
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error
    except InputDataError as error:
        raise InputDataError(f"The image {path} has no temperatures: {error}.") from error


def check_image(path: Path) -> None:
    """Refuse a file that is missing, empty, incomplete or too large, without decoding it: before long work begins.

    Raises:
        InputDataError: naming the file.
    """
    try:
        with path.open("rb") as file:
            if not file.seek(0, 2):
                raise InputDataError(f"The image {path} is empty.")
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                _check(path, content)
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error


def _check(path: Path, content: FileContent) -> None:
    """Refuse what cannot be decoded, or takes too much memory for it."""
    try:
        pixels = sum(width * height for width, height in picture_sizes(content))
    except TornImageError as error:
        raise InputDataError(f"The image {path} is incomplete. Copy it again from its source.") from error
    except InputDataError as error:
        raise InputDataError(f"The image {path} is not an image that can be decoded: {error}.") from error
    if not 0 < pixels <= MAX_PIXELS:
        most = MAX_PIXELS / 1e6
        raise InputDataError(f"The image {path} claims {pixels / 1e6:,.1f} megapixels; at most {most:.0f} are read.")
    if is_cut_off(content):
        raise InputDataError(f"The image {path} is incomplete: its end is missing. Copy it again from its source.")


def _size(shape: tuple[int, ...]) -> str:
    height, width, channels = shape
    return f"{width} x {height} pixels and {channels} channel{'s' if channels > 1 else ''}"
