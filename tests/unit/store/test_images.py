import struct

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.radiometry import celsius_from_centikelvin
from aos_gcs.store.images import EncodedImage, decode_bands, decode_image, encode_image

RGBT = ("red", "green", "blue", "thermal")


def rgbt_image() -> NDArray[np.float32]:
    rng = np.random.default_rng(3)
    thermal_ck = rng.integers(0, 65536, (20, 30), dtype=np.uint16)
    colour = rng.integers(0, 256, (20, 30, 3)).astype(np.float32)
    return np.dstack([colour, celsius_from_centikelvin(thermal_ck)])


def assert_same_after_round_trip(image: NDArray, bands: tuple[str, ...], suffix: str) -> None:
    encoded = encode_image(image, bands)
    assert encoded.suffix == suffix
    read = decode_image(encoded, bands, image.dtype.name)
    assert read.dtype == image.dtype
    np.testing.assert_array_equal(read, image)


def test_every_centikelvin_value_survives() -> None:
    thermal_ck = np.arange(65536, dtype=np.uint16).reshape(256, 256, 1)
    assert_same_after_round_trip(celsius_from_centikelvin(thermal_ck), ("thermal",), ".tiff")


def test_zero_celsius_is_27315_centikelvin() -> None:
    assert celsius_from_centikelvin(np.array([27315], dtype=np.uint16)) == pytest.approx([0.0], abs=1e-4)


def test_colour_and_thermal_become_the_camera_s_own_two_pages() -> None:
    image = rgbt_image()
    encoded = encode_image(image, RGBT)
    read, (colour_bgr, thermal_ck) = cv2.imdecodemulti(np.frombuffer(encoded.content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert read
    assert (colour_bgr.dtype, thermal_ck.dtype) == (np.uint8, np.uint16)
    np.testing.assert_array_equal(colour_bgr[..., ::-1], image[..., :3])
    assert_same_after_round_trip(image, RGBT, ".tiff")


@pytest.mark.parametrize(
    ("dtype", "bands"),
    [
        (np.uint8, ("red", "green", "blue")),
        (np.uint8, ("grey",)),
        (np.uint16, ("thermal",)),
        (np.uint8, RGBT),
        (np.float32, ("grey", "thermal")),
    ],
)
def test_integers_of_any_band_fit_into_a_tiff(dtype: type, bands: tuple[str, ...]) -> None:
    image = np.random.default_rng(4).integers(0, 256, (8, 9, len(bands))).astype(dtype)
    if bands[-1] == "thermal" and dtype is np.float32:
        image[..., -1] = celsius_from_centikelvin(image[..., -1].astype(np.uint16))
    assert_same_after_round_trip(image, bands, ".tiff")


@pytest.mark.parametrize("value", [0.5, np.nan, -1.0, 300.0])
def test_what_a_tiff_would_change_is_kept_as_numpy_file(value: float) -> None:
    image = rgbt_image()
    image[5, 6, 1] = value
    encoded = encode_image(image, RGBT)
    assert encoded.suffix == ".npy"
    np.testing.assert_array_equal(decode_image(encoded, RGBT, "float32"), image)


@pytest.mark.parametrize("encoded", [encode_image(rgbt_image(), RGBT), encode_image(rgbt_image() + 0.5, RGBT)])
@pytest.mark.parametrize("kept", [0, 3, 100])
def test_a_damaged_file_is_an_error_of_the_data(encoded: EncodedImage, kept: int) -> None:
    with pytest.raises(InputDataError, match="damaged"):
        decode_image(EncodedImage(encoded.suffix, encoded.content[:kept]), RGBT, "float32")


@pytest.mark.parametrize("suffix", [".tiff", ".npy"])
def test_a_file_that_claims_more_than_it_holds_is_refused(suffix: str) -> None:
    if suffix == ".tiff":
        content = bytearray(encode_image(np.zeros((64, 64, 1), np.uint8), ("grey",)).content)
        for tag in (256, 257):
            place = content.index(struct.pack("<HH", tag, 3))
            content[place + 8 : place + 12] = struct.pack("<I", 60_000)
    else:
        content = bytearray(encode_image(np.zeros((64, 64, 1), np.float32) + 0.1, ("thermal",)).content)
        place = content.index(b"(64, 64, 1)")
        content[place : place + 11] = b"(60000, 60)"
    with pytest.raises(InputDataError, match="damaged"):
        decode_image(EncodedImage(suffix, bytes(content)), ("grey",), "uint8")


@pytest.mark.parametrize(
    ("bands", "dtype"),
    [
        (RGBT, np.float32),
        (RGBT, np.uint8),
        (("thermal", "red", "green", "blue"), np.float32),
        (("red", "green", "blue", "grey", "thermal"), np.float32),
        (("grey", "thermal"), np.float32),
        (("grey",), np.uint16),
        (("thermal",), np.uint16),
    ],
)
@pytest.mark.parametrize("is_exact", [True, False])
def test_some_bands_are_those_of_the_whole_image(bands: tuple[str, ...], dtype: type, is_exact: bool) -> None:
    image = np.random.default_rng(5).integers(0, 256, (8, 9, len(bands))).astype(dtype)
    if dtype == np.float32 and "thermal" in bands:
        image[..., bands.index("thermal")] = celsius_from_centikelvin(np.full((8, 9), 28000, dtype=np.uint16))
        image[0, 0, bands.index("thermal")] += 0.0 if is_exact else 0.001
    encoded = encode_image(image, bands)
    for wanted in (("thermal",), ("red", "green", "blue"), ("blue", "red"), ("grey",)):
        if set(wanted) <= set(bands):
            stored = decode_bands(encoded, bands, image.dtype.name, wanted)
            expected = image[..., [bands.index(band) for band in wanted]]
            np.testing.assert_array_equal(stored.as_seen(stored.values), expected)


def test_bands_of_a_damaged_file_and_such_that_are_not_there_are_refused() -> None:
    encoded = encode_image(rgbt_image(), RGBT)
    cut = EncodedImage(encoded.suffix, encoded.content[:-2000])
    for file, wanted in ((cut, "thermal"), (EncodedImage(".tiff", b"II*"), "red"), (encoded, "grey")):
        with pytest.raises(InputDataError, match="damaged"):
            decode_bands(file, RGBT, "float32", (wanted,))


def test_fewer_pages_than_bands_are_noticed() -> None:
    colour = encode_image(rgbt_image()[..., :3], RGBT[:3])
    with pytest.raises(InputDataError, match="damaged"):
        decode_bands(colour, RGBT, "float32", ("thermal",))
