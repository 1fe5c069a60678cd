"""A record that frames are added to one by one, and a wall on it, in the time of the event loop."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np

from aos_gcs.errors import WorkerError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.mission.control import MissionView
from aos_gcs.ports import Capture
from aos_gcs.store.database import MissionDatabase
from aos_gcs.wall.board import Wall
from aos_gcs.wall.model import Look, WallSettings
from aos_gcs.wall.source import ReplayedTime, WallSource
from aos_gcs.wall.watch import WallUpdate, Watch
from tests.fakes.mission import ORIGIN
from tests.fakes.records import frame_row

P = ParamSpec("P")
T = TypeVar("T")

START_UTC_S = 1.7e9
WIDTH_PX = 64
COLOUR = ("red", "green", "blue")
_CAMERA = CameraModel.from_fov(80, 60, 0.9)


def loop_time_s() -> float:
    """Return the time of the running event loop."""
    return asyncio.get_running_loop().time()


def utc_s() -> float:
    """Return the time of the running event loop as a clock time."""
    return START_UTC_S + loop_time_s()


class CountedWorker:
    """Runs functions at once, and remembers which."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.rendered: list[int] = []
        """Numbers of the frames that were rendered."""
        self.deadly: set[int] = set()
        """Numbers of frames that end it when they are rendered."""
        self.failure: Exception | None = None
        """Raised by the next call."""
        self.is_open = False

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        self.calls.append(function.__name__)
        if self.failure is not None:
            failure, self.failure = self.failure, None
            raise failure
        result = function(*args, **kwargs)
        if isinstance(result, Look):
            numbers = [frame.number for frame in result.rendered]
            if self.deadly.intersection(numbers):
                raise WorkerError("Live pictures has ended")
            self.rendered += numbers
        return result

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[CountedWorker]:
        """Open it for as long as the context is entered."""
        self.is_open = True
        yield self
        self.is_open = False


class GrowingRecord:
    """A mission folder of frames only."""

    def __init__(self, root: Path) -> None:
        self.folder = root / "mission"
        self._database = MissionDatabase(self.folder, {})
        self.count = 0

    def add(self, vehicle_id: int, taken_utc_s: float, *, grey: int = 100, bands: tuple[str, ...] = COLOUR) -> None:
        """Add a frame of two shades, with a warm spot where it is thermal."""
        self.count += 1
        image = np.full((60, 80, len(bands)), grey, dtype=np.float32)
        image[:, 40:] += 50.0
        if "thermal" in bands:
            image[..., bands.index("thermal")] = 12.0
            image[20:30, 20:30, bands.index("thermal")] = 34.0
        capture = Capture(
            vehicle_id,
            self.count,
            taken_utc_s,
            image,
            bands,
            GeodeticPosition(ORIGIN.latitude_deg, ORIGIN.longitude_deg, ORIGIN.altitude_amsl_m + 35.0),
            nadir_pose([0.0, 0.0, 35.0]).R_cam2enu,
            _CAMERA,
        )
        row = frame_row(self.folder, 1, capture)
        self._database.write([lambda database: database.add_frame(row)])

    def close(self) -> None:
        """Close the record."""
        self._database.close()


def make_wall(
    mission: MissionView,
    folder: Path,
    worker: CountedWorker,
    *,
    clock_utc_s: Callable[[], float] = utc_s,
    replay: ReplayedTime | None = None,
    stale_s: float = 5.0,
) -> Wall:
    """Return a wall of small tiles on a record."""
    settings = WallSettings(rate_hz=2.0, width_px=WIDTH_PX, follow_width_px=WIDTH_PX + 8, stale_s=stale_s)
    return Wall(WallSource(mission, lambda: folder, clock_utc_s, replay), worker.opened, settings, loop_time_s)


@asynccontextmanager
async def running(wall: Wall) -> AsyncIterator[None]:
    """Make pictures for as long as the context is entered."""
    task = asyncio.create_task(wall.run())
    yield
    task.cancel()
    await asyncio.wait([task])


async def next_pictures(watch: Watch) -> WallUpdate:
    """Return the next update that has pictures."""
    while not (update := await watch.take()).pictures:
        pass
    return update
