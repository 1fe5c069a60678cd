"""Proposals of others for the plan: marks and drawings that came by live sharing."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from aos_gcs.api.convert import proposals as convert
from aos_gcs.api.dependencies import Commands, CurrentSession, Mission
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.proposals import ProposalDecision, ProposalModel

router = APIRouter(prefix="/api/proposals", tags=["proposals"])

_REFUSED: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (403, 409, 422)}


@router.get("")
async def read_proposals(mission: Mission) -> list[ProposalModel]:
    """Return the proposals that wait, and those that were decided about, oldest first."""
    return [convert.proposal(one) for one in mission.snapshot().proposals]


@router.post("/{proposal_id}", responses=_REFUSED)
async def decide(
    proposal_id: Annotated[int, Path(ge=1)], body: ProposalDecision, commands: Commands, session: CurrentSession
) -> ProposalModel:
    """Put on record what an operator makes of a proposal; one that becomes a finding is marked as one."""
    return convert.proposal(await commands.decide_proposal(proposal_id, body.use, operator=session.name))
