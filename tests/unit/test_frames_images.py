from __future__ import annotations

import cv2
import numpy as np
import pytest

from aos_drivers.frames.images import decode_image
from aos_gcs.errors import CaptureError

RNG = np.random.default_rng(5)
RGB = RNG.integers(0, 256, (24, 32, 3), np.uint8)
THERMAL = RNG.integers(28_000, 31_000, (24, 32), np.uint16)


def encoded(kind: str, image: np.ndarray) -> bytes:
    bgr = image[..., ::-1] if image.ndim == 3 else image
    return bytes(cv2.imencode(kind, bgr)[1])


def two_pages() -> bytes:
    return bytes(cv2.imencodemulti(".tiff", [np.ascontiguousarray(RGB[..., ::-1]), THERMAL])[1])


def test_rgb_and_radiometric_thermal_pages_become_four_bands() -> None:
    image, bands = decode_image(two_pages())
    assert bands == ("red", "green", "blue", "thermal")
    assert image.dtype == np.float32
    np.testing.assert_array_equal(image[..., :3], RGB)
    np.testing.assert_allclose(image[..., 3], THERMAL / 100 - 273.15, atol=1e-4)


@pytest.mark.parametrize("kind", [".png", ".tiff"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("bands", [("grey",), ("red", "green", "blue")])
def test_single_pages_keep_type_and_colours(kind: str, dtype: type, bands: tuple[str, ...]) -> None:
    shape = (24, 32) if len(bands) == 1 else (24, 32, 3)
    original = RNG.integers(0, np.iinfo(dtype).max, shape, dtype)
    image, named = decode_image(encoded(kind, original))
    assert named == bands
    assert image.dtype == dtype
    np.testing.assert_array_equal(image.reshape(shape), original)


def test_jpeg_is_accepted() -> None:
    image, bands = decode_image(encoded(".jpg", np.full((16, 16, 3), (200, 100, 50), np.uint8)))
    assert bands == ("red", "green", "blue")
    assert np.abs(image[8, 8].astype(int) - (200, 100, 50)).max() < 6


@pytest.mark.parametrize("kind", [".jpg", ".png"])
def test_truncated_files_are_refused(kind: str) -> None:
    data = encoded(kind, RGB)
    with pytest.raises(CaptureError, match="incomplete"):
        decode_image(data[: len(data) * 3 // 4])


@pytest.mark.parametrize("data", [b"", b"<html>404</html>", bytes(1000)])
def test_other_content_is_refused(data: bytes) -> None:
    with pytest.raises(CaptureError):
        decode_image(data)


def test_truncated_tiff_is_refused() -> None:
    data = two_pages()
    with pytest.raises(CaptureError):
        decode_image(data[: len(data) // 2])


def test_pages_of_different_size_are_refused() -> None:
    data = bytes(cv2.imencodemulti(".tiff", [RGB, THERMAL[:12]])[1])
    with pytest.raises(CaptureError, match="not understood"):
        decode_image(data)
