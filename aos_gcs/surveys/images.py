"""Image files as frames, read when they are needed."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.model import Frame
from aos_gcs.surveys.model import SurveyImage

BANDS_OF_CHANNELS = {1: ("grey",), 3: ("red", "green", "blue")}

END_MARKERS = {b"\x89PNG": b"IEND\xaeB`\x82", b"\xff\xd8": b"\xff\xd9"}
"""First and last bytes of PNG and JPEG files; decoders fill up truncated ones without a word."""

TAIL_BYTES = 64
"""Bytes at the end of a file within which its end marker is looked for."""


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
        InputDataError: if it is missing, unreadable, incomplete, or has not the size of its camera or the bands.
    """
    pixels = read_image(image.path)
    expected = image.camera.height_px, image.camera.width_px, len(bands)
    if pixels.shape != expected:
        raise InputDataError(
            f"The image {image.path} has {_size(pixels.shape)}, but {_size(expected)} are expected: all images of a "
            "recording must be alike, or tell their own cameras."
        )
    return Frame(vehicle_id, pixels, bands, image.pose, image.camera)


def read_image(path: Path) -> NDArray[Any]:
    """Return an image of 8 or 16 bit, shape (H, W, C): grey or red, green, blue; an alpha channel is dropped.

    Raises:
        InputDataError: if it is missing, unreadable or incomplete.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error
    _refuse_truncated(path, content[:TAIL_BYTES], content[-TAIL_BYTES:])
    image = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_UNCHANGED) if content else None
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise InputDataError(f"The image {path} is not an image of 8 or 16 bit that can be decoded.")
    if image.ndim == 2:
        return np.asarray(image[:, :, np.newaxis])
    return np.ascontiguousarray(image[:, :, 2::-1])


def check_image(path: Path) -> None:
    """Refuse a file that is missing, empty or incomplete, by its first and last bytes: before long work begins.

    Raises:
        InputDataError: naming the file.
    """
    try:
        with path.open("rb") as file:
            head = file.read(TAIL_BYTES)
            file.seek(-min(TAIL_BYTES, file.seek(0, os.SEEK_END)), os.SEEK_END)
            tail = file.read()
    except OSError as error:
        raise InputDataError(f"The image {path} cannot be read: {error.strerror}.") from error
    if not head:
        raise InputDataError(f"The image {path} is not an image of 8 or 16 bit that can be decoded.")
    _refuse_truncated(path, head, tail)


def _refuse_truncated(path: Path, head: bytes, tail: bytes) -> None:
    for start, end in END_MARKERS.items():
        if head.startswith(start) and end not in tail:
            raise InputDataError(f"The image {path} is incomplete: its end is missing. Copy it again from its source.")


def _size(shape: tuple[int, ...]) -> str:
    height, width, channels = shape
    return f"{width} x {height} pixels and {channels} channel{'s' if channels > 1 else ''}"
