"""The flight loop while thousands of hostile connections stand at the dashboard: its lag, the heartbeats' gaps, holds.

The service runs with its real driver and the dashboard's process; a vehicle, an operator and the attackers are other
processes. A third of the connections reads nothing of what it asks for, a third sends half a request, a third asks
without end; they come from many addresses, beyond what one may have, and some from the operator's own. Those that are
refused are opened again without a pause. The operator holds all again and again, each time by a new connection and by
the event stream that was open before.

Run: python tests/benchmarks/bench_connections.py [--connections 5000] [--seconds 15]
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import json
import math
import multiprocessing
import os
import resource
import socket
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.queues import Queue
from multiprocessing.synchronize import Event
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import httpx
from websockets.exceptions import WebSocketException
from websockets.sync.client import ClientConnection, connect

from aos_gcs.config.file import parse_config
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.runtime.service import open_service
from tests.benchmarks.bench_flood import HOST, FlyingVehicle
from tests.benchmarks.figures import report
from tests.fakes.program import unused_port

ATTACKERS = 5
ADDRESSES = 200
"""Addresses on the loopback network that each attacker uses."""
SETTLE_S = 3.0
_NICENESS = 15
"""Attackers stand for other machines, which take no processor of this one."""
HOLD_EVERY_S = 0.5
SHARED = 4
"""One of so many connections of the first attacker comes from the operator's address."""
CODE = "larch-and-spruce"
ASK = b"GET /api/mission HTTP/1.1\r\nHost: localhost\r\n\r\n"
HALF = b"GET /api/mission HTTP/1.1\r\nHost: localhost\r\nX-Slow: "
FOLLOW = (
    b"GET /api/events HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)
FIRST_WORDS = (FOLLOW, HALF, ASK)
Flight = tuple[Event, "Queue[list[float]]"]
"""Event that begins a flight of the vehicle, and where the gaps between its heartbeats come."""
Answer = str | tuple[list[float], list[float]]
"""What an attacker has opened, or how long an operator's holds have taken by both ways, in milliseconds."""


def attack(port: int, number: int, connections: int, begin: Event, answers: Queue[Answer]) -> None:
    """Hold connections open until killed; those that are refused are opened again."""
    os.nice(_NICENESS)
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    held: list[socket.socket | None] = [None] * connections
    begin.wait()
    for rounds in itertools.count(1):
        for index in range(connections):
            held[index] = assail(held[index], index, port, number)
        if rounds == 1:
            answers.put(f"attacker {number}: {sum(one is not None for one in held)} connections opened")


def assail(link: socket.socket | None, index: int, port: int, number: int) -> socket.socket | None:
    """Send more on a connection, or open it; None where it is refused."""
    try:
        if link is None:
            link = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            link.settimeout(0.2)
            is_behind_operator = number == 0 and index % SHARED == 0
            link.bind((HOST if is_behind_operator else f"127.{number + 1}.0.{index % ADDRESSES + 1}", 0))
            link.connect((HOST, port))
            link.sendall(FIRST_WORDS[index % len(FIRST_WORDS)])
            link.setblocking(False)
        elif FIRST_WORDS[index % len(FIRST_WORDS)] is ASK:
            with suppress(BlockingIOError):
                link.send(ASK * 8)
    except OSError:
        if link is not None:
            link.close()
        return None
    return link


async def main(connections: int, duration_s: float, folder: Path) -> None:
    """Print the figures without and with the attack."""
    link_port, port = unused_port(), unused_port(socket.SOCK_STREAM)
    (folder / "code.txt").write_text(CODE, encoding="utf-8")
    config = parse_config(
        {
            "link": {"urls": [f"udpin://{HOST}:{link_port}"]},
            "mission": {
                "vehicles": 2,
                "any_vehicles": True,
                "origin_deg": (48.3, 14.3, 260.0),
                "area_enu_m": ((-50, 0), (50, 0), (50, 100), (-50, 100)),
            },
            "api": {"port": port, "operator_code_file": folder / "code.txt", "plans_folder": folder / "plans"},
            "deadlines": {"connect_s": 3600},
            "record": {"folder": folder / "missions"},
        },
        source="benchmark",
    )
    # Processes are started before the service: forking stops this process, in which the flight loop runs.
    begin, answers = multiprocessing.Event(), multiprocessing.Queue()
    others = [multiprocessing.Process(target=operate, args=(port, duration_s / 2, begin, answers), daemon=True)]
    for number in range(ATTACKERS):
        share = connections // ATTACKERS
        others.append(multiprocessing.Process(target=attack, args=(port, number, share, begin, answers), daemon=True))
    vehicles = fly_later(link_port, (duration_s / 3, duration_s))
    for other in others:
        other.start()
    async with open_service(config) as service, asyncio.TaskGroup() as group:
        flying = group.create_task(service.run())
        await asyncio.sleep(SETTLE_S)
        await measure("without connections", *vehicles[0])
        begin.set()
        gap_s, lag_ms = await measure(f"with {connections} connections", *vehicles[1])
        while not answers.empty():
            answer = answers.get()
            if isinstance(answer, str):
                print(answer)
                continue
            for way, held_ms in zip(("hold", "hold_on_stream"), answer, strict=True):
                print(f"{way}: median {statistics.median(held_ms):.0f} ms, max {max(held_ms):.0f} ms of {len(held_ms)}")
                report(f"connections.{way}", max(held_ms))
        for other in others:
            other.kill()
        report("connections.lag", lag_ms)
        report("connections.gap", gap_s)
        flying.cancel()


def fly_later(link_port: int, durations_s: Sequence[float]) -> list[Flight]:
    """Start a process that is one vehicle in several flights; return their events, and where their gaps come."""
    flights = [(multiprocessing.Event(), multiprocessing.Queue()) for _ in durations_s]
    multiprocessing.Process(target=fly_when, args=(link_port, flights, durations_s), daemon=True).start()
    return flights


def fly_when(link_port: int, flights: Sequence[Flight], durations_s: Sequence[float]) -> None:
    """Be a vehicle, each time once an event is set."""
    vehicle = FlyingVehicle(link_port)
    for (begin, gaps), duration_s in zip(flights, durations_s, strict=True):
        begin.wait()
        gaps.put(vehicle.gaps_s(duration_s))


async def measure(name: str, begin: Event, gaps: Queue[list[float]]) -> tuple[float, float]:
    """Return the largest gap between heartbeats at a vehicle, and the 99th percentile of the loop's lag."""
    monitor = LoopMonitor()
    lagging = asyncio.create_task(monitor.run(lambda _: None))
    begin.set()
    gap_s = max(await asyncio.to_thread(gaps.get))
    lagging.cancel()
    lag_ms, most_ms = monitor.lag_p99_ms(), max(monitor._lags_ms)
    print(f"{name}: heartbeats at most {gap_s:.2f} s apart, lag p99 {lag_ms:.1f} ms, max {most_ms:.1f} ms")
    return gap_s, lag_ms


def operate(port: int, duration_s: float, begin: Event, answers: Queue[Answer]) -> None:
    """Sign in before the attack, and hold all in the middle of it, by a request and by the open event stream."""
    url = f"http://{HOST}:{port}"
    with httpx.Client(base_url=url, timeout=30.0) as client:
        while True:
            try:
                client.post("/api/session", json={"code": CODE, "name": "Ada"}).raise_for_status()
                break
            except httpx.TransportError:
                time.sleep(0.2)
        cookies = client.cookies
        client.get("/api/mission")  # as the page does all the time: an operator's address is known by then
    cookie = "; ".join(f"{name}={value}" for name, value in cookies.items())
    by_request_ms, by_stream_ms = list[float](), list[float]()
    with connect(f"ws://{HOST}:{port}/api/events", additional_headers={"Cookie": cookie}) as stream:
        begin.wait()
        end_s = time.perf_counter() + duration_s
        while time.perf_counter() < end_s:
            time.sleep(HOLD_EVERY_S)
            by_stream_ms.append(timed_ms(lambda: hold_by_stream(stream, f"stream-{len(by_stream_ms):04}")))
            by_request_ms.append(timed_ms(lambda: hold_by_request(url, cookies)))
            print(f"  by request {by_request_ms[-1]:.0f} ms, by stream {by_stream_ms[-1]:.0f} ms", flush=True)
    answers.put((by_request_ms, by_stream_ms))


def timed_ms(hold: Callable[[], None]) -> float:
    """Return how long a hold has taken; infinity where it was not answered."""
    start_s = time.perf_counter()
    try:
        hold()
    except (httpx.HTTPError, WebSocketException, TimeoutError) as error:
        print(f"a hold was not answered: {error!r}", flush=True)
        return math.inf
    return 1e3 * (time.perf_counter() - start_s)


def hold_by_request(url: str, cookies: httpx.Cookies) -> None:
    """Hold by a new connection."""
    with httpx.Client(base_url=url, cookies=cookies, timeout=10.0) as client:
        client.post("/api/mission/actions", json={"action": "hold"})


def hold_by_stream(stream: ClientConnection, request_id: str) -> None:
    """Hold by a stream that is open."""
    stream.send(json.dumps({"kind": "hold", "request_id": request_id}))
    while json.loads(stream.recv(timeout=10.0)).get("request_id") != request_id:
        pass


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--connections", type=int, default=5000)
    parser.add_argument("--seconds", type=float, default=15.0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as directory:
        asyncio.run(main(arguments.connections, arguments.seconds, Path(directory)))
