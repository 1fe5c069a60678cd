"""One system that data is shared with: its state for operators, and the pauses between its attempts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

from aos_gcs.errors import AosError
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.proposals import Proposal
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.sharing.state import SeenState

PAUSES_S = (1.0, 2.0, 4.0)
"""Pauses before a connection is tried again, by the number of failures; the last one goes on."""


class ChannelError(AosError):
    """The other system cannot be reached or used; the text is for operators.

    Args:
        text: what has happened, and what to do.
        is_refused: whether a person has to change something before it can work.
    """

    def __init__(self, text: str, *, is_refused: bool = False) -> None:
        super().__init__(text)
        self.is_refused = is_refused


@dataclass(frozen=True, slots=True)
class ProposalChanges:
    """Proposals that have come, and names of those that were deleted, since they were asked for last."""

    source: str = ""
    proposals: tuple[Proposal, ...] = ()
    withdrawn: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.proposals or self.withdrawn)


class Channel(Protocol):
    """Shares with one system."""

    @property
    def status(self) -> ChannelStatus:
        """State of the connection."""
        ...

    def put(self, state: SeenState) -> None:
        """Take a newer state; returns at once."""
        ...

    def take(self, notice: NoticeRecord) -> None:
        """Take a notice; returns at once."""
        ...

    def proposals(self) -> ProposalChanges:
        """Return what others have proposed since the last call."""
        ...

    async def run(self) -> None:
        """Share until cancelled."""
        ...


class SendsOnly:
    """Part of channels to systems that propose nothing."""

    def proposals(self) -> ProposalChanges:
        """Return that nobody has proposed anything."""
        return ProposalChanges()


class StatusBoard:
    """Status of a channel as it changes.

    Args:
        name: name for operators.
        target: address without anything secret.
        utc_s: clock for people.
    """

    def __init__(self, name: str, target: str, utc_s: Callable[[], float]) -> None:
        self._utc_s = utc_s
        self.status = ChannelStatus(name, target, ChannelState.CONNECTING, "Connecting")

    def connecting(self) -> None:
        """Note an attempt; after a failure its reason stays in view."""
        if self.status.state is ChannelState.CONNECTED:
            self.status = replace(self.status, state=ChannelState.CONNECTING, text="Connecting")

    def connected(self, text: str) -> None:
        """Note that it works."""
        if (self.status.state, self.status.text) != (ChannelState.CONNECTED, text):
            self.status = replace(self.status, state=ChannelState.CONNECTED, text=text)

    def failed(self, error: ChannelError) -> None:
        """Note why it does not work."""
        state = ChannelState.REFUSED if error.is_refused else ChannelState.FAILED
        self.status = replace(self.status, state=state, text=str(error).removesuffix("."))

    def sent(self, count: int = 1) -> None:
        """Count messages that were sent."""
        if count:
            self.status = replace(self.status, sent=self.status.sent + count, sent_utc_s=self._utc_s())

    def received(self, received: int, refused: int, reason: str) -> None:
        """Note what has come from others so far, and why the latest could not be used."""
        self.status = replace(self.status, received=received, refused=refused, refused_text=reason)

    def lost(self, count: int = 1) -> None:
        """Count messages that were given up."""
        self.status = replace(self.status, lost=self.status.lost + count)
