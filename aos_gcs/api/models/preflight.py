"""Wire models of the preflight checks and their overrides."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.model.checks import CheckStatus


class OverrideModel(WireModel):
    """Decision to launch in spite of a failed check."""

    reason: str
    by: str = Field(description="The operator's name, or 'configuration'; empty when no name was given.")
    utc_s: float


class PreflightCheckModel(WireModel):
    """One cell of the matrix vehicle x check."""

    vehicle_id: int = Field(description="0: the mission as a whole.")
    name: str
    status: CheckStatus
    text: str = Field(description="Result of the check.")
    remedy: str = Field(description="Remedy; empty where the check passes.")
    overridable: bool = Field(description="Whether an operator may override it.")
    overridden: OverrideModel | None
    blocks: bool = Field(description="Whether it blocks the launch: failed, and not overridden.")


class OverrideRequest(WireModel):
    """Request to override a failed check, or to withdraw the override."""

    vehicle_id: Annotated[int, Field(strict=True, ge=0, le=255)]
    check: Annotated[str, Field(min_length=1, max_length=40)] = Field(description="The check's name.")
    reason: Annotated[str, Field(min_length=1, max_length=500)] | None = Field(
        description="Reason for the audit log; null withdraws an override."
    )
