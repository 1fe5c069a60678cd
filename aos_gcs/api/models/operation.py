"""Wire models of operations."""

from __future__ import annotations

from pydantic import Field

from aos_gcs.api.models.base import WireModel
from aos_gcs.mission.model.phase import Outcome


class SortieModel(WireModel):
    """One sortie of an operation."""

    mission_id: str
    number: int = Field(description="Number in its operation; the first one has 1.")
    folder: str = Field(description="Name of its folder, beside those of the other sorties.")
    start_utc_s: float
    duration_s: float = Field(description="Time from its start to its last recorded state.")
    outcome: Outcome = Field(description="open while it goes on, and when its program was killed.")
    steps: int
    covered_percent: float | None = Field(description="Share of its own search area that was in a frame.")
    findings: int = Field(description="Number of its own findings, without those of earlier sorties.")
    confirmed: int = Field(description="Number of these that operators have confirmed.")


class OperationModel(WireModel):
    """The operation that the shown mission belongs to."""

    sorties: list[SortieModel] = Field(description="In the order of their numbers; the shown mission is one of them.")
