"""What others have proposed by a channel."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.mission.model.proposals import Proposal


@dataclass(frozen=True, slots=True)
class ProposalChanges:
    """Proposals that have come, and names of those that were deleted, since they were asked for last."""

    source: str = ""
    proposals: tuple[Proposal, ...] = ()
    withdrawn: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.proposals or self.withdrawn)
