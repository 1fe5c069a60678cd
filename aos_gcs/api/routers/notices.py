"""Taking note of what has happened."""

from __future__ import annotations

from fastapi import APIRouter

from aos_gcs.api.dependencies import CurrentSession, Mission
from aos_gcs.api.models import AcknowledgeRequest, ErrorModel

router = APIRouter(prefix="/api/notices", tags=["notices"])


@router.post(
    "/acknowledge",
    status_code=204,
    responses={403: {"model": ErrorModel}, 409: {"model": ErrorModel}, 422: {"model": ErrorModel}},
)
async def acknowledge(request: AcknowledgeRequest, mission: Mission, session: CurrentSession) -> None:
    """Take note of notices, on behalf of all operators; ``MissionModel.acknowledgements`` has it then."""
    mission.acknowledge(request.notice_ids, operator=session.name)
