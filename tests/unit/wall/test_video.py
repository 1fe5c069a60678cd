"""Videos of the wall: what they show, and what becomes of bad input and of a disk that is full."""

from __future__ import annotations

import errno
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.notations import Notation
from aos_gcs.runtime.wall import video as wall_video
from aos_gcs.runtime.wall.video import write_wall_video
from aos_gcs.wall.composition import PictureSequence, Shot, compose, wall_size
from aos_gcs.wall.model import TileKind, TileName, TilePicture, ViewedPlace
from aos_gcs.wall.rendering import look, render_frame
from tests.fakes.command_line import exit_status
from tests.fakes.wall import START_UTC_S, GrowingRecord

av = pytest.importorskip("av")
TILE = TileName(1, TileKind.COLOUR)


@pytest.fixture
def flown(record: GrowingRecord) -> GrowingRecord:
    for second in range(4):
        record.add(1, START_UTC_S + second, bands=("red", "green", "blue", "thermal"))
    record.add(2, START_UTC_S + 1.0, grey=200)
    return record


def run(*arguments: object) -> int:
    return exit_status(["export", *arguments])


def test_the_video_has_all_tiles_and_lasts_as_long_as_the_record(
    flown: GrowingRecord, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wall.mp4"
    assert run(flown.folder, "--wall", out) == 0
    assert "3 tiles, 4 s" in capsys.readouterr().out
    with av.open(out) as video:
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
        assert float(video.streams.video[0].average_rate) == wall_video.RATE_HZ
    assert len(frames) == 8
    assert frames[0].shape == (*wall_size(3)[::-1], 3)
    # The third tile, of the second vehicle, has its first picture after a second.
    assert frames[0][500:600, 300:400].mean() < 40
    assert frames[4][500:600, 300:400].mean() > 200


def test_tiles_are_chosen_by_name(flown: GrowingRecord) -> None:
    file = io.BytesIO()
    facts = write_wall_video(flown.folder, file, [TileName(2, TileKind.COLOUR)], Notation.MGRS)
    assert facts.tiles == (TileName(2, TileKind.COLOUR),)
    assert b"ftyp" in file.getvalue()[:32]


@pytest.mark.parametrize(
    ("arguments", "names"),
    [
        (["--wall", "out.mp4", "--tiles", "9.colour"], "9.colour"),
        (["--wall", "out.mp4", "--tiles", "1.depth"], "1.depth"),
        (["--wall", "out.avi"], ".mp4"),
        (["--tiles", "1.colour", "--findings", "out.kml"], "--wall"),
        (["--wall", "nowhere/out.mp4"], "nowhere"),
        ([], "--wall"),
    ],
)
def test_what_is_wrong_is_named_and_nothing_is_written(
    flown: GrowingRecord,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    names: str,
) -> None:
    parent = flown.folder.parent
    monkeypatch.chdir(parent)
    before = set(parent.rglob("*"))
    assert run(flown.folder, *arguments) != 0
    assert names in capsys.readouterr().err
    assert set(parent.rglob("*")) == before


def test_a_record_without_frames_is_refused(record: GrowingRecord) -> None:
    with pytest.raises(InputDataError, match="no pictures"):
        write_wall_video(record.folder, io.BytesIO())


def test_times_that_are_damaged_make_no_endless_video(record: GrowingRecord) -> None:
    record.add(1, START_UTC_S)
    record.add(1, START_UTC_S + 1e6)
    with pytest.raises(InputDataError, match="times are damaged"):
        write_wall_video(record.folder, io.BytesIO())


def test_damaged_frames_are_counted_and_the_picture_before_them_stays(flown: GrowingRecord) -> None:
    second = sorted((flown.folder / "frames").iterdir())[1]
    second.write_bytes(b"no image")
    assert write_wall_video(flown.folder, io.BytesIO(), [TILE]).unreadable == 1


class FullDisk(io.BytesIO):
    """Takes some bytes and no more."""

    def write(self, data: object, /) -> int:
        if self.tell() > 500:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)  # type: ignore[arg-type]


def test_a_full_disk_is_named_and_leaves_nothing(
    flown: GrowingRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def write(folder: Path, _file: object, *options: object) -> object:
        return write_wall_video(folder, FullDisk(), *options)  # type: ignore[arg-type]

    monkeypatch.setattr(wall_video, "write_wall_video", write)
    assert run(flown.folder, "--wall", tmp_path / "wall.mp4") != 0
    assert "No space left on device" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"mission"}


def shot(record: GrowingRecord, utc_s: float) -> Callable[[], TilePicture]:
    (frame,) = look(record.folder, 0, utc_s, ()).newest
    return lambda: render_frame(record.folder, frame.number, [(TileKind.COLOUR, 64)])[0]


def test_a_picture_that_is_old_is_marked_in_the_video(record: GrowingRecord) -> None:
    record.add(1, START_UTC_S, grey=200)
    place = ViewedPlace(48.0, 14.0)
    track = PictureSequence(TILE, [Shot(START_UTC_S, place, shot(record, START_UTC_S))])
    before = compose([track], START_UTC_S - 1.0, Notation.DECIMAL, 5.0)
    fresh = compose([track], START_UTC_S + 1.0, Notation.DECIMAL, 5.0)
    old = compose([track], START_UTC_S + 60.0, Notation.DECIMAL, 5.0)
    assert before[:300].max() <= 16
    yellow = np.array([61, 197, 255])
    assert not (fresh == yellow).all(axis=2).any()
    assert (old == yellow).all(axis=2).sum() > 5000
    assert fresh[370:, :].max() == 255


@pytest.mark.parametrize(("tiles", "size"), [(1, (480, 422)), (3, (960, 844)), (6, (1440, 844)), (24, (2400, 2110))])
def test_sizes_are_even_as_the_encoder_needs_them(tiles: int, size: tuple[int, int]) -> None:
    assert wall_size(tiles) == size
    assert not any(length % 2 for length in wall_size(tiles))
