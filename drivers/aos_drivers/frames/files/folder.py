"""A folder that images are dropped into, by a companion computer, a card reader or a network share."""

from __future__ import annotations

import asyncio
import math
import os
import stat
from pathlib import Path

from aos_drivers.frames.errors import PendingImageError, TornFrameError
from aos_drivers.frames.files.fetching import ImageLimits
from aos_drivers.frames.files.matching import FileStamp, Listing, is_image_name
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Clock

SETTLE_S = 0.2
"""Time without a change after which a file is taken to be complete; decoding confirms it."""
_MAX_FILES = 50_000


class WatchedFolder:
    """Lists and reads images; never one that is still being written, and nothing outside of the folder."""

    def __init__(self, folder: Path, clock: Clock, limits: ImageLimits) -> None:
        self._folder = folder
        self._clock = clock
        self._limits = limits
        self._seen: dict[str, tuple[FileStamp, float]] | None = None
        """Stamp by name, and since when it has been so; None before the first look."""

    async def listing(self, deadline_s: float) -> Listing:
        """Return the images that have not changed lately.

        Raises:
            CaptureError: the folder cannot be read, or holds too many files.
        """
        del deadline_s
        stamps, now_s = await asyncio.to_thread(self._scan), self._clock.now_s()
        # A file that was there at the first look has had its time.
        unseen_since_s = now_s if self._seen is not None else -math.inf
        before = self._seen or {}
        self._seen = {
            name: before[name] if name in before and before[name][0] == stamp else (stamp, unseen_since_s)
            for name, stamp in stamps.items()
        }
        return {name: stamp for name, (stamp, since_s) in self._seen.items() if now_s - since_s >= SETTLE_S}

    async def read(self, name: str, deadline_s: float) -> bytes:
        """Return a file of the listing.

        Raises:
            PendingImageError: it is there no more.
            TornFrameError: it changed while it was read.
            CaptureError: it is not a regular file, too large or cannot be read.
        """
        del deadline_s
        return await asyncio.to_thread(self._read, name)

    def _scan(self) -> dict[str, FileStamp]:
        found: dict[str, FileStamp] = {}
        try:
            with os.scandir(self._folder) as entries:
                for entry in entries:
                    if is_image_name(entry.name) and entry.is_file(follow_symlinks=False):
                        found[entry.name] = _stamp(entry.stat(follow_symlinks=False))
                    if len(found) > _MAX_FILES:
                        raise CaptureError(f"{self._folder} holds more than {_MAX_FILES} images: move old ones away")
        except OSError as error:
            raise CaptureError(f"the folder {self._folder} cannot be read: {error.strerror}") from error
        return found

    def _read(self, name: str) -> bytes:
        if not is_image_name(name):
            raise CaptureError(f"{name!r} is not the name of an image")
        path = self._folder / name
        try:
            # No links: a program that writes into the folder must not choose what is read.
            with os.fdopen(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
                before = os.fstat(file.fileno())
                if not stat.S_ISREG(before.st_mode):
                    raise CaptureError(f"{path} is not a regular file")
                if before.st_size > self._limits.max_bytes:
                    raise CaptureError(
                        f"{path} is larger than {self._limits.max_bytes / 2**20:.0f} MiB (max_image_mib)"
                    )
                data = file.read(self._limits.max_bytes + 1)
                if _stamp(os.fstat(file.fileno())) != _stamp(before) or len(data) != before.st_size:
                    raise TornFrameError(f"{path} is still being written")
        except FileNotFoundError as error:
            raise PendingImageError(f"{path} no longer exists") from error
        except OSError as error:
            raise CaptureError(f"{path} cannot be read: {error.strerror}") from error
        return data


def _stamp(status: os.stat_result) -> FileStamp:
    return FileStamp(status.st_size, status.st_mtime)
