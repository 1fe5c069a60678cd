"""Wire models of the proposals of others for the plan."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.api.models.plans import PlaceModel
from aos_gcs.mission.model.proposals import ProposalShape, ProposalUse


class ProposalModel(WireModel):
    """A mark or a drawing of somebody else, which is in no plan unless an operator takes it over."""

    proposal_id: int = Field(description="One whose content changes gets another number.")
    source: str = Field(description="System that it comes from, such as TAK.")
    name: str
    sender: str = Field(description="Call sign of the sender; empty where the mark names none.")
    kind: str = Field(description="Type in the terms of the other system.")
    shape: ProposalShape
    places: list[PlaceModel] = Field(description="Points; an area does not repeat the first one.")
    altitude_amsl_m: float | None = Field(description="Altitude of a point above mean sea level, where it is known.")
    remarks: str
    uses: list[ProposalUse] = Field(description="What it can be used for.")
    sent_utc_s: float = Field(description="Time at which it was made, by the sender's clock.")
    stale_utc_s: float = Field(description="Time from which it is out of date, by the sender's clock.")
    received_utc_s: float
    use: ProposalUse | None = Field(description="What an operator has made of it; null until somebody has decided.")
    operator: str = Field(description="Who has decided.")


class ProposalDecision(WireModel):
    """What an operator makes of a proposal; the plan is changed by other requests."""

    use: ProposalUse
