"""Bands and values of a recording by a sample of its pictures."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.equal_bands import COLOURS
from aos_gcs.equal_bands import GREY as GREY_BAND
from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.kinds import SAMPLE, usual_kind
from aos_gcs.surveys.model import SurveyImage

RNG = np.random.default_rng(3)
COLOUR = RNG.integers(0, 256, (12, 16, 3), np.uint8)
GREY = RNG.integers(0, 256, (12, 16), np.uint8)
DEEP = RNG.integers(0, 65_536, (12, 16), np.uint16)
SMALL = COLOUR[:6]
BLACK = np.zeros((12, 16, 3), np.uint8)


def written(folder: Path, *pictures: np.ndarray | bytes) -> list[Path]:
    paths = [folder / f"{index:02}.png" for index in range(len(pictures))]
    for path, picture in zip(paths, pictures, strict=True):
        path.write_bytes(picture if isinstance(picture, bytes) else cv2.imencode(".png", picture)[1].tobytes())
    return paths


@pytest.mark.parametrize(
    ("odd", "reason"),
    [
        (GREY, "it is grey with 8-bit values, where most pictures are in colour with 8-bit values"),
        (np.dstack([GREY] * 3), "it is grey with 8-bit values, where most pictures are in colour with 8-bit values"),
        (DEEP, "it is grey with 16-bit values, where most pictures are in colour with 8-bit values"),
        (BLACK, "it is the same everywhere (0, 0, 0)"),
        (np.full((12, 16), 77, np.uint16), "it is the same everywhere (77)"),
    ],
)
@pytest.mark.parametrize("at", [0, 2])
def test_one_odd_picture_does_not_decide(tmp_path: Path, odd: np.ndarray, reason: str, at: int) -> None:
    pictures = [COLOUR] * 4
    pictures.insert(at, odd)
    paths = written(tmp_path, *pictures)
    usual = usual_kind(paths, None, "pictures")
    assert (usual.kind.bands, usual.kind.dtype, usual.kind.size_px) == (("red", "green", "blue"), np.uint8, (12, 16))
    assert usual.odd == {paths[at]: reason}


def test_a_picture_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    paths = written(tmp_path, b"no picture", GREY, GREY)
    usual = usual_kind(paths, None, "pictures")
    assert usual.kind.bands == ("grey",)
    assert list(usual.odd) == paths[:1]


def test_sizes_count_where_they_have_to_agree(tmp_path: Path) -> None:
    paths = written(tmp_path, SMALL, COLOUR, COLOUR)
    assert usual_kind(paths, None, "pictures").kind.size_px == (12, 16)
    assert list(usual_kind(paths, None, "pictures").odd) == paths[:1]
    assert usual_kind(paths, None, "pictures", same_size=False).odd == {}


def test_of_many_pictures_few_are_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = written(tmp_path, *[COLOUR] * 40)
    for path in paths[1:-1:2]:
        path.write_bytes(b"")
    seen: list[Path] = []

    def look(path: Path, _temperatures: None) -> np.ndarray:
        seen.append(path)
        return COLOUR

    monkeypatch.setattr("aos_gcs.surveys.kinds.read_pixels", look)
    usual_kind(paths, None, "pictures")
    assert len(seen) == SAMPLE
    assert {paths[0], paths[-1]} <= set(seen)


def test_pictures_of_a_covered_lens_are_passed_over(tmp_path: Path) -> None:
    """Nothing but black in the sample: one of the others shows what the recording is."""
    pictures = [BLACK] * 30
    pictures[17] = COLOUR
    assert usual_kind(written(tmp_path, *pictures), None, "pictures").kind.bands == ("red", "green", "blue")


def test_a_recording_of_nothing_is_refused(tmp_path: Path) -> None:
    paths = written(tmp_path, b"no picture", BLACK, BLACK)
    words = (
        r"None of the 3 pictures can be used; 01\.png: it is the same everywhere \(0, 0, 0\)\. Was the lens covered\?"
    )
    with pytest.raises(InputDataError, match=words):
        usual_kind(paths, None, "pictures")
    with pytest.raises(
        InputDataError, match=r"None of the 1 pictures can be used; 00\.png: The image .* is not an image"
    ):
        usual_kind(paths[:1], None, "pictures")


def test_a_grey_picture_beyond_the_sample_is_refused_among_colours_and_read_among_grey_ones(tmp_path: Path) -> None:
    path, coloured = written(tmp_path, np.dstack([GREY] * 3), COLOUR)
    camera, pose = CameraModel.from_fov(16, 12, 1.0), nadir_pose([0.0, 0.0, 30.0])
    with pytest.raises(InputDataError, match=r"00\.png is grey in three equal bands, but the recording is in colour"):
        read_frame(SurveyImage(path, pose, camera), COLOURS)
    assert read_frame(SurveyImage(path, pose, camera), GREY_BAND).image.shape == (12, 16, 1)
    assert read_frame(SurveyImage(coloured, pose, camera), COLOURS).image.shape == (12, 16, 3)
