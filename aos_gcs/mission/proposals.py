"""The proposals of a mission: kept, decided once, and bounded whatever others send."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Final

from aos_gcs.errors import InputDataError, MissionError
from aos_gcs.mission.model.proposals import MAX_PROPOSALS, Proposal, ProposalRecord, ProposalUse

KEPT_S: Final = 3600.0
"""Time for which a proposal stays, however soon it is out of date: who draws one waits for an operator."""
MAX_KEPT_S: Final = 86_400.0
"""Time after which a proposal that was not sent again goes, however long its sender wants it to stay."""


class Proposals:
    """Keeps at most ``MAX_PROPOSALS``.

    Decided ones give way to new ones, then the oldest of the sender with the most that wait: whoever floods the desk
    takes no place from others.
    """

    def __init__(self) -> None:
        self._records: dict[tuple[str, str], ProposalRecord] = {}
        self._count = 0
        self.refused = 0
        """Number of proposals for which there was no room, or that were out of bounds."""

    def all(self) -> tuple[ProposalRecord, ...]:
        """Return the proposals, oldest first."""
        return tuple(self._records.values())

    def restore(self, records: Sequence[ProposalRecord], utc_s: float) -> None:
        """Take what the station before had, with the decisions; what has expired meanwhile or is out of bounds is left.

        What its sender has deleted meanwhile is not known: it goes when it expires.

        Args:
            records: proposals of its record, oldest first.
            utc_s: present time of this machine; what came later than that, by a clock that was wrong, came now.
        """
        for record in records[-MAX_PROPOSALS:]:
            with suppress(InputDataError):
                record.proposal.require_bounds()
                received_utc_s = min(record.proposal.received_utc_s, utc_s)
                proposal = replace(record.proposal, received_utc_s=received_utc_s)
                self._records[proposal.source, proposal.uid] = replace(record, proposal=proposal)
                self._count = max(self._count, record.proposal_id)
        self.expire(utc_s)

    def take(self, proposals: Sequence[Proposal]) -> int:
        """Take proposals that are new or were sent again, and return how many wait for a decision that did not."""
        return sum(map(self._take, proposals))

    def _take(self, proposal: Proposal) -> bool:
        try:
            proposal.require_bounds()
        except InputDataError:
            self.refused += 1
            return False
        key = proposal.source, proposal.uid
        former = self._records.get(key)
        if former is not None and former.proposal.content == proposal.content:
            self._records[key] = replace(former, proposal=proposal)
            return False
        if former is None and len(self._records) >= MAX_PROPOSALS and not self._make_room(proposal):
            self.refused += 1
            return False
        self._records.pop(key, None)  # goes to the end: it is new to the operators
        self._count += 1
        self._records[key] = ProposalRecord(self._count, proposal)
        return True

    def _make_room(self, proposal: Proposal) -> bool:
        decided = next((key for key, record in self._records.items() if record.use is not None), None)
        if decided is not None:
            del self._records[decided]
            return True
        waiting = Counter(_sender(record.proposal) for record in self._records.values())
        busiest, most = waiting.most_common(1)[0]
        if most <= waiting[_sender(proposal)] + 1:
            return False
        del self._records[next(key for key, record in self._records.items() if _sender(record.proposal) == busiest)]
        self.refused += 1
        return True

    def withdraw(self, source: str, uids: Sequence[str]) -> None:
        """Forget proposals that their senders have deleted; what was made of them stays."""
        for uid in uids:
            self._records.pop((source, uid), None)

    def expire(self, utc_s: float) -> None:
        """Forget what has been out of date, or was not sent again, for long.

        Args:
            utc_s: present time of this machine, whatever the mission's clock.
        """
        for key, record in list(self._records.items()):
            proposal = record.proposal
            least_s, most_s = proposal.received_utc_s + KEPT_S, proposal.received_utc_s + MAX_KEPT_S
            if utc_s > min(max(proposal.stale_utc_s, least_s), most_s):
                del self._records[key]

    def check(self, proposal_id: int, use: ProposalUse) -> ProposalRecord:
        """Return a proposal that is to be used.

        Raises:
            MissionError: it is gone, was decided, or cannot be used so.
        """
        record = next((one for one in self._records.values() if one.proposal_id == proposal_id), None)
        if record is None:
            raise MissionError(f"There is no proposal {proposal_id} any more: its sender has changed or deleted it.")
        if record.use is not None:
            raise MissionError(f"{record.operator or 'Another operator'} has decided about this proposal already.")
        if not record.proposal.allows(use):
            raise MissionError(f"A {record.proposal.shape} of this form cannot be used as {use}; dismiss it.")
        return record

    def decide(self, proposal_id: int, use: ProposalUse, operator: str, utc_s: float) -> ProposalRecord:
        """Note what an operator makes of a proposal; see :meth:`check`."""
        record = self.check(proposal_id, use)
        decided = replace(record, use=use, operator=operator, decided_utc_s=utc_s)
        self._records[record.proposal.source, record.proposal.uid] = decided
        return decided


def _sender(proposal: Proposal) -> tuple[str, str]:
    return proposal.source, proposal.sender
