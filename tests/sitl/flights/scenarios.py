"""What is flown: each scenario flies a mission and says what came of it, or raises FlightError."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from tests.sitl.flights.autopilots import ALTITUDE_AMSL_M, LATITUDE_DEG, LONGITUDE_DEG, Autopilots, Offsets
from tests.sitl.flights.orders import (
    held_and_returned,
    home_kept_elsewhere,
    put_down_and_joined,
    silent_and_heard_again,
)
from tests.sitl.flights.station import (
    FLOOR_M,
    VEHICLES,
    FlightError,
    Setting,
    Station,
    all_down,
    describe,
    failures,
)
from tests.sitl.flights.steps import (
    AREA_ENU_M,
    FLIGHT_S,
    FOREST,
    LAUNCH_S,
    SEARCH,
    State,
    start_all,
    to_the_end,
    vehicle,
    wait_for_the_search,
    wait_for_the_sweep,
)

Scenario: TypeAlias = Callable[[Autopilots, Station], str]

SPOOFING_S = 20.0
SPOOFED_PER_S = 20.0
RECEIVER_OFFSET_M = 6.0
BAROMETER_DRIFT_MPS = 0.05
TAKEN_OVER = 2
"""System id of the vehicle that a pilot takes over."""
LEFT_ALONE_S = 10.0
"""Time after which it is given back: an ArduCopter without a remote control sinks by 2.5 m/s in LOITER."""

SEARCHED = ("searched", "MISSION", "--json", "--raster", "pod.tif", "--gaps", "gaps.geojson")
INSPECTED = ("inspect", "MISSION", "--truth", "world.json", "--truth-report", "report.json")
"""What is asked about the mission's folder afterwards."""
DISTRACTED = Setting(area_enu_m=AREA_ENU_M, world=("--seed", "5", "--animals", "1", "--stones", "2"), tables=FOREST)
DRIFTING = Setting(overrides=("home altitude: the drift is to be found in flight",))
LEFT = "Left for later: "
LOOKED = "Close look started (left for later before): "
RELIEF = Setting(area_enu_m=AREA_ENU_M, world=("--seed", "4"), terrain="hills")
"""The ground rises to 17 m above the launch site, and falls to 1 m below it."""


def whole_mission(autopilots: Autopilots, station: Station) -> str:
    """Nothing goes wrong."""
    start_all(autopilots)
    with station:
        return to_the_end(station)


def killed_and_taken_up(autopilots: Autopilots, station: Station) -> str:
    """The service is killed in a sweep, and started again at once."""
    station.setting = SEARCH
    start_all(autopilots)
    with station:
        wait_for_the_sweep(station)
        taken_up, refused = _kill_and_resume(station)
        if refused:
            station.wait_for("landing", all_down, FLIGHT_S)
            return f"{taken_up}, not resumed ({refused}), all landed by themselves"
        return f"{taken_up}, resumed, {to_the_end(station)}"


def looked_at_later(autopilots: Autopilots, station: Station) -> str:
    """Animals and stones are about; the service is killed once it has left one for later, and started again."""
    station.setting = DISTRACTED
    start_all(autopilots)
    with station:
        station.wait_for("something left for later", lambda _: bool(station.said(LEFT)), LAUNCH_S)
        taken_up, refused = _kill_and_resume(station)
        if refused:
            raise FlightError(f"{taken_up}, not resumed ({refused})")
        text = to_the_end(station)
    if not (looked := station.said(LOOKED)):
        raise FlightError(f"{taken_up}, resumed, what was left for later was not looked at: {text}")
    return f"{taken_up}, resumed, {len(looked)} of {len(station.said(LEFT))} left for later looked at, {text}"


def searched(autopilots: Autopilots, station: Station) -> str:
    """A larger area is searched in flight, with a map of the probability of detection."""
    station.setting = SEARCH
    start_all(autopilots)
    with station:
        wait_for_the_sweep(station)
        text = to_the_end(station)
    figures = json.loads(station.ask("searched.log", *SEARCHED))
    station.ask("inspect.log", *INSPECTED)
    detection = ", ".join(f"{posture} {share:.2f}" for posture, share in figures["detection"].items())
    seen = f"{figures['seen_fraction']:.0%} seen, {figures['mean_views']:.1f} views, detection {detection}"
    return f"{text}; {figures['frames']} frames, {seen}"


def over_relief(autopilots: Autopilots, station: Station) -> str:
    """Hills below layers that follow the ground."""
    station.setting = RELIEF
    start_all(autopilots)
    try:
        with station:
            wait_for_the_sweep(station)
            text = to_the_end(station)
    except FlightError as error:
        lowest_m = station.truth("min_height_above_ground_m")
        raise FlightError(f"{error}; least height above ground: {lowest_m} m") from error
    height_m = station.truth("min_height_above_ground_m")
    if height_m is None or height_m < FLOOR_M - 1.0:
        raise FlightError(f"{height_m} m above ground, floor {FLOOR_M} m; {text}")
    return f"{text}; {height_m:.1f} m above the ground or more"


def taken_over(autopilots: Autopilots, station: Station) -> str:
    """The second vehicle is taken over in a sweep, left alone for 15 s, and given back by its pilot."""
    station.setting = SEARCH
    start_all(autopilots)
    with station:
        step = wait_for_the_sweep(station)["step"]
        autopilots.take_over(TAKEN_OVER - 1)
        state = station.wait_for("take-over", lambda state: vehicle(state, TAKEN_OVER)["task"] == "held", 15.0)
        mode, told_step = vehicle(state, TAKEN_OVER)["mode_name"], state["step"]
        time.sleep(LEFT_ALONE_S)
        state = station.wait_for("an answer", lambda _: True, 30.0)
        if vehicle(state, TAKEN_OVER)["task"] != "held" or vehicle(state, TAKEN_OVER)["mode_name"] != mode:
            raise FlightError(f"not left alone: {describe(state)}")
        others = f"the others went on from step {step} by {told_step} to {state['step']}"
        if refused := station.act("resume", TAKEN_OVER):
            raise FlightError(f"not given back: {'; '.join(refused)}")
        station.wait_for("return to the swarm", lambda state: vehicle(state, TAKEN_OVER)["task"] == "swarm", 60.0)
        return f"left alone in {mode} for {LEFT_ALONE_S:.0f} s, {others}, given back; {to_the_end(station)}"


def spoofed(autopilots: Autopilots, station: Station) -> str:
    """Another program on the station's machine speaks for all vehicles: disarmed, on the ground, somewhere else."""
    start_all(autopilots)
    with station:
        wait_for_the_search(station)
        believed = 0
        with _spoofer(station) as count:
            end_s = time.monotonic() + SPOOFING_S
            while time.monotonic() < end_s:
                state = station.state()
                believed += state is not None and any(
                    v["task"] == "landed" or v["armed"] is False or v["landed"] == "on_ground"
                    for v in state["vehicles"]
                )
                time.sleep(0.5)
        if believed:
            raise FlightError(f"a forged report was believed in {believed} of {2 * SPOOFING_S:.0f} looks")
        return f"{count[0]} forged packets believed by nobody, {to_the_end(station)}"


def twin_on_the_ground(autopilots: Autopilots, station: Station) -> str:
    """A fourth vehicle with the first one's id is there before the launch."""
    start_all(autopilots)
    autopilots.start(system_id=1)
    with station:
        return _refused(station, "system id")


def twin_in_flight(autopilots: Autopilots, station: Station) -> str:
    """A fourth vehicle with the first one's id is switched on during the search."""
    start_all(autopilots)
    with station:
        wait_for_the_search(station)
        autopilots.start(system_id=1)
        return to_the_end(station)


def receiver_offset(autopilots: Autopilots, station: Station) -> str:
    """The second vehicle's receiver measures 6 m too high."""
    start_all(autopilots, {1: Offsets(receiver_m=RECEIVER_OFFSET_M)})
    with station:
        return _refused(station, "home altitude")


def barometer_drift(autopilots: Autopilots, station: Station) -> str:
    """The second vehicle's barometer drifts by 5 cm/s, which preflight is told to ignore, and so does its height."""
    station.setting = DRIFTING
    start_all(autopilots, {1: Offsets(barometer_drift_mps=BAROMETER_DRIFT_MPS)})
    with station:
        return to_the_end(station)


SCENARIOS: dict[str, Scenario] = {
    "mission": whole_mission,
    "search": searched,
    "relief": over_relief,
    "take-over": taken_over,
    "kill": killed_and_taken_up,
    "later": looked_at_later,
    "orders": held_and_returned,
    "join": put_down_and_joined,
    "home": home_kept_elsewhere,
    "silence": silent_and_heard_again,
    "spoof": spoofed,
    "twin-ground": twin_on_the_ground,
    "twin-flight": twin_in_flight,
    "receiver-offset": receiver_offset,
    "barometer-drift": barometer_drift,
}
WITHOUT: dict[str, frozenset[str]] = {
    "arducopter": frozenset({"receiver-offset"}),
    "px4": frozenset({"barometer-drift"}),
}
"""Flights that an autopilot's simulator does not allow.

The receivers of ArduCopter's report an RTK fix, from which preflight takes the height of the ground; the barometers
of PX4's have a constant offset only, which the estimator takes out on the ground.
"""


def _kill_and_resume(station: Station) -> tuple[str, str]:
    """Kill the service, start it again at once and resume; return how it took the flight up, and what was refused."""
    station.kill()
    killed_s = time.monotonic()
    station.start(auto_start=False)
    state = station.wait_for("taken up", lambda state: state["suspension"] == "held", 60.0)
    taken_up = f"taken up after {time.monotonic() - killed_s:.0f} s ({_modes(state)})"
    return taken_up, "; ".join(station.act("resume"))


def _refused(station: Station, check: str) -> str:
    """Wait until preflight has been refused by a check, look whether it stays so, and return its words."""

    def fails(state: State) -> bool:
        return any(row["name"] == check for row in failures(state))

    station.wait_for(f"failure of {check}", fails, LAUNCH_S)
    time.sleep(20.0)
    state = station.wait_for("an answer", lambda _: True, 30.0)
    if not fails(state) or any(v["armed"] for v in state["vehicles"]):
        raise FlightError(f"not refused for good: {describe(state)}")
    return "not launched: " + next(row["text"] for row in failures(state) if row["name"] == check)


def _modes(state: State) -> str:
    return ", ".join(v["mode_name"] for v in state["vehicles"])


@contextmanager
def _spoofer(station: Station) -> Iterator[list[int]]:
    """Send forged packets from a port of our own while the context lasts; the list holds their number."""
    host, port = station.kind.station_link.removeprefix("udpin://").split(":")
    is_over, count = threading.Event(), [0]
    autopilot = mavlink.MAV_AUTOPILOT_PX4 if station.kind.name == "px4" else mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    place = round(LATITUDE_DEG * 1e7), round(LONGITUDE_DEG * 1e7), round(ALTITUDE_AMSL_M * 1e3), 0

    def send() -> None:
        codecs = [mavlink.MAVLink(None, system_id, 1) for system_id in range(1, VEHICLES + 1)]
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as forger:
            while not is_over.wait(1.0 / SPOOFED_PER_S):
                boot_ms = round(time.monotonic() * 1e3) % 2**32
                for codec in codecs:
                    for message in (
                        mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, autopilot, 0, 0, 3, 3),
                        mavlink.MAVLink_extended_sys_state_message(0, mavlink.MAV_LANDED_STATE_ON_GROUND),
                        mavlink.MAVLink_global_position_int_message(boot_ms, *place, 0, 0, 0, 0),
                    ):
                        forger.sendto(message.pack(codec), (host, int(port)))
                        count[0] += 1

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    try:
        yield count
    finally:
        is_over.set()
        thread.join()
