from __future__ import annotations

import contextlib
import struct
from io import BytesIO

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from aos_drivers.frames.errors import TornFrameError
from aos_drivers.frames.files.images import decode_image
from aos_gcs.errors import CaptureError, InputDataError
from aos_gcs.image_headers import as_stored, picture_sizes

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


@pytest.mark.parametrize("kind", [".png", ".jpg", ".tiff"])
@pytest.mark.parametrize("written_share", [0.0, 0.5])
def test_a_file_whose_space_is_reserved_and_not_filled_is_incomplete(kind: str, written_share: float) -> None:
    data = encoded(kind, RGB)
    written = round(written_share * len(data))
    with pytest.raises(TornFrameError):
        decode_image(data[:written].ljust(len(data), b"\0"))


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


@pytest.mark.parametrize(("kind", "dtype"), [(".png", np.uint8), (".jpg", np.uint8), (".tiff", np.uint16)])
def test_three_equal_channels_of_a_thermal_camera_are_one_band(kind: str, dtype: type) -> None:
    level = RNG.integers(0, np.iinfo(dtype).max, (40, 56), dtype)
    image, bands = decode_image(encoded(kind, np.dstack([level] * 3)))
    assert (image.shape, image.dtype, bands) == ((40, 56, 1), dtype, ("grey",))
    if kind != ".jpg":
        np.testing.assert_array_equal(image[..., 0], level)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("image", [RGB, RGB[..., 0], THERMAL], ids=["RGB", "8 bit", "16 bit"])
def test_pixels_of_a_tiff_are_read_as_they_are_stored(orientation: int, image: np.ndarray) -> None:
    """OpenCV 5 turns them by their Orientation tag, whatever it is asked for, which the attitude is turned by, too."""
    file = BytesIO()
    Image.fromarray(image).save(file, "TIFF", tiffinfo={274: orientation})
    read, _ = decode_image(file.getvalue())
    np.testing.assert_array_equal(read.reshape(image.shape), image)


@pytest.mark.parametrize("order", "<>")
def test_an_orientation_tag_of_any_byte_order_has_no_effect(order: str) -> None:
    fields = [struct.pack(f"{order}HHIHH", 274, 3, 1, 6, 0), struct.pack(f"{order}HHII", 256, 4, 1, 7)]
    fields.append(struct.pack(f"{order}HHII", 257, 4, 1, 5))
    head = {"<": b"II*\0", ">": b"MM\0*"}[order] + struct.pack(f"{order}I", 8)
    page = struct.pack(f"{order}H", 3) + b"".join(fields) + bytes(4)
    stored = as_stored(head + page)
    assert stored == head + page.replace(fields[0], struct.pack(f"{order}HHIHH", 274, 3, 1, 1, 0))
    assert picture_sizes(stored) == [(7, 5)]
    for kind in (".png", ".jpg", ".tiff"):
        assert as_stored(untagged := encoded(kind, RGB)) == untagged


def test_one_pixel_of_colour_keeps_three_bands() -> None:
    pixels = np.dstack([RNG.integers(0, 256, (40, 56), np.uint8)] * 3)
    pixels[17, 23, 1] ^= 1
    assert decode_image(encoded(".png", pixels))[1] == ("red", "green", "blue")


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


@pytest.mark.parametrize("kind", [".png", ".jpg", ".tiff"])
def test_sizes_are_read_from_the_headers(kind: str) -> None:
    assert picture_sizes(encoded(kind, RGB)) == [(32, 24)]
    assert picture_sizes(two_pages()) == [(32, 24)] * 2


def claiming(data: bytes, offset: int, layout: str, *values: int) -> bytes:
    return data[:offset] + struct.pack(layout, *values) + data[offset + struct.calcsize(layout) :]


def refuse_to_decode(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("imdecode", "imdecodemulti"):
        monkeypatch.setattr(cv2, name, lambda *_: pytest.fail("it was decoded"))


def with_field(data: bytes, tag: int, kind: int, value: int, *, replacing: int | None = None) -> bytes:
    """A TIFF of one page and little-endian order with one field more, or in the place of one."""
    offset = struct.unpack_from("<I", data, 4)[0]
    count = struct.unpack_from("<H", data, offset)[0]
    fields = [data[offset + 2 + 12 * index : offset + 14 + 12 * index] for index in range(count)]
    fields = [field for field in fields if struct.unpack_from("<H", field)[0] != replacing]
    fields = sorted(
        [struct.pack("<HHII", tag, kind, 1, value), *fields], key=lambda field: struct.unpack("<H", field[:2])
    )
    directory = struct.pack("<H", len(fields)) + b"".join(fields) + bytes(4)
    return data[:4] + struct.pack("<I", len(data)) + data[8:] + directory


@pytest.mark.parametrize(
    ("tag", "kind", "replacing"),
    [(256, 4, None), (257, 4, None), (256, 9, 256), (256, 16, 256), (257, 11, 257), (322, 9, None)],
)
def test_a_tiff_whose_size_decoders_may_read_otherwise_is_refused(
    tag: int, kind: int, replacing: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A duplicate, or a type that this program does not read, hid the true size from the limit."""
    data = with_field(encoded(".tiff", RGB), tag, kind, 32, replacing=replacing)
    refuse_to_decode(monkeypatch)
    with pytest.raises(CaptureError, match=f"tag {tag}"):
        decode_image(data)


def test_a_page_without_a_size_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    refuse_to_decode(monkeypatch)
    with pytest.raises(CaptureError, match="page 1 of the TIFF file has no size"):
        decode_image(with_field(encoded(".tiff", RGB), 256, 4, 0, replacing=256))


def test_tiles_count_with_their_whole_size(monkeypatch: pytest.MonkeyPatch) -> None:
    data = with_field(with_field(encoded(".tiff", RGB), 322, 4, 60_000), 323, 4, 60_000)
    assert picture_sizes(data) == [(60_000, 60_000)]
    refuse_to_decode(monkeypatch)
    with pytest.raises(CaptureError, match="max_image_megapixels"):
        decode_image(data)


def test_of_an_animation_one_picture_is_decoded() -> None:
    if not hasattr(cv2, "imencodeanimation"):
        pytest.skip("this OpenCV writes no animations")
    animation = cv2.Animation()
    animation.frames, animation.durations = (
        [np.full((24, 32, 3), (value, 0, 0), np.uint8) for value in (9, 90, 200)],
        [1] * 3,
    )
    is_encoded, data = cv2.imencodeanimation(".png", animation)
    assert is_encoded
    image, _ = decode_image(data.tobytes())
    assert image.shape == (24, 32, 3)


def test_a_bomb_is_refused_before_it_is_decoded(monkeypatch: pytest.MonkeyPatch) -> None:
    refuse_to_decode(monkeypatch)
    jpeg = encoded(".jpg", RGB)
    frame = jpeg.index(b"\xff\xc0")
    for data in (
        claiming(encoded(".png", RGB), 16, ">II", 100_000, 100_000),
        claiming(jpeg, frame + 5, ">HH", 65_000, 65_000),
    ):
        with pytest.raises(CaptureError, match="max_image_megapixels"):
            decode_image(data)
    with pytest.raises(CaptureError, match=r"0\.0 megapixels"):
        decode_image(two_pages(), max_pixels=1000)


def test_a_tiff_that_points_to_itself_ends() -> None:
    page = struct.pack("<HHHIIHHIII", 2, 256, 4, 1, 1, 257, 4, 1, 1, 8)
    with pytest.raises(InputDataError, match="more than 8 pages"):
        picture_sizes(b"II*\0" + struct.pack("<I", 8) + page)


@given(st.sampled_from([b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"II*\0", b"MM\0*", b""]), st.binary(max_size=200))
def test_any_bytes_give_sizes_or_a_clear_error(start: bytes, rest: bytes) -> None:
    with contextlib.suppress(InputDataError):
        assert isinstance(picture_sizes(start + rest), list)


@given(st.sampled_from([".png", ".jpg", ".tiff"]), st.integers(0, 2**32))
def test_a_damaged_file_is_an_image_or_a_clear_error(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    data = bytearray(encoded(kind, RGB))
    for position in rng.integers(0, len(data), 6):
        data[position] = rng.integers(0, 256)
    with contextlib.suppress(CaptureError):
        decode_image(bytes(data), max_pixels=100_000)
