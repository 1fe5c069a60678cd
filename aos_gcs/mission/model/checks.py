"""Preflight checks and their overrides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class CheckStatus(StrEnum):
    """Status of a preflight check."""

    PASS = "pass"  # noqa: S105 - no password
    WARN = "warn"
    """Worth knowing; does not block the launch."""
    FAIL = "fail"
    """Blocks the launch, unless it is overridden."""


@dataclass(frozen=True, slots=True)
class CheckOverride:
    """The decision to launch in spite of a failed check."""

    reason: str
    by: str
    """The operator's name as given at sign-in, or ``configuration``; empty when no name was given."""
    utc_s: float


@dataclass(frozen=True, slots=True)
class PreflightCheck:
    """One cell of the matrix vehicle x check."""

    vehicle_id: int
    """0: the mission as a whole."""
    name: str
    status: CheckStatus
    text: str
    """Finding of the check."""
    remedy: str = ""
    """Action that would clear it; empty where the check passes."""
    overridable: bool = False
    """Whether the operator may launch in spite of a failure."""
    overridden: CheckOverride | None = None
    """Cleared as soon as something else is found."""

    @property
    def blocks(self) -> bool:
        """Whether the check blocks the launch."""
        return self.status is CheckStatus.FAIL and self.overridden is None

    def describe(self) -> str:
        """Return finding and remedy in one sentence without an end: ``vehicle 3, battery: 40 %; change it``."""
        subject = f"vehicle {self.vehicle_id}, {self.name}" if self.vehicle_id else self.name
        return f"{subject}: {self.text}; {self.remedy}" if self.remedy else f"{subject}: {self.text}"
