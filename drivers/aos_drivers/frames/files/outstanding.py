"""Exposures whose files have not appeared yet, where no name tells which file belongs to which exposure."""

from __future__ import annotations

from aos_drivers.frames.files.matching import Listing

LOST_S = 10.0
"""Time for which files are missing without a pause until they are taken to be lost: none is waited for then."""


class OutstandingFiles:
    """Counts the exposures of one camera against its files.

    The file of one exposure may appear while that of the next is waited for: alone it would be taken for it, and so
    would be each one from then on.
    """

    def __init__(self) -> None:
        self._listing: Listing | None = None
        self._missing = 0
        """Exposures whose files have not appeared."""
        self._missing_since_s: float | None = None

    def look(self, listing: Listing, now_s: float) -> int:
        """Take in the files that are there before an exposure; return how many will come before its own."""
        if self._listing is not None:
            new = sum(self._listing.get(name) != stamp for name, stamp in listing.items())
            self._missing = max(0, self._missing - new)
        self._listing = listing
        if not self._missing:
            self._missing_since_s = None
        elif self._missing_since_s is None:
            self._missing_since_s = now_s
        elif now_s - self._missing_since_s > LOST_S:
            self._missing, self._missing_since_s = 0, None
        return self._missing

    def note_exposure(self) -> None:
        """Note that a file will come."""
        self._missing += 1
