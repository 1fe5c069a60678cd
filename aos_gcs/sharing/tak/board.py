"""Marks that are due: live ones each second, others when they change and now and then, deletions three times."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from aos_gcs.sharing.tak.events import Mark, deletion_xml
from aos_gcs.sharing.tak.scene import Scene

LIVE_S = 0.9
"""Shortest time between two messages of a live mark: once a second, whatever the pace of the states."""
CHANGED_S = 1.0
"""Shortest time between two messages of a mark that moves by centimetres all the time."""
RENEW_S = 20.0
"""Time after which a mark that has not changed is sent again: for maps that were opened later, and lost packets."""
DELETIONS = 3
"""Number of times a deletion is sent, since datagrams get lost."""
_DELETE_AGAIN_S = 5.0
_MAX_DELETED = 2048
"""Deletions that are remembered for the next connection; the oldest are forgotten."""


@dataclass(slots=True)
class _Deletion:
    left: int = DELETIONS
    at_s: float = -math.inf


class MarkBoard:
    """Remembers what one connection was told."""

    def __init__(self) -> None:
        self._sent: dict[str, tuple[Mark, float]] = {}
        self._deleted: dict[str, _Deletion] = {}

    def start_over(self) -> None:
        """Tell a new connection everything: all marks, and all deletions, of which it may have missed some."""
        self._sent = {uid: (mark, -math.inf) for uid, (mark, _) in self._sent.items()}
        self._deleted = {uid: _Deletion() for uid in self._deleted}

    def due(self, scene: Scene, now_s: float, utc_s: float) -> list[bytes]:
        """Return the events to send now, deletions first.

        Args:
            scene: present marks.
            now_s: real seconds of a steady clock.
            utc_s: time that the events carry.
        """
        present = {mark.uid for mark in scene.marks}
        gone = [uid for uid, (mark, _) in self._sent.items() if uid not in present and not mark.is_live]
        for uid in (*gone, *scene.withdrawn):
            self._sent.pop(uid, None)
            self._deleted.setdefault(uid, _Deletion())
        for uid in present & self._deleted.keys():
            del self._deleted[uid]
        for uid in list(self._deleted)[:-_MAX_DELETED]:
            del self._deleted[uid]
        deletions = [deletion_xml(uid, utc_s) for uid in self._due_deletions(now_s)]
        return deletions + [mark.xml(utc_s) for mark in self._due_marks(scene, now_s)]

    def _due_deletions(self, now_s: float) -> Iterator[str]:
        for uid, deletion in self._deleted.items():
            if deletion.left and now_s - deletion.at_s >= _DELETE_AGAIN_S:
                deletion.left -= 1
                deletion.at_s = now_s
                yield uid

    def _due_marks(self, scene: Scene, now_s: float) -> Iterator[Mark]:
        for mark in scene.marks:
            former, at_s = self._sent.get(mark.uid, (None, -math.inf))
            age_s = now_s - at_s
            pause_s = LIVE_S if mark.is_live else RENEW_S if mark == former else CHANGED_S
            if age_s >= pause_s:
                self._sent[mark.uid] = (mark, now_s)
                yield mark
