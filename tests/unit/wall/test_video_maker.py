"""Videos of the wall for the dashboard: one at a time, given up, refused in words, and nothing left behind."""

from __future__ import annotations

import asyncio
import errno
import os
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.clock import LoopClock
from aos_gcs.errors import WorkerError
from aos_gcs.geometry.notations import Notation
from aos_gcs.mission.viewing import ViewerBusyError
from aos_gcs.ports import ThreadWorker, Worker
from aos_gcs.runtime.wall import video_maker
from aos_gcs.runtime.wall.video_maker import VideoMaker
from aos_gcs.wall.model import TileKind, TileName
from aos_gcs.wall.video import VideoPhase, VideoState
from aos_gcs.workers import process
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.videos import ScriptedVideos
from tests.fakes.wall import START_UTC_S, GrowingRecord
from tests.timing import scaled_s

av = pytest.importorskip("av")
TILE = TileName(1, TileKind.COLOUR)


@pytest.fixture
def record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[GrowingRecord]:
    (tmp_path / "spool").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "spool"))
    record = GrowingRecord(tmp_path)
    yield record
    record.close()


@pytest.fixture
def flown(record: GrowingRecord) -> GrowingRecord:
    for second in range(4):
        record.add(1, START_UTC_S + second)
    return record


@asynccontextmanager
async def making(record: GrowingRecord, **options: Any) -> AsyncIterator[VideoMaker]:
    """Run a maker of videos in a thread of this process, unless a test says otherwise."""

    @asynccontextmanager
    async def opened() -> AsyncIterator[Worker]:
        yield ThreadWorker()

    maker = VideoMaker(lambda: record.folder, rest=0.0, **({"open_process": opened} | options))
    running = asyncio.create_task(maker.run())
    yield maker
    running.cancel()
    await asyncio.wait([running])


async def ended(maker: VideoMaker) -> VideoState:
    """Return the state when nothing is being made any more."""
    async with asyncio.timeout(scaled_s(30.0)):
        while maker.state().phase is VideoPhase.MAKING:  # noqa: ASYNC110 - it tells nobody
            await asyncio.sleep(0.01)
    return maker.state()


def left_behind(record: GrowingRecord) -> list[str]:
    return sorted(path.name for path in (record.folder.parent / "spool").iterdir())


async def test_a_video_is_made_and_handed_out(flown: GrowingRecord) -> None:
    async with making(flown) as maker:
        assert maker.state() == VideoState()
        assert maker.read() is None
        assert maker.begin([], Notation.MGRS).phase is VideoPhase.MAKING
        state = await ended(maker)
        assert (state.phase, state.number, state.done) == (VideoPhase.READY, 1, 1.0)
        assert (state.tiles, state.duration_s, state.unreadable) == ((TILE,), 4.0, 0)
        read = maker.read()
        assert read is not None
        size, parts = read
        maker.give_up()  # Whoever downloads it goes on.
        video = b"".join(parts)
        assert len(video) == size == state.bytes
        assert b"ftyp" in video[:32]
        assert maker.state() == VideoState(number=1)
        assert maker.read() is None
    assert left_behind(flown) == []


async def test_progress_is_told_and_a_second_one_is_refused_meanwhile(
    flown: GrowingRecord, monkeypatch: pytest.MonkeyPatch
) -> None:
    go_on, told = asyncio.Event(), asyncio.Event()
    loop = asyncio.get_running_loop()
    note = video_maker._Pace.note

    def held(pace: Any, done: float) -> None:
        note(pace, done)
        if not told.is_set():
            loop.call_soon_threadsafe(told.set)
            asyncio.run_coroutine_threadsafe(go_on.wait(), loop).result()

    monkeypatch.setattr(video_maker._Pace, "note", held)
    async with making(flown) as maker:
        maker.begin([TILE], Notation.DECIMAL)
        async with asyncio.timeout(scaled_s(30.0)):
            await told.wait()
        assert maker.state().done == 1 / 8
        assert left_behind(flown) == []  # A station that is killed now leaves nothing.
        with pytest.raises(ViewerBusyError, match="already"):
            maker.begin([], Notation.DECIMAL)
        go_on.set()
        assert (await ended(maker)).phase is VideoPhase.READY


async def test_a_video_is_given_up_and_the_next_one_begins(flown: GrowingRecord) -> None:
    is_open = asyncio.Event()
    has_ended = asyncio.Event()

    class Endless:
        async def run(self, _function: object, /, *_args: object, **_more: object) -> Any:
            is_open.set()
            await asyncio.Event().wait()

    @asynccontextmanager
    async def opened() -> AsyncIterator[Any]:
        try:
            yield ThreadWorker() if has_ended.is_set() else Endless()
        finally:
            has_ended.set()

    async with making(flown, open_process=opened) as maker:
        maker.begin([], Notation.DECIMAL)
        maker.give_up()  # before it has begun
        assert maker.begin([], Notation.DECIMAL).number == 2
        await is_open.wait()
        assert maker.give_up() == VideoState(number=2)
        assert maker.begin([], Notation.DECIMAL).number == 3  # It waits until the process has gone.
        assert (await ended(maker)).phase is VideoPhase.READY
        assert has_ended.is_set()
        assert left_behind(flown) == []
        maker.begin([], Notation.DECIMAL)
        assert maker.read() is None
        assert (await ended(maker)).phase is VideoPhase.READY


async def test_a_record_without_pictures_is_refused_in_words(record: GrowingRecord) -> None:
    async with making(record) as maker:
        maker.begin([], Notation.DECIMAL)
        state = await ended(maker)
        assert state.phase is VideoPhase.FAILED
        assert "has no pictures" in state.reason
        record.add(1, START_UTC_S)
        maker.begin([TileName(9, TileKind.COLOUR)], Notation.DECIMAL)
        assert "has no tile 9.colour" in (await ended(maker)).reason
        maker.begin([], Notation.DECIMAL)
        assert (await ended(maker)).phase is VideoPhase.READY


@pytest.mark.parametrize("after", [0, 3])
async def test_a_disk_that_is_nearly_full_keeps_room_for_the_record(
    flown: GrowingRecord, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    class Disk:
        f_frsize = 4096
        looks = 0

        @property
        def f_bavail(self) -> int:
            Disk.looks += 1
            return 10**6 if Disk.looks <= after else 10**5

    monkeypatch.setattr(os, "fstatvfs", lambda _descriptor: Disk())
    async with making(flown) as maker:
        maker.begin([], Notation.DECIMAL)
        state = await ended(maker)
    assert state.phase is VideoPhase.FAILED
    assert "less than 2 GB left" in state.reason
    assert left_behind(flown) == []


async def test_a_disk_that_takes_no_file_is_named(flown: GrowingRecord, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(**_options: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile, "mkstemp", full)
    async with making(flown) as maker:
        maker.begin([], Notation.DECIMAL)
        assert "No space left on device" in (await ended(maker)).reason


@pytest.mark.parametrize(
    ("failure", "says"), [(WorkerError("The video has ended (SIGKILL)"), "SIGKILL"), (KeyError("x"), "see the log")]
)
async def test_a_process_that_dies_or_has_a_defect_costs_this_video_only(
    flown: GrowingRecord, failure: Exception, says: str
) -> None:
    class Dying:
        async def run(self, _function: object, /, *_args: object, **_more: object) -> Any:
            raise failure

    @asynccontextmanager
    async def opened() -> AsyncIterator[Any]:
        yield Dying()

    async with making(flown, open_process=opened) as maker:
        maker.begin([], Notation.DECIMAL)
        assert says in (await ended(maker)).reason
    assert left_behind(flown) == []


@pytest.mark.realtime
async def test_the_process_of_the_service_makes_one(flown: GrowingRecord, monkeypatch: pytest.MonkeyPatch) -> None:
    # The process has the lowest priority: on a busy machine it takes longer to start than a replacement may.
    monkeypatch.setattr(process, "RESTART_S", 1e-6)
    async with making(flown, open_process=video_maker.open_video_process) as maker:
        maker.begin([], Notation.DECIMAL)
        state = await ended(maker)
        assert state.phase is VideoPhase.READY, state.reason
    assert left_behind(flown) == []


# --- requests


def client_of(videos: ScriptedVideos | None, **options: Any) -> httpx.AsyncClient:
    app = app_of(ScriptedMission(LoopClock()), videos=videos, **options)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1")


async def test_a_video_is_asked_for_followed_and_downloaded() -> None:
    videos = ScriptedVideos()
    async with client_of(videos) as client:
        assert (await client.get("/api/wall/video")).json()["phase"] == "none"
        assert (await client.get("/api/wall/video.mp4")).status_code == 404
        begun = await client.post("/api/wall/video", json={"tiles": ["all.thermal", "1.colour"], "notation": "mgrs"})
        assert (begun.status_code, begun.json()["phase"]) == (202, "making")
        assert [(list(map(str, tiles)), notation) for tiles, notation in videos.asked] == [
            (["all.thermal", "1.colour"], Notation.MGRS)
        ]
        second = await client.post("/api/wall/video", json={})
        assert (second.status_code, second.json()["id"]) == (503, "busy")
        videos.finish()
        assert (await client.get("/api/wall/video")).json()["bytes"] == len(ScriptedVideos.FILE)
        video = await client.get("/api/wall/video.mp4")
        assert (video.headers["Content-Type"], video.content) == ("video/mp4", ScriptedVideos.FILE)
        assert (await client.delete("/api/wall/video")).json()["phase"] == "none"


@pytest.mark.parametrize("body", [{"tiles": ["1.depth"]}, {"notation": "roman"}, {"tiles": ["1.colour"] * 65}])
async def test_what_is_wrong_with_a_request_is_named(body: dict[str, Any]) -> None:
    videos = ScriptedVideos()
    async with client_of(videos) as client:
        refused = await client.post("/api/wall/video", json=body)
    assert refused.status_code == 422
    assert next(iter(body)) in refused.json()["message"]
    assert videos.asked == []


async def test_observers_download_what_others_have_made(tmp_path: Path) -> None:
    videos = ScriptedVideos()
    accounts = AccountFile(tmp_path / "accounts.json")
    async with client_of(videos, accounts=accounts, anyone_observes=True) as client:
        assert (await client.post("/api/wall/video", json={})).status_code in {401, 403}
        videos.begin([], Notation.DECIMAL)
        videos.finish()
        assert (await client.delete("/api/wall/video")).status_code in {401, 403}
        assert (await client.get("/api/wall/video")).json()["phase"] == "ready"
        assert (await client.get("/api/wall/video.mp4")).content == ScriptedVideos.FILE


async def test_without_a_record_there_is_no_video() -> None:
    async with client_of(None) as client:
        for request in (client.get("/api/wall/video"), client.post("/api/wall/video", json={})):
            assert (await request).status_code == 404
