"""Choice of the file that is the image of an exposure, among those that have appeared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

from aos_drivers.frames.errors import FrameRefusedError

_IMAGE_SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".tif", ".tiff"})


@dataclass(frozen=True, slots=True)
class FileStamp:
    """Properties of a file that change when it is written."""

    size_bytes: int | None
    """Size; None if the server's listing has none."""
    modified_utc_s: float | None


Listing = Mapping[str, FileStamp]
"""The files at one moment, by name."""


@dataclass(frozen=True, slots=True)
class WantedImage:
    """Description of the wanted image."""

    before: Listing
    """Files from before the exposure: none of them is the image, unless it was written again."""
    index: int | None = None
    """Index in the file's name; None if unknown."""
    utc_s: float | None = None
    """Time of the exposure; None if unknown."""
    tolerance_s: float = 1.0
    file_name: str | None = None
    """Pattern of the name with ``{index}``; None if names carry no index."""
    earlier: int = 0
    """Number of new files that are to come first, those of exposures before."""

    @property
    def name(self) -> str | None:
        """Name that the file must have; None if unknown."""
        if self.file_name is None or self.index is None:
            return None
        return self.file_name.format(index=self.index)


def is_image_name(name: str) -> bool:
    """Return whether a name is that of an image, in this folder, that is not being written under another name."""
    is_plain = "/" not in name and "\\" not in name and "\0" not in name and not name.startswith(".")
    return is_plain and PurePosixPath(name).suffix.lower() in _IMAGE_SUFFIXES


def choose(now: Listing, wanted: WantedImage) -> str | None:
    """Return the name of the wanted image, or None while it is not there.

    By its name where that holds the index. Otherwise it is the one file that is new, behind those that are to come
    first; of more, the one whose time is that of the exposure.

    Raises:
        FrameRefusedError: several new files could be the image.
    """
    fresh = {name: stamp for name, stamp in now.items() if wanted.before.get(name) != stamp}
    if wanted.name is not None:
        return wanted.name if wanted.name in fresh else None
    if len(fresh) <= wanted.earlier:
        return None
    if (last := _last(fresh)) is not None and len(fresh) == wanted.earlier + 1:
        return last
    by_distance = sorted((_distance_s(stamp, wanted), name) for name, stamp in fresh.items())
    within = [name for distance_s, name in by_distance if distance_s <= wanted.tolerance_s]
    if len(within) != 1:
        raise FrameRefusedError(
            f"{len(fresh)} new files ({', '.join(sorted(fresh)[:3])} …), {len(within)} of them from within "
            f"{wanted.tolerance_s:g} s of the exposure: name them with the index (file_name), or expose less often"
        )
    return within[0]


def _last(files: Listing) -> str | None:
    """Return the file that was written after all others; None if that is not known."""
    if len(files) == 1:
        return next(iter(files))
    times_s = {name: stamp.modified_utc_s for name, stamp in files.items() if stamp.modified_utc_s is not None}
    last_s = max(times_s.values(), default=0.0)
    last = [name for name, time_s in times_s.items() if time_s == last_s]
    return last[0] if len(last) == 1 and len(times_s) == len(files) else None


def newest(now: Listing, wanted: WantedImage) -> str | None:
    """Return the file written last among those that were not there before; None if there is none."""
    fresh = [(stamp.modified_utc_s or 0.0, name) for name, stamp in now.items() if wanted.before.get(name) != stamp]
    return max(fresh)[1] if fresh else None


def _distance_s(stamp: FileStamp, wanted: WantedImage) -> float:
    if stamp.modified_utc_s is None or wanted.utc_s is None:
        return float("inf")
    return abs(stamp.modified_utc_s - wanted.utc_s)
