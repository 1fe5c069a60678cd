"""Phases, suspension and outcome of a mission."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum


class Phase(StrEnum):
    """Where a mission is. ARCHITECTURE.md draws the transitions."""

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
    """How a mission has ended, or that it has not."""

    OPEN = "open"
    FOUND = "found"
    NOT_FOUND = "not_found"
    ABORTED = "aborted"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class OutcomeRecord:
    """How the mission has ended."""

    utc_s: float
    outcome: Outcome
    summary: Mapping[str, object]
    """The figures of the whole mission, such as the number of steps."""
