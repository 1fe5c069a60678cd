"""The tables of the mission's state machine."""

from __future__ import annotations

import itertools

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.phases import ACTIONS, ON_GROUND, TRANSITIONS, check_action, check_transition

FLYING = frozenset(Phase) - ON_GROUND - {Phase.ARM, Phase.RETURN, Phase.LAND}


def reachable(start: Phase) -> set[Phase]:
    seen, waiting = set(), [start]
    while waiting:
        phase = waiting.pop()
        if phase not in seen:
            seen.add(phase)
            waiting.extend(TRANSITIONS[phase])
    return seen


def test_the_tables_know_every_phase_and_every_action() -> None:
    assert set(TRANSITIONS) == set(Phase)
    assert set(ACTIONS) == set(Action)


def test_every_phase_is_reached_and_every_one_leads_to_the_end() -> None:
    assert reachable(Phase.CONNECT) == set(Phase)
    assert all(Phase.DONE in reachable(phase) for phase in Phase)


@pytest.mark.parametrize("phase", sorted(FLYING))
def test_from_the_air_the_only_ways_out_are_return_and_land(phase: Phase) -> None:
    assert {Phase.RETURN, Phase.LAND} <= TRANSITIONS[phase]
    assert not TRANSITIONS[phase] & ON_GROUND


@pytest.mark.parametrize("phase", sorted(FLYING | {Phase.RETURN, Phase.LAND}))
@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN, Action.LAND, Action.ABORT, Action.RESUME])
def test_what_keeps_the_swarm_safe_is_possible_in_every_flying_phase(phase: Phase, action: Action) -> None:
    check_action(phase, action)


@pytest.mark.parametrize("phase", sorted(Phase))
@pytest.mark.parametrize("action", [Action.HOLD, Action.RETURN, Action.LAND])
def test_who_flies_can_be_brought_down_in_every_phase(phase: Phase, action: Action) -> None:
    check_action(phase, action, anyone_flies=True)


def test_transitions_outside_the_table_are_defects() -> None:
    for current, following in itertools.product(Phase, Phase):
        if following in TRANSITIONS[current]:
            check_transition(current, following)
        else:
            with pytest.raises(RuntimeError, match=f"from {current} to {following}"):
                check_transition(current, following)


@pytest.mark.parametrize(
    ("phase", "action", "text"),
    [
        (Phase.PREFLIGHT, Action.START, "Cannot launch: preflight has not passed yet"),
        (Phase.DONE, Action.NOT_READY, "Cannot mark vehicles as not ready: the mission is over"),
        (Phase.SCAN, Action.START, "has started already"),
        (Phase.CONNECT, Action.OVERRIDE, "there are no checks yet"),
        (Phase.SCAN, Action.OVERRIDE, "has started already"),
        (Phase.READY, Action.LAND, "Cannot land: no vehicle is flying yet"),
        (Phase.TAKEOFF, Action.PAUSE, "Cannot pause in the phase Taking off"),
        (Phase.DONE, Action.RETURN, "the mission is over"),
        (Phase.DONE, Action.ABORT, "the mission is over"),
    ],
)
def test_refusals_say_why(phase: Phase, action: Action, text: str) -> None:
    with pytest.raises(MissionError, match=text):
        check_action(phase, action)
