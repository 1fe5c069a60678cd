"""Load of the MAVLink driver: vehicles on one UDP port, without commands; then its session beside a bare parser.

The driver checks signatures and records all packets. Beside it, in turn, pymavlink's parser alone reads packets from an
asyncio socket, without signatures and records.

Run: python tests/benchmarks/bench_mavlink.py [--vehicles 100] [--rate 20] [--seconds 10] [--rounds 3]
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import socket
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.synchronize import Event
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.links.address import PeerAddress
from aos_drivers.mavlink import open_mavlink
from aos_drivers.mavlink.session import MavlinkSession
from aos_drivers.mavlink.signing.signer import LinkSigner, SigningClock
from aos_gcs.clock import LoopClock
from aos_gcs.ports import DriverContext
from tests.fakes.mavlink_vehicle import FakeVehicle

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.benchmarks.figures import report
from tests.fakes.program import unused_port

SPAWN = multiprocessing.get_context("spawn")
HOST = "127.0.0.1"
LAG_PERIOD_S = 0.005
ROUNDS = 5
KEY = bytes(range(32))
UTC_S = 1_800_000_000.0


@dataclass(frozen=True, slots=True)
class Load:
    """Messages that are sent."""

    vehicles: int
    rate_hz: float
    duration_s: float


def send_telemetry(port: int, load: Load, is_signed: bool, begun: Event) -> None:
    """Send a heartbeat each second and positions at the load's rate, from a socket per vehicle; tell after a second.

    The vehicles send one after the other, evenly spread over a period: real ones do not keep step.
    """
    fleet = [
        (FakeVehicle(number), socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        for number in range(1, load.vehicles + 1)
    ]
    for vehicle, _link in fleet:
        if is_signed:
            vehicle.encoder.sign(KEY, time.time())
    start_s = time.perf_counter()
    for tick in range(round(load.duration_s * load.rate_hz)):
        for number, (vehicle, link) in enumerate(fleet):
            due_s = start_s + (tick + number / load.vehicles) / load.rate_hz
            time.sleep(max(0.0, due_s - time.perf_counter()))
            vehicle.boot_ms += round(1000 / load.rate_hz)
            link.sendto(vehicle.heartbeat() if tick % round(load.rate_hz) == 0 else vehicle.position(), (HOST, port))
        if tick == round(load.rate_hz):
            begun.set()
    for _vehicle, link in fleet:
        link.close()


async def measure_lag(lags_s: list[float]) -> None:
    while True:
        before_s = time.perf_counter()
        await asyncio.sleep(LAG_PERIOD_S)
        lags_s.append(time.perf_counter() - before_s - LAG_PERIOD_S)


async def cpu_share(port: int, load: Load, *, is_signed: bool) -> float:
    """Return the share of a core that this process takes while ``load`` is sent to ``port``."""
    begun = SPAWN.Event()
    sender = SPAWN.Process(target=send_telemetry, args=(port, load, is_signed, begun))
    sender.start()
    try:
        await asyncio.to_thread(begun.wait)
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        await asyncio.sleep(load.duration_s - 2.0)
        return (time.process_time() - cpu_s) / (time.perf_counter() - wall_s)
    finally:
        await asyncio.to_thread(sender.join)


async def driver_share(load: Load, folder: Path, lags_s: list[float] | None = None) -> tuple[float, float]:
    """Return the driver's share of a core, with signatures and records, and the share of packets that it lost.

    ``lags_s`` takes the lags of the event loop. To measure them needs processor time, too, which then is in the share.
    """
    key_file = folder / "key"
    key_file.touch(mode=0o600)
    key_file.write_bytes(KEY)
    port = unused_port()
    context = DriverContext(LoopClock(), lambda: True, lambda _notice: None, log_folder=folder)
    async with open_mavlink([f"udpin://{HOST}:{port}?sign={key_file}"], context) as fleet:
        lag = None if lags_s is None else asyncio.create_task(measure_lag(lags_s))
        share = await cpu_share(port, load, is_signed=True)
        if lag is not None:
            lag.cancel()
        losses = [vehicle.state.packet_loss_fraction or 0.0 for vehicle in fleet.vehicles().values()]
        assert len(losses) == load.vehicles, f"{len(losses)} of {load.vehicles} vehicles heard"
    return share, float(np.mean(losses))


class BareReader(asyncio.DatagramProtocol):
    """A reader as short as it can be: pymavlink's own parser, one per sender."""

    def __init__(self) -> None:
        self._parsers: dict[tuple[str, int], mavlink.MAVLink] = {}

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        parser = self._parsers.get(addr)
        if parser is None:
            parser = self._parsers[addr] = mavlink.MAVLink(None)
        parser.parse_buffer(data)


async def bare_share(load: Load) -> float:
    """Return the share of a core that the bare reader takes."""
    loop = asyncio.get_running_loop()
    transport, _protocol = await loop.create_datagram_endpoint(BareReader, local_addr=(HOST, 0))
    try:
        return await cpu_share(transport.get_extra_info("sockname")[1], load, is_signed=False)
    finally:
        transport.close()


async def main(load: Load, rounds: int) -> None:
    lags_s: list[float] = []
    shares, losses = [], []
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as folder:
            ours, loss = await driver_share(load, Path(folder))
        shares.append((ours, await bare_share(load)))
        losses.append(loss)
    with tempfile.TemporaryDirectory() as folder:
        await driver_share(load, Path(folder), lags_s)
    ours, bare = np.median(shares, axis=0)
    print(
        f"{load.vehicles} vehicles, {load.rate_hz:g} messages/s each, {load.duration_s:g} s, loss {np.max(losses):.2%}"
    )
    print(f"driver, signed and recorded  {ours:.1%} of one core (median of {rounds} rounds)")
    print(f"bare asyncio reader          {bare:.1%}; the driver takes {ours / bare:.2f} of it")
    report("mavlink.driver", float(100 * ours), ratio=float(ours / bare))
    p50_ms, p99_ms = 1e3 * np.percentile(lags_s, (50, 99))
    print(f"event loop lag               p50 {p50_ms:.2f} ms, p99 {p99_ms:.2f} ms")


def parse_bare(packets: list[tuple[PeerAddress, bytes]]) -> None:
    parsers = {peer: mavlink.MAVLink(None) for peer in dict(packets)}
    for peer, packet in packets:
        parsers[peer].parse_buffer(packet)


def feed_session(packets: list[tuple[PeerAddress, bytes]], *, key: bytes | None = None) -> None:
    signers = {0: LinkSigner(0, key, SigningClock(lambda: UTC_S, 0), accepts_unsigned=False)} if key else {}
    session = MavlinkSession(254, 5.0, signers)
    for number, (peer, packet) in enumerate(packets):
        session.feed(packet, peer, number * 5e-4)


def cpu_us_per_message(
    work: Callable[[list[tuple[PeerAddress, bytes]]], None], packets: list[tuple[PeerAddress, bytes]]
) -> float:
    start_s = time.process_time()
    work(packets)
    return 1e6 * (time.process_time() - start_s) / len(packets)


def compare_with_bare_parser(vehicles: int, rate_hz: float) -> None:
    """Print the CPU time per message of the session, unsigned and signed, beside that of pymavlink's parser alone."""
    fleet = [(PeerAddress(0, HOST, number), FakeVehicle(number)) for number in range(1, vehicles + 1)]

    def record() -> list[tuple[PeerAddress, bytes]]:
        return [
            (peer, vehicle.heartbeat() if tick % round(rate_hz) == 0 else vehicle.position())
            for tick in range(round(5 * rate_hz))
            for peer, vehicle in fleet
        ]

    plain = record()
    for _peer, vehicle in fleet:
        vehicle.encoder.sign(KEY, UTC_S)
    signed = record()
    rounds = [
        (
            cpu_us_per_message(parse_bare, plain),
            cpu_us_per_message(feed_session, plain),
            cpu_us_per_message(lambda packets: feed_session(packets, key=KEY), signed),
        )
        for _ in range(ROUNDS)
    ]
    bare_us, session_us, signed_us = np.median(rounds, axis=0)
    report("mavlink.message", float(session_us), ratio=float(session_us / bare_us))
    print(f"bare pymavlink parser  {bare_us:.1f} us per message (medians of {ROUNDS} rounds, {len(plain)} messages)")
    for name, cost_us in (("session", session_us), ("session, signed", signed_us)):
        share = 100 * cost_us * 1e-6 * vehicles * rate_hz
        print(f"{name:22} {cost_us:.1f} us per message, {cost_us / bare_us:.2f} of it, {share:.1f} % of one core")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=100)
    parser.add_argument("--rate", type=float, default=20.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    asyncio.run(main(Load(arguments.vehicles, arguments.rate, arguments.seconds), arguments.rounds))
    compare_with_bare_parser(arguments.vehicles, arguments.rate)
