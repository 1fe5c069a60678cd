"""Proposals from TAK on their way to the mission: bounded in number and rate, without our own echo."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final
from xml.etree.ElementTree import Element

from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.proposals import MAX_PROPOSALS, Proposal
from aos_gcs.sharing.channel import ProposalChanges
from aos_gcs.sharing.heights import UndulationM
from aos_gcs.sharing.tak.marks import SOURCE, Withdrawal, read_mark
from aos_gcs.token_bucket import TokenBucket

EVENTS_PER_S: Final = 20.0
EVENTS_BURST: Final = 400.0
"""Events that are read at once, such as what a server repeats to a new client; further ones are left out."""
MAX_WITHDRAWN: Final = 256
_SET_BY_PEOPLE: Final = re.compile(rb"""\show\s*=\s*["']h|\stype\s*=\s*["']t-x-d-d""")


class Inbox:
    """Keeps the newest proposals until they are passed on.

    Args:
        name: name of this station, by which it knows its own marks.
        undulation_m: height of the geoid; None: altitudes stay unknown.
        now_s: steady clock in real seconds.
        utc_s: clock for people.
    """

    def __init__(
        self, name: str, undulation_m: UndulationM | None, now_s: Callable[[], float], utc_s: Callable[[], float]
    ) -> None:
        self._own = f"{name}."
        self._undulation_m = undulation_m
        self._now_s = now_s
        self._utc_s = utc_s
        self._bucket = TokenBucket(EVENTS_PER_S, EVENTS_BURST)
        self._waiting: dict[str, Proposal] = {}
        self._withdrawn: dict[str, None] = {}
        self.received = 0
        """Marks and drawings that came as proposals, repeated ones too."""
        self.refused = 0
        """Events that could not be read or used."""
        self.reason = ""
        """Reason of the latest refusal."""

    def admits(self, event: bytes) -> bool:
        """Return whether an event is worth parsing, and may be parsed now; what is too much is counted as left out.

        Positions that devices report, ours among them, are by far the most, and none of our business.
        """
        if not _SET_BY_PEOPLE.search(event):
            return False
        if self._bucket.take(1.0, self._now_s()):
            return True
        self.refuse(f"more than {EVENTS_PER_S:.0f} events per second")
        return False

    def refuse(self, reason: str) -> None:
        """Count an event that cannot be used."""
        self.refused += 1
        self.reason = reason

    def take(self, event: Element) -> None:
        """Take an event that was parsed."""
        if event.get("uid", "").startswith(self._own):
            return
        try:
            found = read_mark(event, self._undulation_m, self._utc_s())
        except InputDataError as error:
            self.refuse(str(error))
            return
        if isinstance(found, Withdrawal):
            for uid in found.uids:
                self._waiting.pop(uid, None)
                if len(self._withdrawn) < MAX_WITHDRAWN:
                    self._withdrawn[uid] = None
        elif found is not None:
            self.received += 1
            if found.uid in self._waiting or len(self._waiting) < MAX_PROPOSALS:
                self._withdrawn.pop(found.uid, None)
                self._waiting[found.uid] = found
            else:
                self.refuse("more proposals at once than are kept")

    def changes(self) -> ProposalChanges:
        """Return what has come since the last call."""
        found = ProposalChanges(SOURCE, tuple(self._waiting.values()), tuple(self._withdrawn))
        self._waiting.clear()
        self._withdrawn.clear()
        return found
