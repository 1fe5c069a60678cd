"""Control of the swarm: who of several operators commands."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from aos_gcs.api.convert.mission import control
from aos_gcs.api.dependencies import ControlOfSwarm, CurrentSession, OperatorAccess
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.control import ControlAnswer, ControlModel, TakeControlRequest

_REFUSED: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (403, 409, 422)}

router = APIRouter(prefix="/api/control", tags=["control"], responses=_REFUSED)


@router.post("/request")
async def ask_for_control(session: CurrentSession, desk: ControlOfSwarm, access: OperatorAccess) -> ControlModel:
    """Ask for control; whoever has it answers, within a minute."""
    await desk.ask(session)
    return control(access.control.state())


@router.post("/answer")
async def answer_request(
    body: ControlAnswer, session: CurrentSession, desk: ControlOfSwarm, access: OperatorAccess
) -> ControlModel:
    """Give control to an operator who asks for it, or refuse."""
    await desk.answer(session, body.operator, granted=body.granted)
    return control(access.control.state())


@router.post("/take")
async def take_control(
    body: TakeControlRequest, session: CurrentSession, desk: ControlOfSwarm, access: OperatorAccess
) -> ControlModel:
    """Take over control, with a reason for the audit log."""
    await desk.take(session, body.reason)
    return control(access.control.state())


@router.post("/release")
async def release_control(session: CurrentSession, desk: ControlOfSwarm, access: OperatorAccess) -> ControlModel:
    """Release control; the first operator who commands has it then."""
    await desk.release(session)
    return control(access.control.state())
