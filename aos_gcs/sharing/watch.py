"""Notices about live sharing: what fails for a while, what works again, and what others propose."""

from __future__ import annotations

import math
from collections.abc import Callable

from aos_gcs.mission.model.proposals import Proposal
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.mission.proposals import Proposals
from aos_gcs.ports import Notice, Severity

PATIENCE_S = 10.0
"""Time for which a channel may fail before it is reported: servers are restarted."""
PROPOSALS_S = 60.0
"""Shortest time between two notices about proposals, however many come."""


class SharingWatch:
    """Reports to operators when a channel fails for some time, and when it works again.

    Args:
        notify: takes notices.
        now_s: steady clock in real seconds.
    """

    def __init__(self, notify: Callable[[Notice], None], now_s: Callable[[], float]) -> None:
        self._notify = notify
        self._now_s = now_s
        self._failing_since_s: dict[str, float] = {}
        self._reported: dict[str, ChannelState] = {}

    def look(self, statuses: tuple[ChannelStatus, ...]) -> None:
        """Look at the present states, about once a second."""
        for status in statuses:
            if status.state is ChannelState.CONNECTED:
                self._failing_since_s.pop(status.name, None)
                self._report(status, Severity.INFO, status.text)
            elif status.state is not ChannelState.CONNECTING:
                since_s = self._failing_since_s.setdefault(status.name, self._now_s())
                if status.state is ChannelState.REFUSED or self._now_s() - since_s >= PATIENCE_S:
                    self._report(status, Severity.WARNING, f"nothing is shared. {status.text}")

    def _report(self, status: ChannelStatus, severity: Severity, text: str) -> None:
        if self._reported.get(status.name) is not status.state:
            self._reported[status.name] = status.state
            self._notify(Notice(severity, f"Sharing with {status.name} ({status.target}): {text}"))


class ProposalWatch:
    """Takes what others propose to a mission, and reports to operators that something waits for them.

    Args:
        proposals: proposals of the mission.
        notify: takes notices.
        now_s: steady clock in real seconds.
    """

    def __init__(self, proposals: Proposals, notify: Callable[[Notice], None], now_s: Callable[[], float]) -> None:
        self._proposals = proposals
        self._notify = notify
        self._now_s = now_s
        self._reported_at_s = -math.inf
        self._unreported = 0

    def take(self, source: str, proposals: tuple[Proposal, ...], withdrawn: tuple[str, ...]) -> None:
        """Take proposals and deletions; what is not of this source is left out."""
        self._proposals.withdraw(source, withdrawn)
        self._unreported += self._proposals.take([one for one in proposals if one.source == source])
        if self._unreported and self._now_s() - self._reported_at_s >= PROPOSALS_S:
            self._report(source)

    def _report(self, source: str) -> None:
        self._reported_at_s = self._now_s()
        count, self._unreported = self._unreported, 0
        what = "one proposal waits" if count == 1 else f"{count} proposals wait"
        self._notify(Notice(Severity.INFO, f"From {source}: {what} for the plan"))
