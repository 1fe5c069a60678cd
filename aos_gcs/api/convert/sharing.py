"""Conversion of the states of live sharing."""

from __future__ import annotations

from aos_gcs.api.convert.places import rounded
from aos_gcs.api.models.sharing import ChannelModel
from aos_gcs.mission.model.sharing import ChannelStatus


def channel(status: ChannelStatus) -> ChannelModel:
    """Convert the state of one system."""
    return ChannelModel(
        name=status.name,
        target=status.target,
        state=status.state,
        text=status.text,
        sent=status.sent,
        lost=status.lost,
        sent_utc_s=rounded(status.sent_utc_s, 0),
        received=status.received,
        refused=status.refused,
        refused_text=status.refused_text,
    )
