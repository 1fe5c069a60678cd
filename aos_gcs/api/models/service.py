"""Wire models of the service itself: sign-in, capabilities, base map."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.access.operators import Role
from aos_gcs.api.models.base import WireModel


class SessionModel(WireModel):
    """What this client may do."""

    role: Role
    name: str = Field(description="As given at sign-in; empty for observers.")
    sign_in_required: bool = Field(description="False where everybody commands.")


class SignInRequest(WireModel):
    """The operators' code, and who it is that signs in."""

    code: Annotated[str, Field(max_length=200)]
    name: Annotated[str, Field(min_length=1, max_length=40, pattern=r"^\S(.*\S)?$")] = Field(
        description="For the audit log."
    )


class CapabilitiesModel(WireModel):
    """What this service offers beside the mission itself; requests for the rest are refused."""

    planning: bool = Field(description="The plan can be read and changed.")
    viewer: bool = Field(description="Recorded steps can be seen again; findings have pictures.")
    findings: bool = Field(description="Findings can be marked and judged.")


class BasemapModel(WireModel):
    """The map of the ground below everything that flies."""

    url: str | None = Field(description="Of a PMTiles file; null where there is none.")
