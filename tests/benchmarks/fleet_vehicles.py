"""Vehicles for measurements of commands, each kind in a process of its own."""

from __future__ import annotations

import asyncio
import multiprocessing
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.mavlink_vehicle import COPTER_GUIDED, FakeVehicle

HOST = "127.0.0.1"
PERIOD_S = 0.2
MOVING = frozenset({mavlink.MAV_CMD_DO_REPOSITION, mavlink.MAV_CMD_DO_SET_MODE})


def hover(
    port: int, count: int, silent: int, answer_s: float, arrivals: multiprocessing.Queue[tuple[int, float]]
) -> None:
    """Be vehicles in the air, each with a socket; the last ``silent`` answer nothing. Report when commands come."""

    async def run() -> None:
        loop = asyncio.get_running_loop()
        for number in range(1, count + 1):
            vehicle = FakeVehicle(number)
            vehicle.custom_mode, vehicle.armed, vehicle.landed = COPTER_GUIDED, True, mavlink.MAV_LANDED_STATE_IN_AIR
            vehicle.height_m = 30.0 + 2.0 * number
            vehicle.longitude_deg += 8.0 * number / 74_000.0
            vehicle.velocity_ned_cmps = (0, 0, 0)
            await loop.create_datagram_endpoint(
                lambda vehicle=vehicle: _Hovering(vehicle, vehicle.system_id > count - silent, answer_s, arrivals),
                remote_addr=(HOST, port),
            )
        await asyncio.Event().wait()

    asyncio.run(run())


class _Hovering(asyncio.DatagramProtocol):
    def __init__(
        self, vehicle: FakeVehicle, is_silent: bool, answer_s: float, arrivals: multiprocessing.Queue[tuple[int, float]]
    ) -> None:
        self._vehicle = vehicle
        self._is_silent = is_silent
        self._answer_s = answer_s
        self._arrivals = arrivals

    def connection_made(self, transport: asyncio.DatagramTransport) -> None:  # type: ignore[override]
        self._transport = transport
        self._talk()

    def _talk(self) -> None:
        self._transport.sendto(self._vehicle.telemetry())
        asyncio.get_running_loop().call_later(PERIOD_S, self._talk)

    def error_received(self, exc: Exception) -> None:
        """Nobody listens yet."""

    def datagram_received(self, data: bytes, _address: tuple[str, int]) -> None:
        known = len(self._vehicle.commands)
        answers = self._vehicle.hear(data)
        for command in self._vehicle.commands[known:]:
            # mavsdk sends to all what is meant for one.
            if command.command in MOVING and command.target_system == self._vehicle.system_id:
                self._arrivals.put((self._vehicle.system_id, time.monotonic()))
        if answers and not self._is_silent:
            asyncio.get_running_loop().call_later(self._answer_s, self._transport.sendto, answers)


def simulate(port: int, count: int) -> None:
    """Be simulated autopilots with cameras."""

    async def run() -> None:
        options = SwarmOptions(vehicles=count, links=(f"udpout://{HOST}:{port}",), image_size_px=32, start_up_s=1.0)
        async with SimulatedSwarm(options, CheckerboardGround()):
            await asyncio.Event().wait()

    asyncio.run(run())


def chatter(port: int, count: int, rate_hz: float) -> None:
    """Be vehicles on the ground that send ``rate_hz`` messages per second each."""
    fleet = [(FakeVehicle(number), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for number in range(1, count + 1)]
    period_s = 8 / rate_hz  # telemetry() is about eight messages
    while True:
        due_s = time.monotonic() + period_s
        for vehicle, link in fleet:
            link.sendto(vehicle.telemetry(), (HOST, port))
        time.sleep(max(0.0, due_s - time.monotonic()))


@contextmanager
def other_process(target: Callable[..., None], *arguments: object) -> Iterator[None]:
    process = multiprocessing.Process(target=target, args=arguments, daemon=True)
    process.start()
    try:
        yield
    finally:
        process.terminate()
        process.join()
