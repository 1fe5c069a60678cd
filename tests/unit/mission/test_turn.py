"""The heading that a vehicle is told to turn to: waited for, but not for ever."""

from __future__ import annotations

import math

import pytest

from aos_gcs.mission.fleet.turn import SETTLE_S, TURN_S, Turn

SOUTH = math.pi


def is_over(turn: Turn, present_rad: float | None, now_s: float) -> bool:
    turn.look(present_rad, now_s)
    return turn.is_over(now_s)


def test_without_a_heading_nothing_is_waited_for() -> None:
    turn = Turn()
    turn.order(None, 1.0, 0.0)
    assert turn.heading_rad is None
    assert turn.is_over(0.0)


@pytest.mark.parametrize("heading_rad", [SOUTH, -SOUTH, SOUTH + math.tau])
def test_a_turn_is_over_when_the_heading_is_reached(heading_rad: float) -> None:
    turn = Turn()
    turn.order(heading_rad, 0.0, 0.0)
    assert not is_over(turn, 0.0, 0.1)
    assert not is_over(turn, SOUTH - math.radians(4.0), 2.0)
    assert not is_over(turn, SOUTH + math.radians(2.0), 3.0)
    assert is_over(turn, SOUTH + math.radians(2.0), 3.0 + SETTLE_S)


def test_asking_whether_a_turn_is_over_changes_nothing() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    turn.look(SOUTH, 3.0)
    assert [turn.is_over(now_s) for now_s in (3.0 + SETTLE_S, 3.0, 3.0 + SETTLE_S)] == [True, False, True]


def test_a_vehicle_that_turns_too_far_has_to_settle_again() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    assert not is_over(turn, SOUTH, 3.0)
    assert not is_over(turn, SOUTH + math.radians(6.0), 3.2)
    assert not is_over(turn, SOUTH, 3.0 + SETTLE_S)
    assert is_over(turn, SOUTH, 3.1 + 2 * SETTLE_S)


def test_a_heading_that_is_not_reported_is_waited_for_as_long_as_one_settles() -> None:
    turn = Turn()
    turn.order(SOUTH, None, 0.0)
    assert not is_over(turn, None, 3.0)
    assert is_over(turn, None, 3.0 + SETTLE_S)


def test_a_vehicle_that_does_not_turn_is_waited_for_once() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    assert not is_over(turn, 0.0, TURN_S - 0.1)
    assert is_over(turn, 0.0, TURN_S)
    turn.order(SOUTH, 0.0, TURN_S)
    assert is_over(turn, 0.0, TURN_S)


def test_a_vehicle_that_was_turned_away_once_is_waited_for_again_when_it_has_turned() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    turn.order(0.0, SOUTH, TURN_S)
    turn.order(SOUTH, SOUTH, 2 * TURN_S)  # a pilot's stick has turned it back
    assert turn.heading_rad == SOUTH
    assert turn.is_over(2 * TURN_S)
    turn.order(0.0, SOUTH, 3 * TURN_S)
    assert not turn.is_over(3 * TURN_S)


def test_a_vehicle_that_is_blown_off_or_interrupted_is_waited_for() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    turn.order(0.0, SOUTH - 0.3, TURN_S)
    assert not turn.is_over(TURN_S)
    turn.order(SOUTH, math.pi / 2 + 0.5, TURN_S + 1.0)
    assert not turn.is_over(TURN_S + 1.0), "it had no time to turn"
