"""Temperatures of FLIR's radiometric JPEG files."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.surveys.radiometric.flir import FlirImage, read_flir
from aos_gcs.surveys.radiometric.settings import MeasurementConditions
from tests.fakes.flir_photographs import CAMERA, container, counts_of, insert

CELSIUS = np.linspace(-15.0, 45.0, 320 * 240).reshape(240, 320)
AS_RECORDED = MeasurementConditions()


def photograph(folder: Path, data: bytes) -> bytes:
    path = folder / "photo.jpg"
    cv2.imwrite(str(path), np.zeros((48, 64), np.uint8))
    insert(path, data)
    return path.read_bytes()


def read(content: bytes) -> FlirImage:
    image = read_flir(content)
    assert image is not None
    return image


def counts(**changes: float) -> np.ndarray:
    return np.round(counts_of(CELSIUS, CAMERA | changes)).astype(np.uint16)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("png", [None, "swapped", "right"])
def test_temperatures_are_those_of_the_objects(tmp_path: Path, order: str, png: str | None) -> None:
    data = container(counts(), CAMERA, order=order, as_png=png is not None, swapped=png == "swapped")
    image = read(photograph(tmp_path, data))
    np.testing.assert_allclose(image.celsius(AS_RECORDED), CELSIUS, rtol=0.0, atol=0.05)
    assert image.horizontal_fov_rad == pytest.approx(np.radians(45.0))


def test_a_window_and_percent_of_humidity(tmp_path: Path) -> None:
    camera = CAMERA | {"window_transmission": 0.9, "humidity": 60.0}
    measured = counts_of(CELSIUS, camera | {"humidity": 0.6})
    data = container(np.round(measured).astype(np.uint16), camera)
    image = read(photograph(tmp_path, data))
    np.testing.assert_allclose(image.celsius(AS_RECORDED), CELSIUS, rtol=0.0, atol=0.05)


def test_what_the_camera_was_set_to_can_be_replaced(tmp_path: Path) -> None:
    true = {"emissivity": 0.9, "distance_m": 60.0, "humidity": 0.9, "reflected_k": 263.15, "air_k": 280.15}
    image = read(photograph(tmp_path, container(counts(**true), CAMERA)))
    assert np.abs(image.celsius(AS_RECORDED) - CELSIUS).max() > 1.0
    np.testing.assert_allclose(
        image.celsius(MeasurementConditions(0.9, 60.0, 0.9, -10.0, 7.0)), CELSIUS, rtol=0.0, atol=0.05
    )


def test_a_black_body_at_no_distance_follows_plancks_law(tmp_path: Path) -> None:
    camera = CAMERA | {"emissivity": 1.0, "distance_m": 0.0}
    data = container(np.full((4, 4), 15_000, np.uint16), camera)
    kelvin = 1428.0 / np.log(17096.453 / (0.046952728 * (15_000 - 342)) + 1.0)
    image = read(photograph(tmp_path, data))
    assert image.celsius(AS_RECORDED) == pytest.approx(np.full((4, 4), kelvin - 273.15), abs=1e-3)


WHOLE = container(np.full((8, 8), 15_000, np.uint16), CAMERA)
BAD = {
    "version": (WHOLE[:0x14] + b"\0\0\0\0" + WHOLE[0x18:], "unknown version"),
    "cut off": (WHOLE[:0x30], "are incomplete"),
    "no records": (WHOLE[:0x1C] + b"\0\0\0\0" + WHOLE[0x20:], "no counts or no constants"),
    "large": (container(np.zeros((1, 5000), np.uint16), CAMERA), "claim 5000 x 1 pixels"),
    "constants": (container(np.full((8, 8), 9, np.uint16), CAMERA | {"R1": 0.0}), "Planck constants"),
    "not finite": (container(np.full((8, 8), 9, np.uint16), CAMERA | {"B": float("nan")}), "Planck constants"),
    "emissivity": (
        container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"emissivity": 0.0}),
        "give --degrees emissivity=0.97",
    ),
    "reflection": (container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"reflected_k": 0.0}), "is 0 K, which no"),
    "hot reflection": (
        container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"reflected_k": 1e20}),
        r"reflected temperature is 1e\+20 K, which no scene has; give --degrees reflected=5",
    ),
    "hot air": (
        container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"air_k": 1e20}),
        r"temperature of the air is 1e\+20 K, which no scene has; give --degrees air=12",
    ),
    "cold window": (
        container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"window_transmission": 0.9, "window_k": 1e-20}),
        "temperature of the window before its lens is 1e-20 K",
    ),
    "no divisor": (
        container(np.full((8, 8), 15_000, np.uint16), CAMERA | {"B": 1e-20}),
        "B = 1e-20 and F = 1 give no signal at its reflected temperature",
    ),
    "too cold": (container(np.zeros((8, 8), np.uint16), CAMERA), "give no temperatures"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_gives_no_temperatures_is_named(tmp_path: Path, case: str) -> None:
    data, words = BAD[case]
    with pytest.raises(InputDataError, match=words):
        read(photograph(tmp_path, data)).celsius(AS_RECORDED)


def test_a_picture_alone_has_no_temperatures(tmp_path: Path) -> None:
    assert read_flir(photograph(tmp_path, b"FPF\0")) is None


@pytest.mark.parametrize("name", sorted(set(CAMERA) - {"O"}))
@given(st.floats(width=32, allow_nan=False))
def test_any_number_of_a_field_gives_temperatures_or_a_clear_error(name: str, value: float) -> None:
    image = FlirImage(np.full((2, 2), 15_000, np.uint16), CAMERA | {name: value})
    try:
        celsius = image.celsius(AS_RECORDED)
    except InputDataError:
        return
    assert np.isfinite(celsius).all()


@example(b"", 407, 195)
@example(b"", 335, 0)
@given(st.binary(max_size=400), st.integers(0, len(WHOLE) - 1), st.integers(0, 255))
def test_any_bytes_are_temperatures_or_a_clear_error(noise: bytes, at: int, value: int) -> None:
    damaged = bytearray(WHOLE)
    damaged[at] = value
    for data in (noise, b"FFF\0" + noise, bytes(damaged)):
        body = b"FLIR\0\x01\0\0" + data
        content = b"\xff\xd8\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body + b"\xff\xd9"
        try:
            image = read_flir(content)
            if image is not None:
                image.celsius(AS_RECORDED)
        except InputDataError:
            continue
