"""What operators ask for about findings."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from aos_gcs.api.models import WireModel
from aos_gcs.mission.model import FindingStatus

Comment = Annotated[str, Field(max_length=2000)]


class FindingRequest(WireModel):
    """A place that an operator marks."""

    latitude_deg: Annotated[float, Field(ge=-90.0, le=90.0, allow_inf_nan=False)]
    longitude_deg: Annotated[float, Field(ge=-180.0, le=180.0, allow_inf_nan=False)]
    comment: Comment = ""


class FindingChangeRequest(WireModel):
    """What an operator changes; what is left out, or null, stays."""

    status: FindingStatus | None = None
    comment: Comment | None = None
    assignee: Annotated[str, Field(max_length=100)] | None = None
