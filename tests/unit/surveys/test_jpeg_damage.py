"""Damage in the coded pixels of JPEG files, and pictures that look like it but are whole."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from aos_gcs.errors import InputDataError
from aos_gcs.jpeg_damage import LEAST_RUN_BYTES, is_damaged
from aos_gcs.surveys.images import read_image

ROWS, COLUMNS = np.mgrid[:240, :320]
PICTURES = {
    "black": np.zeros((240, 320)),
    "white": np.full((240, 320), 255),
    "half black": np.where(COLUMNS < 160, 0, (ROWS * 37 + COLUMNS * 91) % 251),
    "chequered": (ROWS + COLUMNS) % 2 * 255,
    "dots": (ROWS % 8 == 0) * (COLUMNS % 8 == 0) * 255,
    "noise": np.random.default_rng(0).integers(0, 256, (240, 320)),
}


def coded(grey: NDArray[np.generic], quality: int = 95, *, colour: bool = True, **options: object) -> bytes:
    level = grey.astype(np.float64)
    image = np.dstack([level, level / 2, 255 - level]) if colour else level
    file = BytesIO()
    Image.fromarray(image.astype(np.uint8)).save(file, "JPEG", quality=quality, **options)
    return file.getvalue()


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("quality", [1, 50, 95])
@pytest.mark.parametrize("options", [{}, {"optimize": True}, {"progressive": True}, {"restart_marker_blocks": 3}])
def test_whole_pictures_are_not_damaged(name: str, quality: int, options: dict[str, object]) -> None:
    for colour in (False, True):
        picture = coded(PICTURES[name], quality, colour=colour, **options)
        assert not is_damaged(picture)
        # Cameras append previews and temperatures.
        assert not is_damaged(picture + bytes(5000) + b"\xff" * 5000 + picture)


def test_zeros_that_are_black_ground_are_no_damage() -> None:
    """A black picture is a long run of zeros where the shortest codes are those of an even block."""
    picture = coded(np.zeros((1500, 2000)), colour=False, optimize=True)
    assert bytes(2 * LEAST_RUN_BYTES) in picture[-4000:]
    assert not is_damaged(picture)


@pytest.mark.parametrize("options", [{}, {"optimize": True}, {"restart_marker_blocks": 20}])
@pytest.mark.parametrize("fill", [b"\0", b"\xff"])
@pytest.mark.parametrize("sectors", [1, 8])
def test_a_stretch_that_is_lost_is_damage(options: dict[str, object], fill: bytes, sectors: int) -> None:
    picture = bytearray(coded(PICTURES["noise"], **options))
    first = len(picture) // 2 // 512 * 512
    picture[first : first + 512 * sectors] = fill * (512 * sectors)
    assert is_damaged(bytes(picture))


@pytest.mark.parametrize("options", [{}, {"progressive": True}])
def test_data_of_another_file_are_damage(options: dict[str, object]) -> None:
    picture = bytearray(coded(PICTURES["noise"], **options))
    first = len(picture) // 2
    picture[first : first + 4096] = np.random.default_rng(1).integers(0, 256, 4096, dtype=np.uint8).tobytes()
    assert is_damaged(bytes(picture))


def test_other_files_are_not_judged() -> None:
    for kind in (".png", ".tiff"):
        assert not is_damaged(bytes(cv2.imencode(kind, np.zeros((40, 50), dtype=np.uint8))[1]))
    assert not is_damaged(b"")


@given(st.binary(max_size=60), st.integers(0, 700), st.booleans())
@settings(max_examples=200, deadline=None)
def test_any_bytes_get_an_answer(content: bytes, place: int, is_progressive: bool) -> None:
    picture = bytearray(coded(PICTURES["dots"][:16, :16], progressive=is_progressive))
    picture[place : place + len(content)] = content
    assert is_damaged(bytes(picture)) in (False, True)
    assert is_damaged(bytes(picture[: place + 2])) in (False, True)


def test_a_damaged_photograph_is_named_and_no_decoder_speaks(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    picture = bytearray(coded(PICTURES["noise"], colour=False))
    path = tmp_path / "DJI_0007.JPG"
    path.write_bytes(picture)
    assert read_image(path).shape == (240, 320, 1)
    picture[20_000:22_000] = bytes(2000)
    path.write_bytes(picture)
    with pytest.raises(InputDataError, match=r"DJI_0007\.JPG is damaged: .* Copy it again from its source"):
        read_image(path)
    assert capfd.readouterr().err == ""
