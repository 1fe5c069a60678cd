"""Commands to many vehicles: a waypoint for 50, silent ones among healthy ones, hold for 20, memory with 100.

Run: python tests/benchmarks/bench_fleet.py [goto|silent|hold|click|memory ...] [--rounds 10] [--minutes 1] [--busy]

``click`` is a hold from the request of an operator to the dashboard's process. With ``--busy`` each core of the machine
analyses images meanwhile, at the priority of the service's workers.
``silent`` sets mavsdk.asyncio beside the driver, as it is delivered: it waits for answers in a pool of threads.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, contextmanager, suppress
from pathlib import Path

import httpx
import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.opener import UdpEndpoint
from aos_drivers.mavlink import open_mavlink
from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import CommandError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.fleet.bounds import FlightBounds
from aos_gcs.mission.fleet.flight import FlightControl
from aos_gcs.mission.fleet.roster import Roster
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings, PreflightSettings
from aos_gcs.ports import Clock, DriverContext, Fleet, Goto, LandedState
from aos_gcs.process import settle_garbage
from aos_gcs.runtime.dashboard.start import ApiStart
from aos_gcs.runtime.dashboard.supervisor import open_api_process
from aos_gcs.runtime.processes.workers import ANALYSIS
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.registry import make_strategy
from aos_gcs.workers.lifeline import step_back, step_back_as_session
from tests.fakes.mavlink_vehicle import HOME
from tests.fakes.mission_flight import MemoryRecorder, settings

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.benchmarks.bench_imaging import make_frames, whole_step
from tests.benchmarks.figures import report
from tests.benchmarks.fleet_vehicles import HOST, chatter, hover, other_process, simulate
from tests.fakes.program import unused_port

ANSWER_S = 0.3
"""After which a vehicle acknowledges, in the comparison with mavsdk."""
CODE = "larch-and-spruce"
LAYER_M, SPACING_M = 8.0, 3.0
COMMANDS = (mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT)


@asynccontextmanager
async def fleet_of(port: int, count: int) -> AsyncIterator[tuple[Fleet, Clock]]:
    settle_garbage()
    clock = LoopClock()
    context = DriverContext(clock, lambda: True, lambda _notice: None)
    async with open_mavlink([f"udpin://{HOST}:{port}"], context) as fleet:
        await _until(lambda: sum(v.state.landed is LandedState.IN_AIR for v in fleet.vehicles().values()) == count)
        await asyncio.sleep(2.0)
        yield fleet, clock


async def _until(condition: Callable[[], bool], pause_s: float = 0.1) -> None:
    while not condition():  # noqa: ASYNC110 - telemetry changes by itself
        await asyncio.sleep(pause_s)


async def _line_forms(mission: Coordinator) -> None:
    """Wait until the vehicles fly.

    Raises:
        RuntimeError: the mission has ended before.
    """
    await _until(lambda: mission.phase in (Phase.LINE, Phase.DONE))
    if mission.phase is Phase.DONE:
        raise RuntimeError(f"the mission has ended on the ground: {mission.outcome}")


@contextmanager
def commands_on_the_wire() -> Iterator[dict[object, float]]:
    """Note when the first command is handed to the socket of each vehicle."""
    sent: dict[object, float] = {}
    send = UdpEndpoint.send

    def note(endpoint: UdpEndpoint, data: bytes, peer: object) -> None:
        send(endpoint, data, peer)  # type: ignore[arg-type]
        if int.from_bytes(data[7:10], "little") in COMMANDS:
            sent.setdefault(peer, time.perf_counter())

    UdpEndpoint.send = note  # type: ignore[assignment, method-assign]
    try:
        yield sent
    finally:
        UdpEndpoint.send = send  # type: ignore[method-assign]


# --- measurements ---------------------------------------------------------------------------------------------------


async def goto(rounds: int, count: int = 50) -> None:
    """Time from the strategy's ask to the last waypoint handed to the socket, all of them vetted."""
    port, arrivals = unused_port(), multiprocessing.Queue()
    with other_process(hover, port, count, 0, 0.0, arrivals):
        async with fleet_of(port, count) as (fleet, clock):
            roster = Roster(fleet, clock)
            roster.refresh()
            roster.frame = LocalFrame(HOME)
            settings = FlightSettings()
            limits = SafetyLimits(
                fence_enu_m=((-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3)), floor_m=5.0, ceiling_m=500.0
            )
            bounds = FlightBounds(settings.arrival_radius_m, limits)
            flight = FlightControl(roster, clock, Journal(clock), settings, Deadlines(), bounds=bounds)
            members = roster.members()
            for member in members:
                roster.assign(member, Task.SWARM)
            positions_enu_m = np.array([roster.position_enu_m(member) for member in members])
            strategy, rng = make_strategy("aos-apso", {}), np.random.default_rng(1)
            state = strategy.init(np.array([0.0, 1.0]))
            ids = tuple(member.vehicle_id for member in members)
            seen = Observation(ids, positions_enu_m[:, :2], rng.random(count), target_in_view=False)
            spent_ms, cpu_ms = [], []
            for _ in range(rounds):
                state = strategy.tell(state, seen)
                with commands_on_the_wire() as sent:
                    start_s, cpu_s = time.perf_counter(), time.process_time()
                    places_m, state = strategy.ask(state, rng)
                    requests = {
                        vehicle_id: np.array([*place_m, height_m])
                        for vehicle_id, place_m, height_m in zip(ids, places_m, positions_enu_m[:, 2], strict=True)
                    }
                    records = flight.vet(requests)
                    sending = asyncio.create_task(flight.send(records))
                    sent_count = sum(record.sent_enu_m is not None for record in records)
                    await _until(lambda sent=sent, count=sent_count: len(sent) == count, pause_s=0.0)
                    spent_ms.append(1e3 * (max(sent.values()) - start_s))
                    cpu_ms.append(1e3 * (time.process_time() - cpu_s))
                    await sending
    report("fleet.goto", float(np.median(spent_ms)))
    print(
        f"goto: ask to the last of {sent_count} waypoints on the wire, {count} vehicles: {_told(spent_ms)}; "
        f"of the processor, median {np.median(cpu_ms):.1f} ms"
    )


async def silent(rounds: int, healthy: int = 14, mute: int = 6) -> None:
    """Delay of the first command of each healthy vehicle while others answer nothing; ours beside mavsdk.asyncio."""
    count = healthy + mute
    ours_ms, peer_ms = await _silent_ours(rounds, count, mute), None
    try:
        peer_ms = await _silent_mavsdk(count, mute)
    except ImportError:
        print("silent: mavsdk is not installed; nothing to compare with")
    report("fleet.silent", ours_ms, ratio=None if peer_ms is None else ours_ms / peer_ms)


async def _silent_ours(rounds: int, count: int, mute: int) -> float:
    port, arrivals = unused_port(), multiprocessing.Queue()
    worst_ms = []
    with other_process(hover, port, count, mute, ANSWER_S, arrivals):
        async with fleet_of(port, count) as (fleet, clock):

            async def send(vehicle_id: int) -> None:
                place = GeodeticPosition(HOME.latitude_deg + 1e-4, HOME.longitude_deg, HOME.altitude_amsl_m + 50.0)
                with suppress(CommandError):
                    await fleet.vehicles()[vehicle_id].execute(Goto(place, 5.0), clock.now_s() + 3.0)

            for _ in range(min(rounds, 5)):
                start_s = time.monotonic()
                # The silent ones first, as the worst case.
                await asyncio.gather(*(send(vehicle_id) for vehicle_id in range(count, 0, -1)))
                worst_ms.append(_last_healthy_ms(arrivals, start_s, count - mute))
    print(
        f"silent: {mute} of {count} answer nothing; the last healthy one hears its waypoint after "
        f"{np.median(worst_ms):.1f} ms (median of {len(worst_ms)} rounds, worst {max(worst_ms):.1f} ms)"
    )
    return float(np.median(worst_ms))


async def _silent_mavsdk(count: int, mute: int) -> float:
    from mavsdk.asyncio import ComponentType, Configuration, Mavsdk  # noqa: PLC0415 - an optional peer
    from mavsdk.asyncio.plugins.action import ActionAsync, ActionError  # noqa: PLC0415

    port, arrivals = unused_port(), multiprocessing.Queue()
    with other_process(hover, port, count, mute, ANSWER_S, arrivals):
        core = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
        await core.add_any_connection(f"udpin://{HOST}:{port}")
        await asyncio.sleep(5.0)
        systems = await core.get_systems()
        actions = {await system.get_system_id(): ActionAsync(system) for system in systems}

        async def send(vehicle_id: int) -> None:
            with suppress(ActionError):
                await actions[vehicle_id].goto_location(
                    HOME.latitude_deg + 1e-4, HOME.longitude_deg, HOME.altitude_amsl_m + 50.0, math.nan
                )

        start_s = time.monotonic()
        await asyncio.gather(*(send(vehicle_id) for vehicle_id in range(count, 0, -1)))
        last_ms = _last_healthy_ms(arrivals, start_s, count - mute)
        core.destroy()
    print(f"silent: mavsdk.asyncio, one round: after {last_ms:.0f} ms")
    return last_ms


def _last_healthy_ms(arrivals: multiprocessing.Queue[tuple[int, float]], start_s: float, healthy: int) -> float:
    first: dict[int, float] = {}
    while not arrivals.empty():
        vehicle_id, at_s = arrivals.get()
        if at_s >= start_s:
            first.setdefault(vehicle_id, at_s)
    return 1e3 * max(first.get(vehicle_id, math.inf) - start_s for vehicle_id in range(1, healthy + 1))


async def hold(rounds: int, count: int = 20) -> None:
    """Time from the operator's hold of all, in the middle of a procedure, to the wire and to the last mode shown."""
    port = unused_port()
    with other_process(simulate, port, count):
        async with _mission(port, count, auto_start=True) as (mission, _):
            await _line_forms(mission)
            await asyncio.sleep(2.0)
            wire_ms, shown_ms = [], []
            for _ in range(rounds):
                with commands_on_the_wire() as sent:
                    start_s = time.perf_counter()
                    results = await mission.commands.act(Action.HOLD, None)
                    shown_ms.append(1e3 * (time.perf_counter() - start_s))
                if len(sent) < count or not all(result.accepted for result in results):
                    raise RuntimeError(f"only {len(sent)} of {count} were told to hold: {results}")
                wire_ms.append(1e3 * (max(sent.values()) - start_s))
                await mission.commands.act(Action.RESUME, None)
                await asyncio.sleep(2.0)
    report("fleet.hold", float(np.median(wire_ms)))
    print(
        f"hold: request to the last of {count} holds on the wire, {_told(wire_ms)}; "
        f"to the last mode shown, {_told(shown_ms)}"
    )


async def click(rounds: int, count: int = 20) -> None:
    """Time from an operator's request to the dashboard, in its own process, to the last hold on the wire."""
    port = unused_port()
    with other_process(simulate, port, count), tempfile.TemporaryDirectory() as folder:
        config = ApiConfig(port=0, plans_folder=Path(folder) / "plans")
        start = ApiStart(config, CODE, Path(folder), Path(folder) / "m")
        async with open_api_process(start, print) as api, _mission(port, count, auto_start=True) as (mission, _):
            assert api is not None
            async with api.showing(mission.view, mission.commands):
                await _line_forms(mission)
                await asyncio.sleep(2.0)
                with httpx.Client(base_url=api.address.url, timeout=30.0) as client:
                    wire_ms = [await _click(client, mission, count) for _ in range(rounds)]
    report("fleet.click", float(np.median(wire_ms)))
    print(f"click: request to the last of {count} holds on the wire, {_told(wire_ms)}")


async def _click(client: httpx.Client, mission: Coordinator, count: int) -> float:
    def hold() -> float:
        """Return when the operator pressed; the page has a connection and a session by then."""
        client.post("/api/session", json={"code": CODE, "name": "Ada"}).raise_for_status()
        start_s = time.perf_counter()
        client.post("/api/mission/actions", json={"action": "hold"}).raise_for_status()
        return start_s

    with commands_on_the_wire() as sent:
        start_s = await asyncio.to_thread(hold)
    if len(sent) < count:
        raise RuntimeError(f"only {len(sent)} of {count} were told to hold")
    await mission.commands.act(Action.RESUME, None)
    await asyncio.sleep(2.0)
    return 1e3 * (max(sent.values()) - start_s)


def _told(values_ms: list[float]) -> str:
    median_ms, p99_ms = np.percentile(values_ms, (50, 99))
    return f"median {median_ms:.1f} ms, p99 {p99_ms:.1f} ms, worst {max(values_ms):.1f} ms ({len(values_ms)} rounds)"


def analyse_images() -> None:
    """Analyse the frames of ten vehicles until killed, as the service's worker does: in a session of its own."""
    os.setsid()
    step_back(ANALYSIS.memory_bytes)
    step_back_as_session()
    frames = make_frames(4.2, np.float32, 10)
    while True:
        whole_step(frames)


async def memory(minutes: float, count: int = 100, rate_hz: float = 20.0) -> None:
    """Growth of our process with vehicles that send all the time and a mission that watches them."""
    port = unused_port()
    with other_process(chatter, port, count, rate_hz):
        async with _mission(port, count, auto_start=False) as (mission, recorder):
            await _until(lambda: len(mission.view.snapshot().vehicles) == count)
            await asyncio.sleep(20.0)
            samples = []
            start_s = time.monotonic()
            while (now_s := time.monotonic() - start_s) < 60.0 * minutes:
                recorder.events.clear()
                samples.append((now_s / 60.0, _resident_mib()))
                await asyncio.sleep(2.0)
    times_min, resident_mib = np.array(samples).T
    slope = np.polyfit(times_min, resident_mib, 1)[0]
    report("fleet.memory", float(slope))
    print(
        f"memory: {count} vehicles at {rate_hz:.0f} messages/s for {minutes:g} min: {resident_mib[0]:.1f} MiB at "
        f"first, {resident_mib[-1]:.1f} MiB at last, {slope:+.2f} MiB per minute"
    )


@asynccontextmanager
async def _mission(port: int, count: int, *, auto_start: bool) -> AsyncIterator[tuple[Coordinator, MemoryRecorder]]:
    settle_garbage()
    clock = LoopClock()
    journal, recorder, pulse = Journal(clock), MemoryRecorder(), LoopMonitor()
    context = DriverContext(clock=clock, is_healthy=pulse.is_healthy, notify=journal.take)
    plan = settings(
        count,
        origin=None,
        area_enu_m=((-60.0, 40.0), (60.0, 40.0), (60.0, 400.0), (-60.0, 400.0)),
        flight=FlightSettings(lowest_layer_m=LAYER_M, layer_spacing_m=SPACING_M, cruise_speed_mps=3.0),
        deadlines=Deadlines(preflight_s=120.0),
        preflight=PreflightSettings(upload_fence=True, set_return_height=True),
        auto_start=auto_start,
    )
    async with open_mavlink([f"udpin://{HOST}:{port}"], context) as fleet, journal.recorded(recorder):
        mission = Coordinator(
            "bench", plan, fleet=fleet, clock=clock, journal=journal, recorder=recorder, loop_monitor=pulse
        )
        run = asyncio.create_task(mission.run())
        try:
            yield mission, recorder
        finally:
            run.cancel()
            await asyncio.gather(run, return_exceptions=True)


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 2**20


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="*", default=["goto", "silent", "hold", "click", "memory"])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--busy", action="store_true")
    chosen = parser.parse_args()
    with ExitStack() as busy:
        for _ in range((os.cpu_count() or 1) if chosen.busy else 0):
            busy.enter_context(other_process(analyse_images))
        for name in chosen.what:
            if name == "memory":
                asyncio.run(memory(chosen.minutes))
            else:
                asyncio.run({"goto": goto, "silent": silent, "hold": hold, "click": click}[name](chosen.rounds))
