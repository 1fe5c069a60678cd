"""Wire models of notices and their acknowledgements."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.ports import Severity


class NoticeModel(WireModel):
    """A notice for the operator."""

    severity: Severity
    notice_id: int = Field(
        description="Counts from 1 in a mission; a number that is skipped is a notice that was lost."
    )
    text: str
    vehicle_id: int | None
    track_id: int | None = Field(description="Track of the target, and of the finding, that it is about.")
    elapsed_s: float
    utc_s: float


class AcknowledgementModel(WireModel):
    """Acknowledgement of a notice, and of earlier ones with the same text about the same vehicle."""

    notice_id: int
    operator: str = Field(description="Name given at sign-in; empty when none was given.")
    utc_s: float


class AcknowledgeRequest(WireModel):
    """Notices that an operator acknowledges."""

    notice_ids: Annotated[list[Annotated[int, Field(strict=True, ge=1)]], Field(min_length=1, max_length=200)]
