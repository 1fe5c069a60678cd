"""The wall: newest pictures of the tiles that somebody watches, each made once for all viewers.

Nothing is done while nobody watches. Each tile has one slot per size with its newest picture, and each viewer knows
what it was sent last: whoever is slow gets fewer pictures, never older ones. What the pictures cost is bounded: a tile
is rendered at most so many times per second, and the worker rests as long as it has worked.
"""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractAsyncContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Final

from aos_gcs.errors import AosError, InputDataError, WorkerError
from aos_gcs.mission.model.steps import Picture, PictureKind
from aos_gcs.ports import Worker
from aos_gcs.store.changes import RecordChanges
from aos_gcs.wall.model import FrameFacts, Look, Order, RenderedFrame, Slot, TileKind, TileName, WallSettings
from aos_gcs.wall.places import raster_place, viewed_place
from aos_gcs.wall.rendering import look, render_raster
from aos_gcs.wall.source import WallSource
from aos_gcs.wall.watch import EARLY, Watch

_log = logging.getLogger(__name__)

POLL_S: Final = 0.1
"""Shortest pause between two looks at the record."""
LINGER_S: Final = 20.0
"""Time for which the worker is kept when nobody watches any more: pages are reloaded."""
FEW_VIEWERS: Final = 10
GAP_S, GAP_OF_MANY_S = 0.2, 0.45
"""Shortest time between two messages with pictures to a viewer, for so few viewers and for more: cameras do not expose
at once, and each message costs something. Many get all tiles of the usual two pictures per second at once."""
RETRY_S: Final = 1.0
"""Pause after an error, such as a record that cannot be read."""
_REST: Final = 1.0
"""Rest of the worker, as a multiple of the time that it has worked."""
_RASTERS: Final = {TileKind.COLOUR: PictureKind.INTEGRAL, TileKind.THERMAL: PictureKind.THERMAL}

Size = tuple[TileName, int]
"""A tile and its width in pixels."""
OpenWorker = Callable[[], AbstractAsyncContextManager[Worker]]


class Wall:
    """Tiles of one mission. ``run`` makes the pictures, ``watch`` registers viewers.

    Args:
        source: mission that is shown.
        open_worker: starts what renders.
        settings: limits.
        now_s: clock in real seconds.
    """

    def __init__(
        self, source: WallSource, open_worker: OpenWorker, settings: WallSettings, now_s: Callable[[], float]
    ) -> None:
        self.settings = settings
        self.source = source
        self._open_worker = open_worker
        self._now_s = now_s
        self._watches: set[Watch] = set()
        self._has_watches = asyncio.Event()
        self._slots: dict[Size, Slot] = {}
        self._tried: dict[Size, int] = {}
        """Origin of the picture that was made last, or could not be made."""
        self._tried_at_s: dict[Size, float] = {}
        self._folder: Path | None = None
        self._newest: dict[int, tuple[FrameFacts, float]] = {}
        self._after = 0
        self._changes = RecordChanges()
        self._is_careful = False
        """Whether the worker has failed, so that frames are rendered one by one."""
        self._count = 0

    @contextmanager
    def watch(self) -> Iterator[Watch]:
        """Register a viewer for as long as the context is entered."""
        watch = Watch(self, self._now_s)
        self._watches.add(watch)
        self._has_watches.set()
        try:
            yield watch
        finally:
            self._watches.discard(watch)

    async def run(self) -> None:
        """Make pictures while there are viewers, until cancelled."""
        while True:
            await self._has_watches.wait()
            try:
                async with self._open_worker() as worker, asyncio.TaskGroup() as group:
                    following = group.create_task(self.source.follow())
                    await self._serve(worker)
                    following.cancel()
            except Exception:  # whatever it is: the dashboard goes on without live pictures
                _log.exception("Live pictures cannot be made at present")
                await asyncio.sleep(RETRY_S)

    def tiles(self) -> tuple[TileName, ...]:
        """Return the tiles that there are pictures of, the integral first."""
        rasters = [TileName(None, kind) for kind, raster in _RASTERS.items() if self.source.picture(raster)]
        cameras = [TileName(one, kind) for one in sorted(self._newest) for kind in self._newest[one][0].kinds]
        return (*rasters, *cameras)

    def slot(self, tile: TileName, *, is_large: bool) -> Slot | None:
        """Return the newest picture of a tile; None while there is none."""
        return self._slots.get((tile, self._width_px(is_large)))

    @property
    def gap_s(self) -> float:
        """Shortest time between two messages with pictures to a viewer."""
        return GAP_S if len(self._watches) <= FEW_VIEWERS else GAP_OF_MANY_S

    def age_s(self, slot: Slot) -> float:
        """Return the age of what a picture shows.

        A live one is at least as old as the time since it was found, whatever the clocks of cameras say.
        """
        age_s = max(0.0, self.source.now_utc_s() - slot.utc_s)
        return age_s if self.source.until_utc_s is not None else max(age_s, self._now_s() - slot.seen_at_s)

    def _width_px(self, is_large: bool) -> int:
        return self.settings.follow_width_px if is_large else self.settings.width_px

    # --- work ---------------------------------------------------------------------------------------------------------

    async def _serve(self, worker: Worker) -> None:
        """Make pictures until nobody has watched for a while."""
        watched_at_s, is_working = self._now_s(), True
        while self._watches or self._now_s() - watched_at_s < LINGER_S:
            begin_s = self._now_s()
            if not self._watches:
                await asyncio.sleep(POLL_S)
                continue
            watched_at_s = begin_s
            try:
                await self._update(worker)
            except AosError as error:
                if is_working:
                    _log.warning("Live pictures: %s", error)
                is_working = False
                self._changes = RecordChanges()
                await asyncio.sleep(RETRY_S)
            else:
                is_working = True
                await asyncio.sleep(max(POLL_S, _REST * (self._now_s() - begin_s)))
        self._forget(list(self._tried))
        if not self._watches:
            self._has_watches.clear()

    async def _update(self, worker: Worker) -> None:
        """Find new frames, and render what is watched and has something newer to show, as often as the settings say."""
        if self.source.folder != self._folder:
            self._folder, self._after = self.source.folder, 0
            self._newest.clear()
            self._forget(list(self._tried))
        wanted = {(tile, self._width_px(watch.is_large)) for watch in self._watches for tile in watch.tiles}
        self._forget([size for size in self._tried if size not in wanted])
        try:
            await (self._look_apart if self._is_careful else self._look)(worker, wanted)
        except WorkerError:
            self._is_careful = True
            raise
        for kind, raster in _RASTERS.items():
            picture = self.source.picture(raster)
            tile = TileName(None, kind)
            for size in wanted:
                if picture is not None and size[0] == tile and self._is_due(size, picture.step):
                    await self._render_raster(worker, picture, size)

    async def _look(self, worker: Worker, wanted: set[Size]) -> None:
        """Look at the record where it may have changed, or there is something to render."""
        orders = self._orders(wanted)
        may_have_come = self._changes.may_have_come(self.source.folder) or self.source.until_utc_s is not None
        if not may_have_come and all(order.known in (0, order.former) for order in orders):
            return
        while not (found := await self._take(worker, orders)).is_complete:
            made = {order for rendered in found.rendered for order in rendered.orders}
            orders = [replace(order, known=self._known(order.tile)) for order in orders if order not in made]

    async def _look_apart(self, worker: Worker, wanted: set[Size]) -> None:
        """Render the frames one by one, since one of them may have ended the worker: it is not tried again."""
        await self._take(worker, ())
        orders = self._orders(wanted)
        for vehicle_id in dict.fromkeys(order.tile.vehicle_id for order in orders):
            apart = [order for order in orders if order.tile.vehicle_id == vehicle_id]
            for order in apart:
                self._try((order.tile, order.width_px), order.known, self._now_s())
            await self._take(worker, apart)
        self._is_careful = False

    def _orders(self, wanted: set[Size]) -> list[Order]:
        """Return the cameras' tiles whose rate allows another picture, those first that have waited longest."""
        rested = [size for size in wanted if size[0].vehicle_id is not None and self._is_rested(size)]
        rested.sort(key=lambda size: (self._tried_at_s.get(size, -math.inf), size))
        return [Order(*size, self._known(size[0]), self._tried.get(size, 0)) for size in rested]

    def _known(self, tile: TileName) -> int:
        """Return the number of the newest frame that a tile can be rendered from; 0 while there is none."""
        known = self._newest.get(tile.vehicle_id) if tile.vehicle_id is not None else None
        return known[0].number if known is not None and tile.kind in known[0].kinds else 0

    async def _take(self, worker: Worker, orders: Sequence[Order]) -> Look:
        """Look at the record, and take what was found and made."""
        begin_s, until_utc_s = self._now_s(), self.source.until_utc_s
        after = self._after if until_utc_s is None else 0
        found = await worker.run(look, self.source.folder, after, until_utc_s, orders)
        if until_utc_s is not None:  # a replay may have gone back to where some had no frame yet
            there = {frame.vehicle_id for frame in found.newest}
            self._forget([size for size in self._tried if size[0].vehicle_id not in there | {None}])
            self._newest.clear()
        now_s = self._now_s()
        for frame in found.newest:
            self._newest[frame.vehicle_id] = frame, now_s
            self._after = max(self._after, frame.number)
        for rendered in found.rendered:
            self._show_frame(rendered, begin_s)
        if found.rendered:
            self._tell()
        return found

    def _show_frame(self, rendered: RenderedFrame, begin_s: float) -> None:
        sizes = [(order.tile, order.width_px) for order in rendered.orders]
        for size in sizes:
            self._try(size, rendered.number, begin_s)
        if rendered.fault:
            _log.warning("Live pictures: %s", rendered.fault)
            return
        frame, seen_at_s = self._newest[rendered.vehicle_id]
        place = viewed_place(frame, self.source.ground_amsl_m())
        for size, picture in zip(sizes, rendered.pictures, strict=True):
            self._slots[size] = Slot(self._next_version(), picture, frame.utc_s, seen_at_s, place)

    def _forget(self, sizes: Sequence[Size]) -> None:
        for size in sizes:
            self._slots.pop(size, None)
            self._tried.pop(size, None)
            self._tried_at_s.pop(size, None)

    def _is_due(self, size: Size, origin: int) -> bool:
        return self._is_rested(size) and self._tried.get(size) != origin

    def _is_rested(self, size: Size) -> bool:
        interval_s = EARLY / self.settings.rate_hz
        return self._now_s() - self._tried_at_s.get(size, -math.inf) >= interval_s

    def _try(self, size: Size, origin: int, begin_s: float) -> None:
        """Note that a picture is being made: what cannot be rendered is not tried again and again."""
        self._tried[size] = origin
        self._tried_at_s[size] = begin_s

    async def _render_raster(self, worker: Worker, raster: Picture, size: Size) -> None:
        utc_s, seen_at_s = self.source.picture_utc_s(raster), self._now_s()
        self._try(size, raster.step, seen_at_s)
        place = raster_place(raster, self.source.origin())
        try:
            picture = await worker.run(render_raster, raster.png, size[1])
        except InputDataError as error:
            _log.warning("Live pictures: %s", error)
            return
        self._slots[size] = Slot(self._next_version(), picture, utc_s, seen_at_s, place)
        self._tell()

    def _tell(self) -> None:
        """Tell the viewers that there are new pictures, all of one look at once: many share one message then."""
        for watch in self._watches:
            watch.nudge()

    def _next_version(self) -> int:
        self._count += 1
        return self._count
