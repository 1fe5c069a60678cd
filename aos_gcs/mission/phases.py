"""The mission's state machine as tables: which phase may follow which, and which actions each allows."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import ACTION_NAMES, Action
from aos_gcs.mission.model.phase import Phase

PHASE_NAMES: Mapping[Phase, str] = MappingProxyType(
    {
        Phase.CONNECT: "Connecting",
        Phase.PREFLIGHT: "Preflight",
        Phase.READY: "Ready",
        Phase.ARM: "Arming",
        Phase.TAKEOFF: "Taking off",
        Phase.LINE: "Forming line",
        Phase.SCAN: "Scanning",
        Phase.CONVERGE: "Converging",
        Phase.FOUND: "Found",
        Phase.RETURN: "Returning",
        Phase.LAND: "Landing",
        Phase.DONE: "Finished",
    }
)
"""Names for operators; the dashboard uses the same."""

ENDING = frozenset({Phase.RETURN, Phase.LAND})
"""Phases that bring the vehicles down."""

TRANSITIONS: Mapping[Phase, frozenset[Phase]] = MappingProxyType(
    {
        Phase.CONNECT: frozenset({Phase.CONNECT, Phase.PREFLIGHT, Phase.TAKEOFF, Phase.DONE}),
        Phase.PREFLIGHT: frozenset({Phase.CONNECT, Phase.READY, Phase.TAKEOFF, Phase.DONE}),
        Phase.READY: frozenset({Phase.CONNECT, Phase.ARM, Phase.PREFLIGHT, Phase.DONE}),
        Phase.ARM: frozenset({Phase.TAKEOFF, Phase.DONE}) | ENDING,
        Phase.TAKEOFF: frozenset({Phase.LINE}) | ENDING,
        Phase.LINE: frozenset({Phase.SCAN}) | ENDING,
        Phase.SCAN: frozenset({Phase.CONVERGE, Phase.FOUND, Phase.LINE}) | ENDING,
        Phase.CONVERGE: frozenset({Phase.SCAN, Phase.FOUND, Phase.LINE}) | ENDING,
        Phase.FOUND: frozenset({Phase.CONVERGE, Phase.LINE}) | ENDING,
        Phase.RETURN: frozenset({Phase.LAND}),
        Phase.LAND: frozenset({Phase.DONE, Phase.RETURN}),
        Phase.DONE: frozenset(),
    }
)
"""DONE is also reached from every phase when all vehicles are lost, CONNECT when a plan is applied, and TAKEOFF without
a launch when a former flight is taken up; see ``Coordinator``."""

BEFORE_START = frozenset({Phase.CONNECT, Phase.PREFLIGHT, Phase.READY})
"""Phases in which the plan can still be changed."""

ON_GROUND = BEFORE_START | {Phase.DONE}
"""Phases in which the mission has started no motor."""

SAMPLING = frozenset({Phase.SCAN, Phase.CONVERGE, Phase.FOUND})
"""Phases made of steps."""

_STARTED = frozenset(Phase) - ON_GROUND

ACTIONS: Mapping[Action, frozenset[Phase]] = MappingProxyType(
    {
        Action.CHOOSE: BEFORE_START,
        Action.START: frozenset({Phase.READY}),
        Action.PAUSE: SAMPLING | {Phase.LINE},
        Action.RESUME: _STARTED,
        Action.HOLD: frozenset(Phase),
        Action.RETURN: _STARTED,
        Action.LAND: _STARTED,
        Action.ABORT: frozenset(Phase) - {Phase.DONE},
        Action.FOCUS: frozenset(Phase) - ENDING - {Phase.DONE},
        Action.JOIN: SAMPLING | {Phase.LINE},
        Action.READY: frozenset(Phase) - ENDING - {Phase.DONE},
        Action.NOT_READY: frozenset(Phase) - ENDING - {Phase.DONE},
        Action.OVERRIDE: frozenset({Phase.PREFLIGHT, Phase.READY}),
        Action.NEW_SORTIE: frozenset({Phase.DONE}),
    }
)


_DOWN = frozenset({Action.RETURN, Action.LAND})
_CONFIRMATIONS = frozenset({Action.READY, Action.NOT_READY})


def is_allowed(phase: Phase, action: Action, *, anyone_flies: bool) -> bool:
    """Return whether ``action`` makes sense in ``phase``.

    Vehicles may fly before the start, such as after a restart of the station in mid-mission, and after the end: they
    can always be brought down. A new sortie waits until they are.
    """
    if action is Action.NEW_SORTIE and anyone_flies:
        return False
    return phase in ACTIONS[action] or (anyone_flies and action in _DOWN and phase in ON_GROUND)


def check_transition(current: Phase, following: Phase) -> None:
    """Raise ``RuntimeError`` for a transition that the table does not have: a defect of the caller, not of a user."""
    if following not in TRANSITIONS[current]:
        raise RuntimeError(f"no transition from {current} to {following}")


def check_action(phase: Phase, action: Action, *, anyone_flies: bool = False) -> None:
    """Raise ``MissionError`` with the reason when ``action`` makes no sense in ``phase``."""
    if is_allowed(phase, action, anyone_flies=anyone_flies):
        return
    if action is Action.NEW_SORTIE:
        reason = "a vehicle still flies" if phase is Phase.DONE else "the mission is not over"
        raise MissionError(f"Cannot begin a new sortie: {reason}.")
    if phase is Phase.DONE:
        raise MissionError(f"Cannot {ACTION_NAMES[action]}: the mission is over.")
    if action is Action.OVERRIDE:
        reason = "there are no checks yet" if phase is Phase.CONNECT else "the mission has started already"
        raise MissionError(f"Cannot override a check: {reason}.")
    if action is Action.CHOOSE:
        raise MissionError("The vehicles can no longer be changed: the mission has started.")
    if action is Action.START:
        reason = "preflight has not passed yet" if phase in ON_GROUND else "the mission has started already"
        raise MissionError(f"Cannot launch: {reason}.")
    if action in _CONFIRMATIONS:
        raise MissionError(f"Cannot confirm vehicles for the relay in the phase {PHASE_NAMES[phase]}.")
    if phase in ON_GROUND:
        reason = "the mission has not started" if anyone_flies else "no vehicle is flying yet"
        raise MissionError(f"Cannot {ACTION_NAMES[action]}: {reason}.")
    raise MissionError(f"Cannot {ACTION_NAMES[action]} in the phase {PHASE_NAMES[phase]}.")
