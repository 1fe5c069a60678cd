"""Conversion of the proposals of others for the plan."""

from __future__ import annotations

from aos_gcs.api.convert.places import rounded
from aos_gcs.api.models.plans import PlaceModel
from aos_gcs.api.models.proposals import ProposalModel
from aos_gcs.mission.model.proposals import ProposalRecord, ProposalUse


def proposal(record: ProposalRecord) -> ProposalModel:
    """Convert a proposal with what was decided about it."""
    one = record.proposal
    return ProposalModel(
        proposal_id=record.proposal_id,
        source=one.source,
        name=one.name,
        sender=one.sender,
        kind=one.kind,
        shape=one.shape,
        places=[PlaceModel(latitude_deg=latitude, longitude_deg=longitude) for latitude, longitude in one.points_deg],
        altitude_amsl_m=rounded(one.altitude_amsl_m, 1),
        remarks=one.remarks,
        uses=[use for use in ProposalUse if one.allows(use)],
        sent_utc_s=one.sent_utc_s,
        stale_utc_s=one.stale_utc_s,
        received_utc_s=one.received_utc_s,
        use=record.use,
        operator=record.operator,
    )
