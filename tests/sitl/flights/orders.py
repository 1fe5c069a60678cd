"""Orders of an operator to all vehicles and to one, and a home that somebody has set elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from tests.sitl.flights.autopilots import Autopilots
from tests.sitl.flights.relay import Relay
from tests.sitl.flights.station import VEHICLES, FlightError, Station, all_down, describe, failures
from tests.sitl.flights.steps import (
    FLIGHT_S,
    LAUNCH_S,
    SEARCH,
    State,
    start_all,
    to_the_end,
    vehicle,
    wait_for_the_sweep,
)

ORDERED = 3
"""System id of the vehicle that is ordered alone."""
OFTEN_ENOUGH_S = 10.0
"""Time for which vehicles have to obey a hold."""
SETTLED_S = 5.0
"""Time that a PX4 needs to hover at its place, which it reaches slowly once it has braked."""
STILL_MPS = 1.0
"""Speed below which a vehicle hovers: the position of PX4's simulator wanders, by 0.8 m/s at times."""
ON_THE_WAY_S = 4.0
"""Time after which a return is held: its vehicles are on their way."""
HOME_EAST_M = -30.0
"""Place of the home that another station sets, from the vehicle."""
SILENCE_S = 28.0
"""Time in which a mission whose vehicles are all silent is over; their failsafes act after 30 s."""
HEARD_S = 30.0
HOME_M = 3.0
BEHIND_PORT = 14660
AWAY = "away from their launch points"


def held_and_returned(autopilots: Autopilots, station: Station) -> str:
    """All are held in a sweep, returned, held on the way, and returned again."""
    station.setting = SEARCH
    start_all(autopilots)
    with station:
        wait_for_the_sweep(station)
        texts = []
        for place in ("in the sweep", "on the way home"):
            _order(station, "hold")
            _stand_still(station)
            texts.append(f"held {place} for {OFTEN_ENOUGH_S:.0f} s")
            _order(station, "return")
            if len(texts) == 1:
                time.sleep(ON_THE_WAY_S)
        text = to_the_end(station)
        if AWAY in text:
            raise FlightError(f"not home: {text}")
        return f"{', '.join(texts)}, returned; {text}"


def put_down_and_joined(autopilots: Autopilots, station: Station) -> str:
    """One is put down while the search pauses, joins again, and the search goes on; then all land where they are.

    Where receivers measure the ground by RTK it lands where it is, and joins from there; otherwise it returns first.
    """
    station.setting = SEARCH
    start_all(autopilots)
    with station:
        wait_for_the_sweep(station)
        _order(station, "pause")
        down = "land" if autopilots.kind.measures_ground else "return"
        _wait_until_accepted(station, down, ORDERED)
        station.wait_for("landing of one", lambda state: vehicle(state, ORDERED)["task"] == "landed", FLIGHT_S)
        joined_s = _wait_until_accepted(station, "join", ORDERED)
        station.wait_for("return to the swarm", lambda state: vehicle(state, ORDERED)["task"] == "swarm", FLIGHT_S)
        swarm_s = time.monotonic() - joined_s
        _order(station, "resume")
        station.wait_for("sweep", lambda state: "searching in flight" in state["message"], LAUNCH_S)
        _order(station, "land")
        state = station.wait_for("landing of all", lambda state: state["phase"] == "done", FLIGHT_S)
        if not all_down(state):
            raise FlightError(f"ended with a vehicle in the air: {describe(state)}")
        return f"joined after {down}, back in the swarm after {swarm_s:.0f} s, all landed: {state['message']}"


def home_kept_elsewhere(autopilots: Autopilots, station: Station) -> str:
    """Another station has set the home of one 30 m away: it must not be launched, and the others fly."""
    station.setting, station.by_hand = SEARCH, True
    start_all(autopilots)
    with station:
        station.wait_for("positions", _has_passed("home"), LAUNCH_S)
        autopilots.set_home(ORDERED - 1, east_m=HOME_EAST_M)
        state = station.wait_for("warning", lambda state: bool(_warnings(state)), LAUNCH_S)
        warned = _warnings(state)[0]
        station.wait_for("preflight", lambda state: state["phase"] == "ready", LAUNCH_S)
        _order(station, "start")
        wait_for_the_sweep(station)
        kept = station.said("stays on the ground: its autopilot has its home")
        state = station.wait_for("an answer", lambda _: True, 30.0)
        if not kept or vehicle(state, ORDERED)["armed"]:
            raise FlightError(f"launched with its home elsewhere: {describe(state)}")
        return f"warned ({warned}), stayed on the ground; the others: {to_the_end(station)}"


def silent_and_heard_again(autopilots: Autopilots, station: Station) -> str:
    """All fall silent in a sweep for longer than the mission waits, and are heard before their failsafes act."""
    relay = Relay(autopilots.kind.station_link, BEHIND_PORT)
    station.setting, station.link = SEARCH, relay.station_link
    with relay.running():
        start_all(autopilots)
        with station:
            wait_for_the_sweep(station)
            relay.fall_silent()
            station.wait_for("end", lambda state: state["phase"] == "done", SILENCE_S)
            ended_s = time.monotonic()
            relay.fall_silent(silent=False)
            state = station.wait_for(
                "way home", lambda state: all(row["task"] == "returning" for row in state["vehicles"]), HEARD_S
            )
            modes = ", ".join(row["mode_name"] for row in state["vehicles"])
            state = station.wait_for("landing", all_down, FLIGHT_S)
            if any(_away_m(row) > HOME_M for row in state["vehicles"]):
                raise FlightError(f"not home: {describe(state)}")
            return f"over by silence, led home ({modes}), all landed {time.monotonic() - ended_s:.0f} s after the end"


def _away_m(row: State) -> float:
    """Return the distance of a vehicle from its home."""
    position, home = row["position"], row["home"]
    return math.hypot(position["east_m"] - home["east_m"], position["north_m"] - home["north_m"])


def _order(station: Station, action: str, *vehicle_ids: int) -> None:
    if refused := station.act(action, *vehicle_ids):
        raise FlightError(f"{action} refused: {'; '.join(refused)}")


def _wait_until_accepted(station: Station, action: str, vehicle_id: int) -> float:
    """Give an order again while it is refused, such as for a vehicle that passes; return when it was accepted."""
    end_s = time.monotonic() + LAUNCH_S
    while refused := station.act(action, vehicle_id):
        if time.monotonic() > end_s:
            raise FlightError(f"{action} refused: {'; '.join(refused)}")
        time.sleep(2.0)
    return time.monotonic()


def _stand_still(station: Station) -> None:
    """Wait until all stop, and look whether they stay."""
    station.wait_for("hold", _stands, OFTEN_ENOUGH_S)
    time.sleep(SETTLED_S)
    end_s = time.monotonic() + OFTEN_ENOUGH_S
    while time.monotonic() < end_s:
        state = station.wait_for("an answer", lambda _: True, 30.0)
        if not _stands(state):
            raise FlightError(f"moved while held: {describe(state)}")
        time.sleep(1.0)


def _stands(state: State) -> bool:
    flying = [row for row in state["vehicles"] if row["takes_part"]]
    speeds_mps = [row["ground_speed_mps"] for row in flying]
    is_held = state["suspension"] == "held" and len(flying) == VEHICLES
    return is_held and all(speed_mps is not None and speed_mps < STILL_MPS for speed_mps in speeds_mps)


def _has_passed(check: str) -> Callable[[State], bool]:
    def passes(state: State) -> bool:
        rows = [row for row in state["preflight"] if row["name"] == check]
        return len(rows) == VEHICLES and not any(row in failures(state) for row in rows)

    return passes


def _warnings(state: State) -> list[str]:
    return [row["text"] for row in state["preflight"] if row["name"] == "home" and row["status"] == "warn"]
