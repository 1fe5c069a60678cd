"""Signing in: with the operator code, or with an account."""

from __future__ import annotations

import asyncio
from typing import Any

from fastapi import APIRouter, Request, Response

from aos_gcs.api.access.accounts import Account
from aos_gcs.api.access.desk import AccountDesk
from aos_gcs.api.access.operators import Access, TooManyGuessesError, WrongCodeError, cookie_name
from aos_gcs.api.access.roles import Session
from aos_gcs.api.access.sign_in_log import SignInKind
from aos_gcs.api.dependencies import CurrentSession, Desk, DeskIfAny, OperatorAccess
from aos_gcs.api.models.accounts import JoinRequest, PasswordRequest
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.service import SessionModel, SignInRequest
from aos_gcs.errors import InputDataError

router = APIRouter(prefix="/api/session", tags=["session"])

_REFUSED: dict[int | str, dict[str, Any]] = {
    403: {"model": ErrorModel},
    422: {"model": ErrorModel},
    429: {
        "model": ErrorModel,
        "description": "Too many wrong codes or passwords; Retry-After has the seconds to wait.",
    },
}


@router.get("")
async def read_session(session: CurrentSession, access: OperatorAccess) -> SessionModel:
    """Return the role of this client."""
    return _session_model(session, access)


@router.post("", responses=_REFUSED)
async def sign_in(
    body: SignInRequest, request: Request, response: Response, access: OperatorAccess, desk: DeskIfAny
) -> SessionModel:
    """Sign in by the service's code or by an account; the cookie of the answer is the proof from then on."""
    if not access.is_required:
        return _session_model(access.session(None), access)
    address = _address(request)
    if desk is None:
        if body.code is None:
            raise InputDataError("code: missing; this service has no accounts.")
        token = access.sign_in(body.code, body.name, address)
    else:
        if body.password is None:
            raise InputDataError("password: missing; sign in with an account.")
        token = await _by_password(access, desk, body.name, body.password, address)
    return await _signed_in(token, request, response, access)


@router.post("/invitation", responses=_REFUSED | {404: {"model": ErrorModel}, 409: {"model": ErrorModel}})
async def join(
    body: JoinRequest, request: Request, response: Response, access: OperatorAccess, desk: Desk
) -> SessionModel:
    """Make an account by an invitation, and sign in with it."""

    async def made() -> Account:
        return await asyncio.to_thread(desk.accept, body.token, body.name, body.password, _address(request))

    token = await access.sign_in_by(made, _address(request))
    return await _signed_in(token, request, response, access)


@router.post("/password", responses=_REFUSED | {404: {"model": ErrorModel}})
async def change_password(
    body: PasswordRequest,
    request: Request,
    response: Response,
    *,
    session: CurrentSession,
    access: OperatorAccess,
    desk: Desk,
) -> SessionModel:
    """Set another password for one's own account. All of its sessions end; this client gets a new one."""

    async def changed() -> Account | None:
        if await desk.sessions.find(session.name, body.old_password) is None:
            return None
        return await asyncio.to_thread(desk.set_password, session.name, body.new_password, _address(request))

    token = await access.sign_in_by(changed, _address(request), session.name)
    return await _signed_in(token, request, response, access)


@router.delete("")
async def sign_out(
    request: Request, response: Response, session: CurrentSession, access: OperatorAccess, desk: DeskIfAny
) -> SessionModel:
    """End the session of this client."""
    name = cookie_name(request)
    access.sign_out(request.cookies.get(name))
    await access.write_down()
    if desk is not None and session.name:
        await desk.note(SignInKind.SIGNED_OUT, session.name, _address(request))
    response.delete_cookie(name, httponly=True, samesite="strict", path="/api", secure=_is_encrypted(request))
    return _session_model(access.session(None), access)


async def _by_password(access: Access, desk: AccountDesk, name: str, password: str, address: str) -> str:
    try:
        token = await access.sign_in_by(lambda: desk.sessions.find(name, password), address, name)
    except TooManyGuessesError:
        await desk.note_locked(name, address)
        raise
    except WrongCodeError:
        await desk.note(SignInKind.WRONG, name, address)
        raise
    await desk.note(SignInKind.SIGNED_IN, access.session(token).name, address)
    return token


async def _signed_in(token: str, request: Request, response: Response, access: Access) -> SessionModel:
    await access.write_down()
    response.set_cookie(
        cookie_name(request), token, httponly=True, samesite="strict", path="/api", secure=_is_encrypted(request)
    )
    return _session_model(access.session(token), access)


def _address(request: Request) -> str:
    return request.client.host if request.client else ""


def _is_encrypted(request: Request) -> bool:
    return request.url.scheme == "https"


def _session_model(session: Session, access: Access) -> SessionModel:
    return SessionModel(
        role=session.role,
        name=session.name,
        sign_in_required=access.is_required,
        accounts=access.accounts is not None,
    )
