"""Automatic start of a mission: on as the configuration says, until something ends it for good."""

from __future__ import annotations

from aos_gcs.mission.journal import Journal
from aos_gcs.ports import Severity


class AutoStart:
    """Whether the mission starts as soon as preflight has passed; once cancelled it waits for an operator.

    Args:
        journal: the mission's journal.
        is_on: whether the configuration asks for it.
    """

    def __init__(self, journal: Journal, *, is_on: bool) -> None:
        self._journal = journal
        self._is_on = is_on

    @property
    def is_on(self) -> bool:
        """Whether the mission starts without an operator."""
        return self._is_on

    def cancel(self, reason: str) -> None:
        """Let only an operator start the mission: people may be at the vehicles."""
        if self._is_on:
            self._is_on = False
            self._journal.notice(Severity.WARNING, f"Automatic start cancelled: {reason}. Launch by hand")
