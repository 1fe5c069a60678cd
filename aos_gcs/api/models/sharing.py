"""Wire model of live sharing."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.model.sharing import ChannelState


class ChannelModel(WireModel):
    """A system that data is shared with."""

    name: str
    target: str = Field(description="Address without anything secret.")
    state: ChannelState
    text: str = Field(description="What is so and what to do, without a full stop.")
    sent: int = Field(description="Messages sent so far.")
    lost: int = Field(description="Messages that were given up.")
    sent_utc_s: float | None = Field(description="Time of the latest message sent; null before the first.")
    received: int = Field(description="Marks and drawings of others that came as proposals for the plan.")
    refused: int = Field(description="Messages of others that could not be used.")
    refused_text: str = Field(description="Reason of the latest of these, without a full stop.")
