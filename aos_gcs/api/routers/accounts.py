"""Accounts, for administrators."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Path, Request

from aos_gcs.api.access.accounts import INVITATION_LASTS_S, Account
from aos_gcs.api.access.desk import AccountDesk
from aos_gcs.api.dependencies import CurrentSession, Desk
from aos_gcs.api.models.accounts import (
    AccountChangeRequest,
    AccountModel,
    InvitationModel,
    InvitationRequest,
    SignInEntryModel,
)
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.clock import machine_utc_s

_FAILURES: dict[int | str, dict[str, Any]] = {status: {"model": ErrorModel} for status in (403, 404, 409, 422)}

router = APIRouter(prefix="/api/accounts", tags=["accounts"], responses=_FAILURES)

Name = Annotated[str, Path(max_length=40)]


@router.get("")
async def read_accounts(desk: Desk) -> list[AccountModel]:
    """Return all accounts, by name."""
    return [_model(desk, account) for account in desk.sessions.file.all()]


@router.get("/sign-ins")
async def read_sign_ins(desk: Desk) -> list[SignInEntryModel]:
    """Return the latest entries of the log of sign-ins, newest first."""
    return [
        SignInEntryModel(utc_s=one.utc_s, kind=one.kind, name=one.name, address=one.address, detail=one.detail)
        for one in reversed(desk.log.latest)
    ]


@router.post("/invitations", status_code=201)
async def invite(body: InvitationRequest, request: Request, session: CurrentSession, desk: Desk) -> InvitationModel:
    """Invite a person, who makes an account by the page's address with the token behind it."""
    token = await asyncio.to_thread(desk.invite, body.role, session.name, _address(request))
    return InvitationModel(token=token, role=body.role, expires_utc_s=machine_utc_s() + INVITATION_LASTS_S)


@router.patch("/{name}")
async def change_account(
    name: Name, body: AccountChangeRequest, request: Request, session: CurrentSession, desk: Desk
) -> list[AccountModel]:
    """Give an account another role, at once, and return all accounts."""
    await asyncio.to_thread(desk.set_role, name, body.role, session.name, _address(request))
    return await read_accounts(desk)


@router.delete("/{name}")
async def remove_account(name: Name, request: Request, session: CurrentSession, desk: Desk) -> list[AccountModel]:
    """Remove an account, whose sessions end at once, and return the others."""
    await asyncio.to_thread(desk.remove, name, session.name, _address(request))
    return await read_accounts(desk)


def _model(desk: AccountDesk, account: Account) -> AccountModel:
    return AccountModel(
        name=account.name,
        role=account.role,
        created_utc_s=account.created_utc_s,
        sessions=desk.sessions.count(account),
    )


def _address(request: Request) -> str:
    return request.client.host if request.client else ""
