"""What the store keeps beyond the mission's own model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from aos_gcs.mission.model import Action, ActionResult, Outcome


@dataclass(frozen=True, slots=True)
class ActionRecord:
    """An operator's action: one entry of the audit log."""

    utc_s: float
    action: Action
    vehicle_ids: tuple[int, ...] | None
    """None for the whole mission."""
    results: tuple[ActionResult, ...]


@dataclass(frozen=True, slots=True)
class OutcomeRecord:
    """How the mission has ended."""

    utc_s: float
    outcome: Outcome
    summary: Mapping[str, object]
    """The figures of the whole mission, such as ``target_error_m``."""
