"""Image files of recorded frames.

The usual frame is a TIFF as the cameras themselves write it: a page of 8-bit colour, and a page of 16-bit thermal in
centikelvin. An image that such a file cannot hold exactly is kept as a NumPy file instead: what a replay reads is
always what the mission has seen, bit by bit.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.image_headers import picture_sizes
from aos_gcs.radiometry import celsius_from_centikelvin, centikelvin_from_celsius

Image = NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float32]
Page = NDArray[np.uint8] | NDArray[np.uint16]

COLOUR = ("red", "green", "blue")


@dataclass(frozen=True, slots=True)
class EncodedImage:
    """The content of an image file."""

    suffix: str
    """``.tiff`` or ``.npy``."""
    content: bytes


def encode_image(image: Image, bands: Sequence[str]) -> EncodedImage:
    """Return the file of an image, shape (H, W, C), without loss."""
    content = _tiff(image, bands)
    if content is not None and _is_exact(_pages(content), image, bands):
        return EncodedImage(".tiff", content)
    buffer = io.BytesIO()
    np.save(buffer, image, allow_pickle=False)
    return EncodedImage(".npy", buffer.getvalue())


def decode_image(encoded: EncodedImage, bands: Sequence[str], dtype: str) -> Image:
    """Return the image, shape (H, W, C), of the data type that was recorded.

    Raises:
        InputDataError: the file is damaged.
    """
    try:
        if encoded.suffix == ".npy":
            return _array(encoded.content)
        return _image_from_pages(_pages(encoded.content), bands, np.dtype(dtype))
    except (ValueError, TypeError, IndexError, EOFError, cv2.error, InputDataError) as error:
        raise InputDataError(f"a {encoded.suffix} image is damaged: {error}") from error


@dataclass(frozen=True, slots=True)
class StoredBands:
    """Some bands of an image, in the numbers in which its file holds them."""

    values: Image
    """Shape (H, W, n)."""
    is_centikelvin: bool
    """Whether they are temperatures in hundredths of a kelvin; else they are what the mission has seen."""

    def as_seen(self, values: Image) -> Image:
        """Return values of these bands, any shape, in the numbers that the mission has seen, such as degrees."""
        return celsius_from_centikelvin(cast("NDArray[np.uint16]", values)) if self.is_centikelvin else values


def decode_bands(encoded: EncodedImage, bands: Sequence[str], dtype: str, wanted: Sequence[str]) -> StoredBands:
    """Return some bands of an image, in this order; of a TIFF file, only the pages that hold them are decoded.

    Args:
        encoded: file of the image.
        bands: all bands of the image.
        dtype: data type that was recorded.
        wanted: the thermal band, or any others.

    Raises:
        InputDataError: the file is damaged, or has no such band.
    """
    try:
        channels = [bands.index(band) for band in wanted]
        if encoded.suffix == ".npy":
            return StoredBands(_array(encoded.content)[..., channels], is_centikelvin=False)
        is_centikelvin = "thermal" in wanted and np.dtype(dtype) == np.float32
        return StoredBands(_stored_channels(encoded.content, bands, channels), is_centikelvin)
    except (ValueError, TypeError, IndexError, EOFError, cv2.error, InputDataError) as error:
        raise InputDataError(f"a {encoded.suffix} image is damaged: {error}") from error


def _stored_channels(content: bytes, bands: Sequence[str], channels: Sequence[int]) -> Image:
    """Return channels as the pages of a TIFF file have them, shape (H, W, n)."""
    colours = _colours(bands)
    if colours and list(channels) == list(range(colours)):
        (page,) = _pages(content, only=0)
        return cast("Image", cv2.cvtColor(page, cv2.COLOR_BGR2RGB))
    parts = []
    for channel in channels:
        (page,) = _pages(content, only=0 if channel < colours else channel - colours + bool(colours))
        parts.append(page[..., colours - 1 - channel] if channel < colours else page)
    return cast("Image", np.stack(parts, axis=2))


def _colours(bands: Sequence[str]) -> int:
    """Return the number of channels of the page of colours; 0 where there is none."""
    return len(COLOUR) if tuple(bands[: len(COLOUR)]) == COLOUR else 0


def _is_exact(pages: Sequence[Page], image: Image, bands: Sequence[str]) -> bool:
    """Return whether pages hold an image bit by bit; compared page by page, without a second image in memory."""
    end = 0
    for channels in _channels(pages, bands, image.dtype):
        first, end = end, end + channels.shape[2]
        if not np.array_equal(channels, image[..., first:end]):
            return False
    return bool(end == image.shape[2])


def _tiff(image: Image, bands: Sequence[str]) -> bytes | None:
    """Return the TIFF that comes closest to the image, or None if there is none for its data type."""
    if image.dtype not in (np.uint8, np.uint16, np.float32) or image.shape[2] != len(bands):
        return None
    # What does not fit into bytes is found when the file is read again.
    rounded = cv2.convertScaleAbs(image).reshape(image.shape) if image.dtype == np.float32 else image
    whole = cast("Page", rounded)
    colours = _colours(bands)
    pages: list[Page] = [whole[..., [2, 1, 0]]] if colours else []  # OpenCV's order
    for channel in range(colours, len(bands)):
        if bands[channel] == "thermal" and image.dtype == np.float32:
            pages.append(centikelvin_from_celsius(cast("NDArray[np.float32]", image[..., channel])))
        else:
            pages.append(cast("Page", np.ascontiguousarray(whole[..., channel])))
    # Uncompressed: sensor noise hardly compresses, and a step waits until its frames are on the disk.
    written, buffer = cv2.imencodemulti(
        ".tiff", pages, [cv2.IMWRITE_TIFF_COMPRESSION, cv2.IMWRITE_TIFF_COMPRESSION_NONE]
    )
    return buffer.tobytes() if written else None


def _array(content: bytes) -> Image:
    """Return the array of a NumPy file without room for more than the file holds."""
    file = io.BytesIO(content)
    if np.lib.format.read_magic(file) != (1, 0):
        raise ValueError("it is not a NumPy file of version 1")
    shape, _, dtype = np.lib.format.read_array_header_1_0(file)
    if dtype.kind not in "uif" or math.prod(shape) * dtype.itemsize != len(content) - file.tell():
        raise ValueError(f"its {len(content)} bytes are not an array of {shape} {dtype}")
    return cast("Image", np.frombuffer(content, dtype, offset=file.tell()).reshape(shape).copy())


def _pages(content: bytes, only: int | None = None) -> Sequence[Page]:
    """Return all pages of a TIFF file, or only one: the others are not decoded."""
    # Recorded files are not compressed: one with more pixels than bytes is damaged, or made to fill the memory.
    pixels = sum(width * height for width, height in picture_sizes(content))
    if pixels > len(content):
        raise ValueError(f"{len(content)} bytes are not {pixels} pixels")
    data = np.frombuffer(content, dtype=np.uint8)
    if only is None:
        read, pages = cv2.imdecodemulti(data, cv2.IMREAD_UNCHANGED)
    else:
        read, pages = cv2.imdecodemulti(data, cv2.IMREAD_UNCHANGED, range=(only, only + 1))
    if not read:
        raise ValueError("it is not a TIFF file")
    return cast("Sequence[Page]", pages)


def _image_from_pages(pages: Sequence[Page], bands: Sequence[str], dtype: np.dtype[Any]) -> Image:
    return cast("Image", np.concatenate(list(_channels(pages, bands, dtype)), axis=2, dtype=dtype))


def _channels(pages: Sequence[Page], bands: Sequence[str], dtype: np.dtype[Any]) -> Iterator[Image]:
    """Return the bands that each page holds, shape (H, W, n), in the order of the bands."""
    first = 0
    for page in pages:
        if page.ndim == 3:
            channels: Image = page[..., ::-1]
        elif bands[first] == "thermal" and dtype == np.float32:
            channels = celsius_from_centikelvin(cast("NDArray[np.uint16]", page))[..., None]
        else:
            channels = page[..., None]
        first += channels.shape[2]
        yield channels
