"""Commands that a stalled network delivers late, or after a newer one, are refused; a hold never is."""

from __future__ import annotations

import math

import pytest

from aos_gcs.api.convert.seen import parse_seen, seen_text
from aos_gcs.errors import InputDataError
from aos_gcs.mission.command_order import MAX_AGE_S, CommandOrder, OutdatedError
from aos_gcs.mission.model.actions import Action, Seen


class Station:
    """An order of commands, and what an operator sees of it."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.order = CommandOrder("m-1", lambda: self.now_s)

    def seen(self) -> Seen:
        return Seen("m-1", self.order.count, self.now_s)


@pytest.fixture
def station() -> Station:
    return Station()


def test_a_command_expires_and_a_hold_does_not(station: Station) -> None:
    seen = station.seen()
    station.now_s += MAX_AGE_S
    station.order.check(seen, Action.START)
    station.now_s += 0.1
    for action in set(Action) - {Action.HOLD}:
        with pytest.raises(OutdatedError, match=r"2\.1 s old.*Check the vehicles"):
            station.order.check(seen, action)
    station.order.check(seen, Action.HOLD)


def test_nothing_that_is_older_undoes_a_hold(station: Station) -> None:
    before = station.seen()
    station.order.note(Action.HOLD, None, "Robin")
    for action in (Action.RESUME, Action.START, Action.RETURN, Action.LAND, Action.ABORT, Action.JOIN):
        for vehicle_ids in (None, (3,)):
            with pytest.raises(OutdatedError, match="Robin sent hold meanwhile"):
                station.order.check(before, action, vehicle_ids)
    station.order.check(before, Action.HOLD)
    station.order.check(station.seen(), Action.RESUME)


@pytest.mark.parametrize(
    ("command", "words"),
    [(Action.NEW_SORTIE, "Ada sent begin a new sortie meanwhile"), ("another plan", "Ada sent another plan meanwhile")],
)
def test_what_came_meanwhile_is_named_in_words(station: Station, command: Action | str, words: str) -> None:
    before = station.seen()
    station.order.note(command, None, "Ada")
    with pytest.raises(OutdatedError, match=words):
        station.order.check(before, Action.RESUME)


def test_commands_for_other_vehicles_do_not_overtake_each_other(station: Station) -> None:
    before = station.seen()
    station.order.note(Action.LAND, (3, 4), "")
    station.order.check(before, Action.RETURN, (5,))
    with pytest.raises(OutdatedError, match="an operator sent land meanwhile"):
        station.order.check(before, Action.RETURN, (4, 5))
    with pytest.raises(OutdatedError):
        station.order.check(before, Action.RESUME)


def test_the_focal_plane_moves_no_vehicle(station: Station) -> None:
    before = station.seen()
    station.order.note(Action.FOCUS, None, "")
    station.order.check(before, Action.RESUME)
    station.order.note(Action.HOLD, None, "")
    station.order.check(before, Action.FOCUS)


def test_a_command_belongs_to_one_mission(station: Station) -> None:
    with pytest.raises(OutdatedError, match="meant for the mission m-0"):
        station.order.check(Seen("m-0", 0, station.now_s), Action.START)


def test_a_state_comes_back_from_its_name() -> None:
    seen = Seen("20261122-101500 Fußweg/ä", 12, 86400.125)
    text = seen_text(seen)
    assert text.isascii()
    assert parse_seen(text) == seen


@pytest.mark.parametrize(
    "text", ["", "m-1", "m-1/1", "m-1/1/x", "m-1/-1/5", "m-1/1/5/7", "m-1/1/" + 20 * "9", "a b/1/5"]
)
def test_no_other_text_names_a_state(text: str) -> None:
    with pytest.raises(InputDataError, match="X-Seen"):
        parse_seen(text)


def test_a_clock_of_another_machine_is_no_newer_state(station: Station) -> None:
    for at_s in (station.now_s + 60.0, math.inf):
        with pytest.raises(OutdatedError):
            station.order.check(Seen("m-1", 0, at_s), Action.START)
