"""Missions of the campaign that have every fault, and whether the campaign would see what it looks for."""

from __future__ import annotations

import asyncio
import logging
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.mission.model.actions import Action
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.runtime.simulated.virtual_time import run
from aos_sim.vehicle.arducopter import CopterMode
from aos_sim.vehicle.flight import Manoeuvre
from tests.campaign import runner
from tests.campaign.airspace import TRACKING_M, AirspaceWatch
from tests.campaign.faults import FAULTS, KNOWN_DEFECTS
from tests.campaign.faults.base import Fault
from tests.campaign.faults.people import OperatorActs, PilotHovers
from tests.campaign.faults.sensors import HeightReset, HeightRunsAway
from tests.campaign.faults.station import Kill
from tests.campaign.flight import FlightVerdict, fly
from tests.campaign.oracle import PILOT_GRACE_S, Oracle
from tests.campaign.runner import describe
from tests.campaign.scenario import Scenario, draw
from tests.campaign.shrink import shrink
from tests.campaign.world import World
from tests.fakes.air import FIRST_PORT, HOST


def covering(seeds: range, count: int) -> list[int]:
    """Return some of the seeds, whose missions have every fault, every autopilot with every error of positions, both
    kinds of areas in both modes, and a split swarm.
    """
    drawn = {seed: draw(seed) for seed in seeds}
    parts = {
        seed: {
            (one.autopilot, one.errors),
            (one.mode, one.is_long),
            one.splits,
            *(type(fault).__name__ for fault in one.faults),
        }
        for seed, one in drawn.items()
    }
    left, chosen = set().union(*parts.values()), []
    while left:
        chosen.append(max(parts, key=lambda seed: len(parts[seed] & left)))
        left -= parts[chosen[-1]]
    # Long ones take twice as long as others.
    others = [seed for seed in seeds if seed not in chosen and not drawn[seed].is_long]
    return chosen + others[: count - len(chosen)]


SEEDS = covering(range(1, 101), 20)
BESIDE_A_PILOT = Scenario(
    72255,
    "arducopter",
    2,
    "rtk",
    2.7,
    upload_fence=True,
    faults=(PilotHovers(35.0, 2, CopterMode.BRAKE, 33.5),),
    mode=SearchMode.CONTINUOUS,
    is_long=True,
    zones_enu_m=(((5.1, 20.3), (9.4, 20.3), (9.4, 25.7), (5.1, 25.7)),),
)
BELOW_A_GRANTED_WAY = Scenario(
    73213,
    "px4",
    4,
    "rtk",
    2.6,
    upload_fence=False,
    faults=(HeightRunsAway(1.9, 2, -0.1, 14.4),),
    is_long=True,
    stops_at_first=False,
    zones_enu_m=(((-1.7, 15.9), (6.8, 15.9), (6.8, 19.5), (-1.7, 19.5)),),
)
BESIDE_ZONES = [
    Scenario(
        seed,
        "px4",
        6,
        errors,
        spacing_m,
        upload_fence=False,
        faults=(),
        mode=SearchMode.CONTINUOUS,
        is_long=True,
        stops_at_first=False,
        zones_enu_m=(zone,),
        splits=True,
    )
    for seed, errors, spacing_m, zone in (
        (910259, "rtk", 2.9, ((-3.1, 56.0), (4.4, 56.0), (4.4, 58.7), (-3.1, 58.7))),
        (910313, "none", 3.0, ((1.3, 46.4), (6.9, 46.4), (6.9, 50.7), (1.3, 50.7))),
    )
]
CALM = Scenario(0, "arducopter", 2, "none", 2.5, upload_fence=False, faults=())


@cache
def flown(seed: int) -> FlightVerdict:
    return fly(draw(seed))


@pytest.mark.parametrize("seed", SEEDS)
def test_a_random_mission_with_random_faults_ends_safely(seed: int) -> None:
    verdict = flown(seed)
    assert not verdict.violations, describe(verdict)
    assert not verdict.refused, describe(verdict)


@pytest.mark.parametrize("scenario", [BESIDE_A_PILOT, BELOW_A_GRANTED_WAY], ids=lambda scenario: str(scenario.seed))
def test_a_mission_in_which_two_vehicles_came_too_close_ends_safely(scenario: Scenario) -> None:
    verdict = fly(scenario)
    assert not verdict.violations, describe(verdict)
    assert not verdict.refused, describe(verdict)


@pytest.mark.slow  # a unit test of vetting has the same turns
@pytest.mark.parametrize("scenario", BESIDE_ZONES, ids=lambda scenario: str(scenario.seed))
def test_a_line_that_forms_anew_in_flight_keeps_the_margins_of_zones(scenario: Scenario) -> None:
    verdict = fly(scenario)
    assert not verdict.violations, describe(verdict)
    assert not verdict.refused, describe(verdict)


def test_a_seed_repeats_its_mission_exactly() -> None:
    first, again = flown(SEEDS[0]), fly(draw(SEEDS[0]))
    assert (first.smallest_m, first.duration_s, first.trace) == (again.smallest_m, again.duration_s, again.trace)


@pytest.mark.parametrize(("refused", "status"), [("preflight", 1), ("", 0)])
def test_a_campaign_that_launches_nothing_fails(monkeypatch: pytest.MonkeyPatch, refused: str, status: int) -> None:
    monkeypatch.setattr(runner, "fly", lambda scenario: FlightVerdict(scenario, (), refused, "found"))
    monkeypatch.setattr(runner, "_be_quiet", lambda: None)
    in_this_process = SimpleNamespace(Pool=lambda *_, **__: nullcontext(SimpleNamespace(imap_unordered=map)))
    monkeypatch.setattr("multiprocessing.get_context", lambda _: in_this_process)
    assert runner.repeat(1, is_shrunk=False) == status
    assert runner.fly_all(range(1, 4), 2, is_shrunk=False) == status


def test_every_fault_is_drawn_unless_a_reason_is_given() -> None:
    drawn = {type(fault) for seed in SEEDS for fault in draw(seed).faults}
    assert drawn == set(FAULTS) - set(KNOWN_DEFECTS)
    assert all(KNOWN_DEFECTS.values())


def test_a_station_that_is_killed_leaves_no_outcome_and_the_next_one_takes_the_flight_up() -> None:
    verdict = fly(replace(CALM, faults=(Kill(10.0, restart_after_s=1.0),)))
    assert not verdict.violations, describe(verdict)
    assert any("taken up in the air" in line for line in verdict.trace)


def test_a_pilot_whose_mode_a_command_ends_before_a_heartbeat_shows_it_chooses_it_again() -> None:
    pilot, order = PilotHovers(10.5, 1, CopterMode.POSHOLD, 20.0), OperatorActs(10.6, Action.LAND, None)
    verdict = fly(replace(CALM, faults=(pilot, order)))
    assert not verdict.violations, describe(verdict)
    assert any("1: left the swarm: its mode changed to POSHOLD" in line for line in verdict.trace), describe(verdict)


def test_a_height_error_beyond_the_spacing_is_seen_and_shrunk_to_its_cause() -> None:
    idle = OperatorActs(1.0, Action.RESUME, None)
    # Vehicle 1 climbs into the layer of vehicle 2 while both fly home side by side.
    climb = [HeightReset(0.0, 1, -2.4)]
    crossing = [_Crossing(10.0)]
    verdict = fly(replace(CALM, faults=(idle, *climb, *crossing)))
    assert [violation.kind for violation in verdict.violations] == ["separation"]
    assert shrink(verdict).scenario.faults == tuple(crossing)


@dataclass(frozen=True)
class _Crossing(Fault):
    """The estimate of vehicle 1 is replaced by that of vehicle 2: both are flown to one place."""

    @classmethod
    def draw(cls, rng: np.random.Generator, basis: object) -> _Crossing:
        raise NotImplementedError

    async def act(self, world: World) -> None:
        one_m, other_m = world.swarm.state.position_enu_m
        world.swarm.errors._bias_m[:, 0] += one_m - other_m


# --- the oracle -------------------------------------------------------------------------------------------------------


def watching(landed_ids: tuple[int, ...] = (), now_s: float = 9.0) -> Oracle:
    return Oracle(1.5, lambda: now_s, lambda: landed_ids)


def test_a_separation_between_two_steps_is_seen() -> None:
    oracle = watching()
    oracle.update([1, 2], np.array([[-3.0, 0.0, 10.0], [3.0, 0.5, 10.0]]))
    oracle.update([1, 2], np.array([[3.0, 0.0, 10.0], [-3.0, 0.5, 10.0]]))
    assert oracle.smallest_m == pytest.approx(0.5)
    assert "separation" in oracle.violations


@pytest.mark.parametrize(("height_m", "seen"), [(10.0, ["landed in the air"]), (0.1, [])])
def test_a_vehicle_counted_as_landed_in_the_air_is_seen(height_m: float, seen: list[str]) -> None:
    oracle = watching(landed_ids=(2,))
    oracle.update([1, 2], np.array([[-9.0, 0.0, 10.0], [9.0, 0.0, height_m]]))
    assert list(oracle.violations) == seen


def test_one_that_falls_is_not_expected_to_keep_away() -> None:
    oracle = watching(landed_ids=(2,))
    oracle.note_fall(2)
    oracle.update([1, 2], np.array([[0.0, 0.0, 10.0], [0.0, 0.0, 11.0]]))
    assert not oracle.violations


@pytest.mark.parametrize(("target", "seen"), [(1, []), (2, ["wrong address"])])
def test_a_command_to_a_wrong_address_is_seen(target: int, seen: list[str]) -> None:
    oracle = watching()
    oracle.sent(_land(target), (HOST, FIRST_PORT), {0: 1})
    assert list(oracle.violations) == seen


def test_a_command_to_a_stranger_is_seen() -> None:
    oracle = watching()
    oracle.sent(_land(1), (HOST, 6666), {0: 1})
    assert list(oracle.violations) == ["wrong address"]


@pytest.mark.parametrize(("later_s", "seen"), [(PILOT_GRACE_S - 1.0, []), (PILOT_GRACE_S + 1.0, ["pilot overruled"])])
def test_a_command_to_a_vehicle_that_a_pilot_flies_is_seen(later_s: float, seen: list[str]) -> None:
    times_s = iter([0.0, later_s, later_s])
    oracle = Oracle(1.5, lambda: next(times_s), tuple)
    with oracle.piloted(1):
        oracle.sent(_land(1), (HOST, FIRST_PORT), {0: 1})
    assert list(oracle.violations) == seen


def test_a_logged_exception_is_seen() -> None:
    oracle, log = watching(), logging.getLogger("tests.campaign")
    log.addHandler(oracle)
    try:
        raise ValueError("of a test")
    except ValueError:
        log.exception("failed")
    finally:
        log.removeHandler(oracle)
    assert "of a test" in oracle.violations["exception"].text


def _land(target: int) -> bytes:
    command = mavlink.MAVLink_command_long_message(target, 1, mavlink.MAV_CMD_NAV_LAND, 0, 0, 0, 0, 0, 0, 0, 0)
    return bytes(command.pack(mavlink.MAVLink(None, 254, 190)))


# --- the airspace -----------------------------------------------------------------------------------------------------

LIMITS = replace(
    UNLIMITED,
    fence_enu_m=((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)),
    no_go_enu_m=(((10.0, 10.0), (20.0, 10.0), (20.0, 20.0), (10.0, 20.0)),),
    margin_m=20.0,
    no_go_margin_m=2.5,
    floor_m=8.0,
    ceiling_m=30.0,
)
INSIDE = (0.0, 0.0, 15.0)
AWAY_M = TRACKING_M + 0.3


def fly_by(
    *places_enu_m: tuple[float, float, float],
    error_m: tuple[float, float, float] = (0.0, 0.0, 0.0),
    manoeuvre: Manoeuvre = Manoeuvre.POSITION,
    is_ours: bool = True,
) -> list[str]:
    """Return what the watch reports of a vehicle that is at these places, one after the other."""
    kinds: list[str] = []
    watch = AirspaceWatch(lambda kind, _: kinds.append(kind))
    watch.set_limits(LIMITS)
    for place_enu_m in (INSIDE, *places_enu_m):
        believed_enu_m = (np.array(place_enu_m) + error_m).tolist()
        watch.look(1, place_enu_m, believed_enu_m, manoeuvre, is_ours=is_ours)
    return kinds


LEAVING = {
    "beyond the geofence's margin": (30.0 + AWAY_M, 0.0, 15.0),
    "within a no-go zone's margin": (7.5 + AWAY_M, 15.0, 15.0),
    "above the ceiling": (0.0, 0.0, 30.0 + AWAY_M),
    "below the floor": (0.0, 0.0, 8.0 - AWAY_M),
}


@pytest.mark.parametrize(("kind", "place_enu_m"), LEAVING.items())
def test_a_vehicle_that_leaves_the_airspace_is_seen_once(kind: str, place_enu_m: tuple[float, float, float]) -> None:
    assert fly_by(place_enu_m, place_enu_m) == [kind]
    assert fly_by(place_enu_m, INSIDE, place_enu_m) == [kind, kind]
    assert fly_by(place_enu_m, error_m=(0.4, 0.0, 0.4)) == [], "its own error explains it"
    assert fly_by(place_enu_m, is_ours=False) == []


@pytest.mark.parametrize(("kind", "place_enu_m"), LEAVING.items())
def test_an_autopilot_that_returns_or_lands_by_itself_knows_the_ceiling_only(
    kind: str, place_enu_m: tuple[float, float, float]
) -> None:
    for manoeuvre in (Manoeuvre.RETURN_CRUISE, Manoeuvre.LAND):
        assert fly_by(place_enu_m, manoeuvre=manoeuvre) == ([kind] if kind == "above the ceiling" else [])


def test_a_vehicle_that_is_held_while_it_lands_may_sink_below_the_floor() -> None:
    kinds: list[str] = []
    watch = AirspaceWatch(lambda kind, _: kinds.append(kind))
    watch.set_limits(LIMITS)
    for height_m, manoeuvre in ((15.0, Manoeuvre.POSITION), (8.2, Manoeuvre.LAND), (7.0, Manoeuvre.POSITION)):
        place_enu_m = (0.0, 0.0, height_m)
        watch.look(1, place_enu_m, place_enu_m, manoeuvre, is_ours=True)
    assert kinds == []


def test_a_vehicle_on_its_way_up_is_not_below_the_floor_and_its_error_on_the_ground_does_not_count() -> None:
    assert fly_by((0.0, 0.0, 0.0), (0.0, 0.0, 4.0), (0.0, 0.0, 9.0)) == []
    high_m = (0.0, 0.0, 30.0 + AWAY_M)
    assert fly_by((0.0, 0.0, 0.0), high_m, error_m=(0.0, 0.0, 3.0)) == ["above the ceiling"]


# --- virtual time -----------------------------------------------------------------------------------------------------


def test_time_passes_only_by_waiting() -> None:
    async def wait() -> float:
        await asyncio.gather(asyncio.sleep(60.0), asyncio.sleep(3600.0))
        return asyncio.get_running_loop().time()

    assert run(wait()) == pytest.approx(3600.0, abs=0.01)


def test_no_thread_is_waited_for_at_the_end() -> None:
    """The thread that shut the executor down came too late on a busy machine: a mission broke off as a deadlock."""

    class Late(ThreadPoolExecutor):
        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            time.sleep(0.2)
            super().shutdown(wait, cancel_futures=cancel_futures)

    async def leave_one() -> int:
        asyncio.get_running_loop().set_default_executor(Late(1))
        return await asyncio.to_thread(int, "7")

    assert run(leave_one()) == 7


def test_something_that_never_waits_is_told() -> None:
    ends = []

    async def spin() -> None:
        try:
            while True:  # noqa: ASYNC110 - that is what it is for
                await asyncio.sleep(0)
        finally:
            ends.append("cancelled")

    with pytest.raises(RuntimeError, match="never waits"):
        run(spin())
    assert ends == ["cancelled"]


def test_a_mission_whose_records_are_lost_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_gcs.store.database.MissionDatabase.add_step", lambda *_: None)
    assert "steps" in _kinds(fly(CALM))["records lost"]


def test_a_mission_that_breaks_off_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> Path:
        raise ValueError("of a test")

    monkeypatch.setattr("aos_gcs.mission.search.search.Search.make_step", fail)
    assert "of a test" in _kinds(fly(CALM))["exception"]


def _kinds(verdict: FlightVerdict) -> dict[str, str]:
    return {violation.kind: violation.text for violation in verdict.violations}
