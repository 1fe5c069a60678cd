"""The heading that a vehicle is told to turn to: waited for, but not for ever."""

from __future__ import annotations

import math

import pytest

from aos_gcs.mission.fleet.turn import SETTLE_S, TURN_S, Turn

SOUTH = math.pi


def test_without_a_heading_nothing_is_waited_for() -> None:
    turn = Turn()
    turn.order(None, 1.0, 0.0)
    assert turn.heading_rad is None
    assert turn.is_over(1.0, 0.0)


@pytest.mark.parametrize("heading_rad", [SOUTH, -SOUTH, SOUTH + math.tau])
def test_a_turn_is_over_when_the_heading_is_reached(heading_rad: float) -> None:
    turn = Turn()
    turn.order(heading_rad, 0.0, 0.0)
    assert not turn.is_over(0.0, 0.1)
    assert not turn.is_over(SOUTH - math.radians(4.0), 2.0)
    assert not turn.is_over(SOUTH + math.radians(2.0), 3.0)
    assert turn.is_over(SOUTH + math.radians(2.0), 3.0 + SETTLE_S)


def test_a_vehicle_that_turns_too_far_has_to_settle_again() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    assert not turn.is_over(SOUTH, 3.0)
    assert not turn.is_over(SOUTH + math.radians(6.0), 3.2)
    assert not turn.is_over(SOUTH, 3.0 + SETTLE_S)
    assert turn.is_over(SOUTH, 3.1 + 2 * SETTLE_S)


def test_a_heading_that_is_not_reported_is_waited_for_as_long_as_one_settles() -> None:
    turn = Turn()
    turn.order(SOUTH, None, 0.0)
    assert not turn.is_over(None, 3.0)
    assert turn.is_over(None, 3.0 + SETTLE_S)


def test_a_vehicle_that_does_not_turn_is_waited_for_once_and_not_asked_again() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    assert turn.is_over(0.0, TURN_S)
    turn.order(SOUTH, 0.0, TURN_S)
    assert turn.heading_rad is None
    assert turn.is_over(0.0, TURN_S)


def test_a_vehicle_that_is_blown_off_or_interrupted_is_asked_again() -> None:
    turn = Turn()
    turn.order(SOUTH, 0.0, 0.0)
    turn.order(0.0, SOUTH - 0.3, TURN_S)
    assert turn.heading_rad == 0.0
    turn.order(SOUTH, math.pi / 2 + 0.5, TURN_S + 1.0)
    assert turn.heading_rad == SOUTH, "it had no time to turn"
