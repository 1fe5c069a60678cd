"""Conversion of who has control."""

from __future__ import annotations

from aos_gcs.api.access.control import ControlState
from aos_gcs.api.models.control import ControlModel


def control(state: ControlState) -> ControlModel:
    """Convert who has control."""
    return ControlModel(
        holder=state.holder,
        holder_present=state.is_holder_present,
        operators=list(state.operators),
        requests=list(state.requests),
    )
