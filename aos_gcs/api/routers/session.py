"""Signing in as an operator."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from aos_gcs.api.access.operators import OBSERVER, Session, cookie_name
from aos_gcs.api.dependencies import CurrentSession, OperatorAccess
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.service import SessionModel, SignInRequest

router = APIRouter(prefix="/api/session", tags=["session"])


@router.get("")
async def read_session(session: CurrentSession, access: OperatorAccess) -> SessionModel:
    """Return the role of this client."""
    return _session_model(session, access.is_required)


@router.post(
    "",
    responses={
        403: {"model": ErrorModel},
        422: {"model": ErrorModel},
        429: {
            "model": ErrorModel,
            "description": "Too many wrong codes; Retry-After has the seconds to wait.",
        },
    },
)
async def sign_in(body: SignInRequest, request: Request, response: Response, access: OperatorAccess) -> SessionModel:
    """Become an operator by the service's code; the cookie that comes with the answer is the proof from then on."""
    if not access.is_required:
        return _session_model(access.session(None), is_required=False)
    address = request.client.host if request.client else ""
    token = access.sign_in(body.code, body.name, address)
    await access.write_down()
    response.set_cookie(cookie_name(request), token, httponly=True, samesite="strict", path="/api")
    return _session_model(access.session(token), is_required=True)


@router.delete("")
async def sign_out(request: Request, response: Response, access: OperatorAccess) -> SessionModel:
    """Become an observer again."""
    name = cookie_name(request)
    access.sign_out(request.cookies.get(name))
    await access.write_down()
    response.delete_cookie(name, httponly=True, samesite="strict", path="/api")
    return _session_model(OBSERVER if access.is_required else access.session(None), access.is_required)


def _session_model(session: Session, is_required: bool) -> SessionModel:
    return SessionModel(role=session.role, name=session.name, sign_in_required=is_required)
