"""Acknowledgements of notices: shared by all operators, and on record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.snapshot import Acknowledgement

ACKNOWLEDGEMENTS_KEPT: Final = 200
"""Number of acknowledgements kept, as many as notices are shown; the record has the older ones."""


class Acknowledgements:
    """The notices that operators have acknowledged."""

    def __init__(self) -> None:
        self._by_notice: dict[int, Acknowledgement] = {}

    def all(self) -> tuple[Acknowledgement, ...]:
        """Return the acknowledgements that are kept, by the number of their notice."""
        return tuple(self._by_notice[notice_id] for notice_id in sorted(self._by_notice))

    def add(self, notice_ids: Sequence[int], operator: str, utc_s: float, last_notice_id: int) -> bool:
        """Acknowledge notices; see ``MissionCommands.acknowledge``. Return whether any was new."""
        unknown = [notice_id for notice_id in notice_ids if not 1 <= notice_id <= last_notice_id]
        if unknown:
            raise MissionError(f"There is no notice {unknown[0]} in this mission; the latest one is {last_notice_id}.")
        before = set(self._by_notice)
        for notice_id in notice_ids:
            self._by_notice.setdefault(notice_id, Acknowledgement(notice_id, operator, utc_s))
        for notice_id in sorted(self._by_notice)[:-ACKNOWLEDGEMENTS_KEPT]:
            del self._by_notice[notice_id]
        return self._by_notice.keys() != before
