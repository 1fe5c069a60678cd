"""The operator's word on failed checks before the launch."""

from __future__ import annotations

from fastapi import APIRouter

from aos_gcs.api import convert
from aos_gcs.api.dependencies import CurrentSession, Mission
from aos_gcs.api.models import ErrorModel, OverrideRequest, PreflightCheckModel

router = APIRouter(prefix="/api/preflight", tags=["preflight"])


@router.post(
    "/override", responses={403: {"model": ErrorModel}, 409: {"model": ErrorModel}, 422: {"model": ErrorModel}}
)
async def override(request: OverrideRequest, mission: Mission, session: CurrentSession) -> PreflightCheckModel:
    """Let a failed check no longer stand against the launch, or take that back, and return it as it is then."""
    check = await mission.override_check(request.vehicle_id, request.check, request.reason, operator=session.name)
    return convert.preflight_check(check)
