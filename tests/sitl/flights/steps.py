"""What several flights have in common: the start of the autopilots, and the waits from the launch to the end."""

from __future__ import annotations

import time
from typing import Any, TypeAlias

from tests.sitl.flights.autopilots import Autopilots, Offsets
from tests.sitl.flights.station import VEHICLES, FlightError, Setting, Station, all_down, describe

State: TypeAlias = dict[str, Any]

LAUNCH_S = 300.0
FLIGHT_S = 600.0

FOREST = """
[forest]
canopy_height_m = 18.0
crown_base_m = 5.0
"""
AREA_ENU_M = ((-30.0, 25.0), (30.0, 25.0), (30.0, 105.0), (-30.0, 105.0))
SEARCH = Setting(area_enu_m=AREA_ENU_M, world=("--seed", "3"), tables=FOREST)


def start_all(autopilots: Autopilots, offsets: dict[int, Offsets] | None = None) -> None:
    """Start all autopilots of a flight."""
    for instance in range(VEHICLES):
        autopilots.start(offsets=(offsets or {}).get(instance))


def wait_for_the_search(station: Station) -> State:
    """Wait until the vehicles search."""
    station.wait_for("launch", lambda state: state["phase"] not in ("connect", "preflight", "ready"), LAUNCH_S)
    return station.wait_for("search", lambda state: state["phase"] in ("scan", "converge", "found"), LAUNCH_S)


def wait_for_the_sweep(station: Station) -> State:
    """Wait until the line has flown along a leg for a few rounds of frames, without stops."""
    wait_for_the_search(station)
    station.wait_for("sweep", lambda state: "searching in flight" in state["message"], LAUNCH_S)
    time.sleep(3.0)
    return station.wait_for("sweep", lambda state: "searching in flight" in state["message"], LAUNCH_S)


def vehicle(state: State, vehicle_id: int) -> State:
    """Return what the service says of one vehicle."""
    return next(row for row in state["vehicles"] if row["vehicle_id"] == vehicle_id)


def to_the_end(station: Station) -> str:
    """Wait for the end of the mission and return its outcome."""
    station.wait_for("launch", lambda state: state["phase"] not in ("connect", "preflight", "ready"), LAUNCH_S)
    state = station.wait_for("end", lambda state: state["phase"] == "done", FLIGHT_S)
    if not all_down(state):
        raise FlightError(f"ended with a vehicle in the air: {describe(state)}")
    if state["outcome"] == "failed":
        raise FlightError(state["message"])
    return f"{state['outcome']} after {state['elapsed_s']:.0f} s: {state['message']}"
