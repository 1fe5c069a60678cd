"""Waiting for the file of an exposure, wherever files appear."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from yarl import URL

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError, PendingImageError, TornFrameError
from aos_drivers.frames.files.companion import CompanionListing
from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.files.folder import WatchedFolder
from aos_drivers.frames.files.matching import Listing, WantedImage, choose
from aos_drivers.frames.settings import ImagePlace
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Clock

POLL_S = 0.1
STALE_S = 2.0
"""Web servers give times in whole seconds."""

T = TypeVar("T")


class FileStore(Protocol):
    """Something that lists files and hands them out."""

    async def listing(self, deadline_s: float) -> Listing:
        """Return the images that are there."""
        ...

    async def read(self, name: str, deadline_s: float) -> bytes:
        """Return the content of one of them."""
        ...


class ImageFinder:
    """Finds the image files of one vehicle and hands them to a reader of images, until one is whole."""

    def __init__(self, place: ImagePlace, vehicle_id: int, clock: Clock, fetcher: ImageFetcher) -> None:
        self._place = place
        self._vehicle_id = vehicle_id
        self._clock = clock
        self._fetcher = fetcher
        folder = place.folder_of(vehicle_id)
        self._folder = None if folder is None else WatchedFolder(folder, clock, fetcher.limits)

    async def before(self, host: str, deadline_s: float) -> Listing:
        """Return the files from before an exposure; none where files are requested by their index."""
        if self._place.has_index:
            return {}
        return await self._store(host).listing(deadline_s)

    async def find(
        self,
        wanted: WantedImage,
        read: Callable[[bytes], T],
        *,
        host: str,
        deadline_s: float,
        pick: Callable[[Listing, WantedImage], str | None] = choose,
    ) -> tuple[T, str]:
        """Return the wanted file as ``read`` decodes it, and its name; ``pick`` chooses the file from a listing.

        ``read`` must be a function that another process can import.

        Raises:
            LateFrameError: the file did not appear by the deadline.
            TornFrameError: it appeared, but was not whole by then.
            CaptureError: it cannot be had or read.
        """
        asked_at_s = self._clock.now_s()
        while True:
            problem: CaptureError = LateFrameError("its file did not appear in time")
            try:
                found = await self._look(wanted, host, asked_at_s, deadline_s, pick)
                if found is not None:
                    async with self._clock.timeout_at(deadline_s):
                        return await self._fetcher.decode(read, found[0]), found[1]
            except TimeoutError:
                raise LateFrameError("its file was not decoded in time") from None
            except (TornFrameError, PendingImageError) as error:
                problem = error if isinstance(error, TornFrameError) else LateFrameError(str(error))
            if self._clock.now_s() + POLL_S >= deadline_s:
                raise problem
            await self._clock.sleep(POLL_S)

    async def _look(
        self,
        wanted: WantedImage,
        host: str,
        asked_at_s: float,
        deadline_s: float,
        pick: Callable[[Listing, WantedImage], str | None],
    ) -> tuple[bytes, str] | None:
        if self._place.has_index:
            return await self._by_index(wanted, host, asked_at_s, deadline_s)
        store = self._store(host)
        name = pick(await store.listing(deadline_s), wanted)
        return None if name is None else (await store.read(name, deadline_s), name)

    async def _by_index(
        self, wanted: WantedImage, host: str, asked_at_s: float, deadline_s: float
    ) -> tuple[bytes, str]:
        if wanted.index is None:
            raise FrameRefusedError("the index of the image is not known, and its address needs it (url)")
        url = self._place.url_of(self._vehicle_id, host, wanted.index)
        download = await self._fetcher.download(url, URL(url).host or "", deadline_s)
        elapsed_s = self._clock.now_s() - asked_at_s
        if download.age_s is not None and download.age_s > elapsed_s + wanted.tolerance_s + STALE_S:
            raise PendingImageError(f"{url} is {download.age_s:.0f} s old: that of another flight")
        return download.data, url

    def _store(self, host: str) -> FileStore:
        if self._folder is not None:
            return self._folder
        return CompanionListing(self._fetcher, self._place.url_of(self._vehicle_id, host))
