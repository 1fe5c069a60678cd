"""Operations: missions that follow each other over the same area."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.mission.model.phase import Outcome


@dataclass(frozen=True, slots=True)
class SortieRecord:
    """One sortie of an operation, as its record tells."""

    mission_id: str
    number: int
    """Number in its operation; the first one has 1."""
    folder: str
    """Name of its folder, beside those of the other sorties."""
    start_utc_s: float
    duration_s: float
    """Clock seconds from its start action to its last recorded state."""
    outcome: Outcome
    """``OPEN`` while it goes on, and when its program was killed."""
    steps: int
    covered_fraction: float | None
    """Share of its own search area that was in a frame; None before the first step."""
    findings: int
    """Number of its own findings, without those of earlier sorties."""
    confirmed: int
    """Number of these that operators have confirmed."""
