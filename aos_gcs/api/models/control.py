"""Wire models of who has control."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StrictBool

from aos_gcs.api.access.control import MAX_REASON
from aos_gcs.api.models.base import WireModel


class ControlModel(WireModel):
    """Operators, and who of them has control: commands of the others are refused, except for holds."""

    holder: str | None = Field(description="Null while nobody has commanded: the first who does has control.")
    holder_present: bool = Field(description="Whether a page of theirs is connected, or was a moment ago.")
    operators: list[str] = Field(description="Operators who are present.")
    requests: list[str] = Field(description="Operators who ask for control, the first first.")


class ControlAnswer(WireModel):
    """Answer to an operator who asks for control."""

    operator: Annotated[str, Field(max_length=40)]
    granted: StrictBool


class TakeControlRequest(WireModel):
    """Taking control over."""

    reason: Annotated[str, Field(max_length=MAX_REASON)] = Field(
        "", description="For the audit log; needed while the one who has control is present."
    )
