"""Wire models of the service itself: sign-in, capabilities, base map."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.access.roles import Role
from aos_gcs.api.models.base import WireModel


class SessionModel(WireModel):
    """Role of this client."""

    role: Role
    name: str = Field(description="Name given at sign-in, or of the account; empty for those who have not signed in.")
    sign_in_required: bool = Field(description="False where every client is an operator.")
    accounts: bool = Field(description="Whether everybody signs in with an account; else operators with the code.")


class SignInRequest(WireModel):
    """Operator code and the name of the operator, or name and password of an account."""

    code: Annotated[str, Field(max_length=200)] | None = None
    password: Annotated[str, Field(max_length=200)] | None = None
    name: Annotated[str, Field(min_length=1, max_length=40, pattern=r"^\S(.*\S)?$")] = Field(
        description="Name of the operator, for the audit log; or of the account."
    )


class CapabilitiesModel(WireModel):
    """Functions that this service offers beside the mission itself; requests for others are refused."""

    planning: bool = Field(description="The plan can be read and changed.")
    viewer: bool = Field(description="Recorded steps can be seen again; findings have pictures.")
    findings: bool = Field(description="Findings can be marked and judged.")
    operation: bool = Field(description="The sorties of the operation can be listed.")
    survey: bool = Field(description="A recorded flight is shown: there are no vehicles to watch or to command.")
    handover: bool = Field(description="The mission can be handed over as a PDF.")
    wall: bool = Field(description="Live pictures of the cameras can be watched.")
    video: bool = Field(description="Videos of them can be made.")


class BasemapModel(WireModel):
    """Base map below the mission."""

    url: str | None = Field(description="URL of a PMTiles file; null where there is none.")
