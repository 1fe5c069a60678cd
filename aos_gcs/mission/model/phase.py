"""Phases, suspension and outcome of a mission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class Phase(StrEnum):
    """Phase of a mission. ARCHITECTURE.md draws the transitions."""

    CONNECT = "connect"
    PREFLIGHT = "preflight"
    READY = "ready"
    """Preflight has passed; waits for the operator's start."""
    ARM = "arm"
    TAKEOFF = "takeoff"
    LINE = "line"
    SCAN = "scan"
    CONVERGE = "converge"
    FOUND = "found"
    RETURN = "return"
    LAND = "land"
    DONE = "done"


class Suspension(StrEnum):
    """Why a flying mission makes no steps at present."""

    NONE = "none"
    PAUSED = "paused"
    """The step in hand was finished; the vehicles hover at their waypoints."""
    HELD = "held"
    """All vehicles were stopped where they were."""


class Outcome(StrEnum):
    """Result of a mission, or that it has not ended."""

    OPEN = "open"
    FOUND = "found"
    NOT_FOUND = "not_found"
    ABORTED = "aborted"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class OutcomeRecord:
    """Record of the mission's end."""

    utc_s: float
    outcome: Outcome
    summary: Mapping[str, object]
    """The figures of the whole mission, such as the number of steps."""
