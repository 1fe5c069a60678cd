"""Holds and pauses of split swarms, in virtual time: both groups stop, and nobody scans on unseen."""

from __future__ import annotations

import pytest

from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.decisions import Group
from aos_gcs.mission.model.phase import Outcome, Phase
from tests.fakes.mission_flight import flying
from tests.fakes.split_flight import is_catching_up, is_scanned_on, split_flight, stand_still, steps_of, vehicles_of

virtual = pytest.mark.virtual


@virtual
async def test_who_is_held_while_catching_up_goes_on_in_one_line() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_catching_up(flight))
        await flight.commands.act(Action.HOLD, None)
        await stand_still(flight, flight.fleet.members, 10.0)
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_a_pause_while_catching_up_stops_those_who_scan() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_catching_up(flight))
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(2.0)
        await stand_still(flight, vehicles_of(flight, Group.SCAN), 2.0)
        await flight.commands.act(Action.ABORT, None)
        await run


@virtual
async def test_a_hold_stops_both_groups_and_resumed_the_look_goes_on() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        await flight.commands.act(Action.HOLD, None)
        await stand_still(flight, flight.fleet.members, 20.0)
        looks = len(steps_of(flight, Group.LOOK))
        await flight.commands.act(Action.RESUME, None)
        await flight.until(lambda: len(steps_of(flight, Group.LOOK)) > looks)
        assert await run is Outcome.FOUND
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_a_pause_lets_nobody_scan_on_unseen() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(6.0)
        await stand_still(flight, flight.fleet.members, 15.0)
        await flight.commands.act(Action.RESUME, None)
        assert await run is Outcome.FOUND
    assert flight.view.snapshot().covered_fraction == 1.0


@virtual
async def test_a_pause_between_two_phases_of_the_look_stops_those_who_scan() -> None:
    flight = split_flight()
    make_step = flight.mission.sortie.handlers[Phase.CONVERGE]
    paused = list[Phase]()

    async def pause_behind() -> Phase:
        following = await make_step()
        if following is Phase.FOUND and not paused:
            paused.append(following)
            await flight.commands.act(Action.PAUSE, None)
        return following

    object.__setattr__(
        flight.mission.sortie, "handlers", flight.mission.sortie.handlers | {Phase.CONVERGE: pause_behind}
    )
    async with flying(flight) as run:
        await flight.until(lambda: bool(paused))
        await flight.clock.sleep(6.0)
        await stand_still(flight, flight.fleet.members, 10.0)
        await flight.commands.act(Action.ABORT, None)
        await run


@virtual
async def test_a_pause_lets_the_look_end_its_step_and_stops_those_who_scan_with_it() -> None:
    flight = split_flight()
    sortie, ends = flight.mission.sortie, list[tuple[Phase, bool]]()
    make_step = sortie.handlers[Phase.CONVERGE]

    async def make_step_noted() -> Phase:
        following = await make_step()
        ends.append((following, sortie.search.flies_on))
        return following

    object.__setattr__(sortie, "handlers", sortie.handlers | {Phase.CONVERGE: make_step_noted})
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        ends.clear()
        await flight.commands.act(Action.PAUSE, None)
        await flight.until(lambda: bool(ends))
        assert ends == [(Phase.FOUND, False)]
        await flight.commands.act(Action.RESUME, None)
        looks = len(steps_of(flight, Group.LOOK))
        await flight.until(lambda: len(steps_of(flight, Group.LOOK)) > looks)
        await flight.commands.act(Action.PAUSE, None)
        await flight.clock.sleep(5.0)
        assert len(steps_of(flight, Group.LOOK)) <= looks + 2
        await flight.commands.act(Action.ABORT, None)
        await run


@virtual
async def test_a_vehicle_that_scans_and_is_paused_alone_stops_at_once() -> None:
    flight = split_flight()
    async with flying(flight) as run:
        await flight.until(lambda: is_scanned_on(flight))
        chosen = min(vehicles_of(flight, Group.SCAN))
        await flight.commands.act(Action.PAUSE, (chosen,))
        await stand_still(flight, (chosen,), 5.0)
        await flight.commands.act(Action.ABORT, None)
        await run
