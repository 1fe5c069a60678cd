"""Operators' actions and their results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType


class Action(StrEnum):
    """Action that an operator can request."""

    CHOOSE = "choose"
    """Decide which vehicles fly the mission; no other is armed."""
    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    HOLD = "hold"
    RETURN = "return"
    LAND = "land"
    ABORT = "abort"
    FOCUS = "focus"
    """Focus on a height that the operator gives, or leave it to autofocus again."""
    JOIN = "join"
    """Have vehicles on the ground take off and join the swarm in mid-mission."""
    READY = "ready"
    """Confirm that vehicles on the ground may take off for the relay, once: new battery, nobody near."""
    NOT_READY = "not_ready"
    """Take that back."""
    OVERRIDE = "override"
    """Launch in spite of a failed check of preflight, or take that back; see ``MissionCommands.override_check``."""
    NEW_SORTIE = "new_sortie"
    """End this mission's record and prepare another sortie, on the same page and with the same findings."""


ACTION_NAMES: Mapping[Action, str] = MappingProxyType(
    {
        Action.CHOOSE: "choose vehicles",
        Action.START: "launch",
        Action.PAUSE: "pause",
        Action.RESUME: "resume",
        Action.HOLD: "hold",
        Action.RETURN: "return",
        Action.LAND: "land",
        Action.ABORT: "abort",
        Action.FOCUS: "set the focal plane",
        Action.JOIN: "join",
        Action.READY: "confirm vehicles as ready",
        Action.NOT_READY: "mark vehicles as not ready",
        Action.OVERRIDE: "override a check",
        Action.NEW_SORTIE: "begin a new sortie",
    }
)
"""Names for operators, as verbs."""


@dataclass(frozen=True, slots=True)
class Seen:
    """State of the mission that an operator saw when giving a command."""

    mission_id: str
    command_count: int
    """Number of the latest command carried out in that state."""
    at_s: float
    """Time at which the mission reported that state, in real seconds of a clock that this machine's processes share."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """Reason why something that was asked of a vehicle is not done."""

    text: str


@dataclass(frozen=True, slots=True)
class ActionResult:
    """Result of an action for one vehicle."""

    vehicle_id: int
    accepted: bool
    text: str
    """Sentence that says what the vehicle does now, or why it does not."""


@dataclass(frozen=True, slots=True)
class ActionRecord:
    """An operator's action: one entry of the audit log."""

    utc_s: float
    action: Action
    vehicle_ids: tuple[int, ...] | None
    """None for the whole mission."""
    results: tuple[ActionResult, ...]
    refusal: str | None = None
    """Why the mission did not take the action; None if it did."""
    focal_height_m: float | None = None
    """Height requested by an action of focusing; None leaves the height to autofocus."""
    operator: str = ""
    """Operator's name as given at sign-in; empty when no person has requested it."""
    check: str | None = None
    """The check that an override concerns."""
    reason: str | None = None
    """Why a check was overridden; None where an override was taken back."""
