"""Wire models of accounts."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from aos_gcs.api.access.accounts import AccountName
from aos_gcs.api.access.passwords import MAX_LENGTH
from aos_gcs.api.access.roles import Role
from aos_gcs.api.access.sign_in_log import SignInKind
from aos_gcs.api.models.base import WireModel

Password = Annotated[str, Field(max_length=MAX_LENGTH)]
GivenRole = Literal[Role.OBSERVER, Role.ANALYST, Role.OPERATOR, Role.ADMINISTRATOR]


class AccountModel(WireModel):
    """Account of a person."""

    name: str
    role: Role
    created_utc_s: float
    sessions: int = Field(description="Devices that are signed in.")


class AccountChangeRequest(WireModel):
    """Change of an account."""

    role: GivenRole


class InvitationRequest(WireModel):
    """Invitation of a person who makes an account by it."""

    role: GivenRole


class InvitationModel(WireModel):
    """Invitation, which serves once."""

    token: str = Field(description="Behind #invite= in the page's address.")
    role: Role
    expires_utc_s: float


class JoinRequest(WireModel):
    """Account that is made by an invitation."""

    token: Annotated[str, Field(max_length=200)]
    name: AccountName
    password: Password


class PasswordRequest(WireModel):
    """Another password for one's own account."""

    old_password: Password
    new_password: Password


class SignInEntryModel(WireModel):
    """Entry of the log of sign-ins."""

    utc_s: float
    kind: SignInKind
    name: str = Field(description="Account, or what was given as one.")
    address: str
    detail: str
