"""Load of the MAVLink driver: vehicles on one UDP port, without commands; then its session beside a bare parser.

Run: python tests/benchmarks/bench_mavlink.py [--vehicles 100] [--rate 20] [--seconds 10]
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import socket
import sys
import time
from collections.abc import Callable
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

HOST = "127.0.0.1"
LAG_PERIOD_S = 0.005
ROUNDS = 5
KEY = bytes(range(32))
UTC_S = 1_800_000_000.0


def send_telemetry(port: int, vehicles: int, rate_hz: float, duration_s: float) -> None:
    """Send a heartbeat each second and positions at ``rate_hz``, from one socket per vehicle."""
    fleet = [
        (FakeVehicle(number), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for number in range(1, vehicles + 1)
    ]
    start_s = time.perf_counter()
    for tick in range(round(duration_s * rate_hz)):
        for vehicle, link in fleet:
            vehicle.boot_ms += round(1000 / rate_hz)
            link.sendto(vehicle.heartbeat() if tick % round(rate_hz) == 0 else vehicle.position(), (HOST, port))
        time.sleep(max(0.0, start_s + (tick + 1) / rate_hz - time.perf_counter()))
    for _vehicle, link in fleet:
        link.close()


async def measure_lag(lags_s: list[float]) -> None:
    while True:
        before_s = time.perf_counter()
        await asyncio.sleep(LAG_PERIOD_S)
        lags_s.append(time.perf_counter() - before_s - LAG_PERIOD_S)


async def main(vehicles: int, rate_hz: float, duration_s: float) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((HOST, 0))
        port = probe.getsockname()[1]
    context = DriverContext(LoopClock(), lambda: True, lambda _notice: None)
    lags_s: list[float] = []
    async with open_mavlink([f"udpin://{HOST}:{port}"], context) as fleet:
        sender = multiprocessing.Process(target=send_telemetry, args=(port, vehicles, rate_hz, duration_s))
        sender.start()
        while not fleet.vehicles():  # noqa: ASYNC110 - vehicles appear by themselves
            await asyncio.sleep(0.01)
        lag = asyncio.create_task(measure_lag(lags_s))
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        await asyncio.to_thread(sender.join)
        wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
        lag.cancel()
        losses = [vehicle.state.packet_loss_fraction or 0.0 for vehicle in fleet.vehicles().values()]
        offered = vehicles * rate_hz * duration_s
        print(f"vehicles heard      {len(losses)} of {vehicles}")
        print(f"messages offered    {offered / wall_s:.0f}/s for {wall_s:.1f} s, loss {100 * np.mean(losses):.2f} %")
        print(f"CPU of the driver   {100 * cpu_s / wall_s:.1f} % of one core")
        print(f"event loop lag      p50 {1e3 * np.median(lags_s):.2f} ms, p99 {1e3 * np.percentile(lags_s, 99):.2f} ms")


def parse_bare(packets: list[tuple[PeerAddress, bytes]]) -> None:
    parsers = {peer: mavlink.MAVLink(None) for peer, _packet in packets}
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
    arguments = parser.parse_args()
    asyncio.run(main(arguments.vehicles, arguments.rate, arguments.seconds))
    compare_with_bare_parser(arguments.vehicles, arguments.rate)
