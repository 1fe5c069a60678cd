"""Live pictures: each is made once, when somebody watches, and nobody is shown an old one as new."""

from __future__ import annotations

import asyncio
from pathlib import Path

import cv2
import numpy as np
import pytest

from aos_gcs.errors import InputDataError, WorkerError
from aos_gcs.mission.model.steps import Picture, PictureKind
from aos_gcs.wall.board import LINGER_S, Wall
from aos_gcs.wall.model import FrameFacts, TileKind, TileName
from aos_gcs.wall.places import viewed_place
from aos_gcs.wall.rendering import MOST_FRAMES
from aos_gcs.wall.watch import WallUpdate
from tests.fakes.mission import ORIGIN, ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.wall import (
    START_UTC_S,
    WIDTH_PX,
    CountedWorker,
    GrowingRecord,
    make_wall,
    next_pictures,
    running,
    utc_s,
)

pytestmark = pytest.mark.looptime(idle_timeout=60)

FIRST = TileName(1, TileKind.COLOUR)
SECOND = TileName(2, TileKind.COLOUR)
INTEGRAL = TileName(None, TileKind.COLOUR)


def ages(wall: Wall, update: WallUpdate) -> dict[TileName, float]:
    """Return the ages in seconds of what a viewer is shown."""
    return {tile: wall.age_s(slot) for tile, slot in update.shown.items()}


async def test_a_picture_is_made_once_for_all_viewers(wall: Wall, record: GrowingRecord, worker: CountedWorker) -> None:
    record.add(1, START_UTC_S)
    async with running(wall):
        with wall.watch() as one, wall.watch() as other, wall.watch() as third:
            for watch in (one, other, third):
                watch.choose((FIRST,))
            updates = [await next_pictures(watch) for watch in (one, other, third)]
    jpegs = {update.pictures[FIRST].picture.jpeg for update in updates}
    assert len(jpegs) == 1
    image = cv2.imdecode(np.frombuffer(jpegs.pop(), np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (48, WIDTH_PX, 3)
    assert len(worker.rendered) == 1


async def test_nothing_is_done_while_nobody_watches(wall: Wall, record: GrowingRecord, worker: CountedWorker) -> None:
    record.add(1, START_UTC_S)
    async with running(wall):
        await asyncio.sleep(10.0)
        assert (worker.calls, worker.is_open) == ([], False)
        with wall.watch() as watch:
            watch.choose((FIRST,))
            await next_pictures(watch)
            assert worker.is_open
        await asyncio.sleep(1.0)
        calls = len(worker.calls)
        await asyncio.sleep(LINGER_S + 1.0)
        assert (len(worker.calls), worker.is_open) == (calls, False)
        with wall.watch() as again:
            again.choose((FIRST,))
            assert (await next_pictures(again)).pictures


async def test_only_what_is_watched_is_rendered(wall: Wall, record: GrowingRecord, worker: CountedWorker) -> None:
    record.add(1, START_UTC_S)
    record.add(2, START_UTC_S)
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((SECOND,))
            update = await next_pictures(watch)
            await asyncio.sleep(2.0)
    assert set(update.pictures) == {SECOND}
    assert wall.tiles() == (FIRST, SECOND)
    assert len(worker.rendered) == 1


async def test_a_camera_that_stops_grows_old(wall: Wall, record: GrowingRecord) -> None:
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST, SECOND))
            record.add(1, utc_s())
            record.add(2, utc_s())
            await next_pictures(watch)
            ages_s = []
            for _ in range(20):
                await asyncio.sleep(0.4)
                record.add(2, utc_s())
                ages_s.append(ages(wall, await watch.take()))
    firsts = [age_s[FIRST] for age_s in ages_s]
    assert firsts == sorted(firsts)
    assert firsts[-1] > 7.0
    assert max(age_s[SECOND] for age_s in ages_s) < 1.5


async def test_a_picture_from_a_clock_that_is_ahead_ages_all_the_same(wall: Wall, record: GrowingRecord) -> None:
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            record.add(1, utc_s() + 3600.0)
            await next_pictures(watch)
            await asyncio.sleep(8.0)
            assert ages(wall, await watch.take())[FIRST] >= 7.5


async def test_a_damaged_frame_leaves_the_former_picture_and_stops_no_other(
    wall: Wall, record: GrowingRecord, caplog: pytest.LogCaptureFixture
) -> None:
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST, SECOND))
            record.add(1, utc_s())
            first = (await next_pictures(watch)).pictures[FIRST]
            record.add(1, utc_s())
            newest = max((record.folder / "frames").iterdir())
            newest.write_bytes(b"no image")
            record.add(2, utc_s())
            assert set((await next_pictures(watch)).pictures) == {SECOND}
            await asyncio.sleep(5.0)
            assert wall.slot(FIRST, is_large=False) == first
    assert sum("cannot read the frame" in message for message in caplog.messages) == 1


async def test_a_worker_that_fails_costs_a_moment(wall: Wall, record: GrowingRecord, worker: CountedWorker) -> None:
    record.add(1, START_UTC_S)
    worker.failure = WorkerError("Live pictures has ended")
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            assert (await next_pictures(watch)).pictures


async def test_a_frame_that_ends_the_worker_costs_only_itself(
    wall: Wall, record: GrowingRecord, worker: CountedWorker
) -> None:
    for vehicle_id in (1, 2, 3):
        record.add(vehicle_id, START_UTC_S)
    worker.deadly = {2}
    others = {FIRST, TileName(3, TileKind.COLOUR)}
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST, SECOND, TileName(3, TileKind.COLOUR)))
            shown: set[TileName] = set()
            while shown != others:
                shown |= set((await next_pictures(watch)).pictures)
            calls = len(worker.calls)
            await asyncio.sleep(10.0)
            assert (len(worker.calls) - calls, sorted(worker.rendered)) == (pytest.approx(1, abs=1), [1, 3])
            record.add(2, utc_s())
            assert set((await next_pictures(watch)).pictures) == {SECOND}


async def test_more_cameras_than_one_call_renders_are_all_shown_at_once(
    wall: Wall, record: GrowingRecord, worker: CountedWorker
) -> None:
    tiles = tuple(TileName(one, TileKind.COLOUR) for one in range(1, 2 * MOST_FRAMES + 2))
    for tile in tiles:
        assert tile.vehicle_id is not None
        record.add(tile.vehicle_id, START_UTC_S)
    async with running(wall):
        with wall.watch() as watch:
            watch.choose(tiles)
            began_s = utc_s()
            shown = set((await next_pictures(watch)).pictures)
            while shown != set(tiles):
                shown |= set((await next_pictures(watch)).pictures)
            assert utc_s() - began_s < 0.5
    assert worker.calls == ["look"] * 3


async def test_the_worker_is_asked_nothing_while_the_record_stays_as_it_is(
    wall: Wall, record: GrowingRecord, worker: CountedWorker
) -> None:
    record.add(1, START_UTC_S)
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            await next_pictures(watch)
            await asyncio.sleep(1.0)
            calls = len(worker.calls)
            await asyncio.sleep(60.0)
            assert len(worker.calls) == calls
            record.add(1, utc_s())
            assert (await next_pictures(watch)).pictures


async def test_an_error_that_nobody_foresaw_is_logged_and_the_wall_goes_on(
    wall: Wall, record: GrowingRecord, worker: CountedWorker, caplog: pytest.LogCaptureFixture
) -> None:
    record.add(1, START_UTC_S)
    worker.failure = ZeroDivisionError("a defect")
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            assert (await next_pictures(watch)).pictures
    assert any("cannot be made at present" in message for message in caplog.messages)


async def test_without_a_record_the_wall_is_empty_and_comes_when_there_is_one(
    tmp_path: Path, worker: CountedWorker
) -> None:
    wall = make_wall(ScriptedMission(HandClock()), tmp_path / "mission", worker)
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST,))
            await asyncio.sleep(3.0)
            record = GrowingRecord(tmp_path)
            record.add(1, utc_s())
            assert (await next_pictures(watch)).pictures
            record.close()


async def test_the_integral_is_a_tile_of_the_time_of_its_step(record: GrowingRecord, worker: CountedWorker) -> None:
    mission = ScriptedMission(HandClock())
    wall = make_wall(mission, record.folder, worker)
    rgba = np.zeros((40, 80, 4), dtype=np.uint8)
    rgba[:, :40] = 255
    png = cv2.imencode(".png", rgba)[1].tobytes()
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((INTEGRAL,))
            await watch.take()
            assert wall.tiles() == ()
            mission._pictures[PictureKind.INTEGRAL] = Picture(PictureKind.INTEGRAL, 3, png, -10.0, -5.0, 10.0, 5.0)
            update = await next_pictures(watch)
    slot = update.pictures[INTEGRAL]
    assert wall.tiles() == (INTEGRAL,)
    assert (slot.picture.width_px, slot.picture.height_px) == (WIDTH_PX, 32)
    assert slot.place is not None
    assert slot.place.latitude_deg == pytest.approx(ORIGIN.latitude_deg, abs=1e-7)


class _Replay:
    utc_s = START_UTC_S


async def test_a_replay_shows_the_frames_of_its_time_and_goes_back(
    record: GrowingRecord, worker: CountedWorker
) -> None:
    replay = _Replay()
    for second in range(10):
        record.add(1, START_UTC_S + second)
    record.add(2, START_UTC_S + 6.0)
    wall = make_wall(ScriptedMission(HandClock()), record.folder, worker, replay=replay)
    async with running(wall):
        with wall.watch() as watch:
            watch.choose((FIRST, SECOND))
            replay.utc_s = START_UTC_S + 7.5
            update = await next_pictures(watch)
            assert set(wall.tiles()) == {FIRST, SECOND}
            assert ages(wall, update)[FIRST] == pytest.approx(0.5)
            await asyncio.sleep(30.0)
            assert ages(wall, await watch.take())[FIRST] == pytest.approx(0.5)
            replay.utc_s = START_UTC_S + 3.2
            update = await next_pictures(watch)
            assert update.pictures[FIRST].utc_s == START_UTC_S + 3.0
            assert wall.tiles() == (FIRST,)
            assert wall.slot(SECOND, is_large=False) is None


def facts(axis_enu: tuple[float, float, float], up_m: float = 35.0) -> FrameFacts:
    lat, lon, amsl_m = ORIGIN.latitude_deg, ORIGIN.longitude_deg, ORIGIN.altitude_amsl_m + up_m
    return FrameFacts(1, 1, START_UTC_S, (TileKind.COLOUR,), lat, lon, amsl_m, axis_enu)


def test_the_place_is_where_the_camera_looks() -> None:
    straight = viewed_place(facts((0.0, 0.0, -1.0)), ORIGIN.altitude_amsl_m)
    assert (straight.latitude_deg, straight.is_camera) == (pytest.approx(ORIGIN.latitude_deg, abs=1e-7), False)
    north = viewed_place(facts((0.0, 0.6, -0.8)), ORIGIN.altitude_amsl_m)
    assert (north.latitude_deg - ORIGIN.latitude_deg) * 111_200.0 == pytest.approx(35.0 * 0.75, rel=0.01)


@pytest.mark.parametrize(
    ("axis_enu", "ground_amsl_m"),
    [((0.0, 1.0, 0.0), ORIGIN.altitude_amsl_m), ((0.0, 0.0, -1.0), None), ((0.0, 0.0, -1.0), 9000.0)],
)
def test_without_ground_in_view_the_place_is_the_cameras(
    axis_enu: tuple[float, float, float], ground_amsl_m: float | None
) -> None:
    place = viewed_place(facts(axis_enu), ground_amsl_m)
    assert (place.latitude_deg, place.is_camera) == (ORIGIN.latitude_deg, True)


@pytest.mark.parametrize("text", ["", "3", "3.depth", "256.colour", "-1.colour", "all.", "3.colour ", "x" * 1000])
def test_what_is_no_tile_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="tiles are named"):
        TileName.parse(text)


def test_names_of_tiles_are_read_as_they_are_written() -> None:
    for tile in (FIRST, INTEGRAL, TileName(255, TileKind.THERMAL)):
        assert TileName.parse(str(tile)) == tile


async def test_too_many_tiles_and_several_large_ones_are_refused(wall: Wall) -> None:
    with wall.watch() as watch:
        with pytest.raises(InputDataError, match="tiles: at most 24"):
            watch.choose(tuple(TileName(one, TileKind.COLOUR) for one in range(25)))
        with pytest.raises(InputDataError, match="large"):
            watch.choose((FIRST, SECOND), is_large=True)
