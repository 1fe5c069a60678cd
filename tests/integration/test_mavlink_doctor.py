"""``aos-gcs doctor`` as a command, and what it finds in traffic over links; in virtual time."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Coroutine
from typing import TypeVar

import looptime
import pytest

from aos_drivers.links.address import parse_link
from aos_drivers.mavlink.doctor.command import examine
from aos_drivers.mavlink.doctor.diagnosis import Level, diagnose
from aos_gcs.clock import LoopClock
from tests.fakes.air import HOST, Air
from tests.fakes.command_line import exit_status
from tests.fakes.mavlink_vehicle import FakeVehicle
from tests.fakes.mission_flight import InlineExecutor

T = TypeVar("T")
PORT, OTHER_PORT = 14550, 14540


async def beside_a_vehicle(work: Coroutine[object, object, T], port: int | None) -> T:
    """Do the work while a vehicle sends everything to ``port``, ten times a second, if there is one."""
    loop = asyncio.get_running_loop()
    Air().install(loop)
    loop.set_default_executor(InlineExecutor(1))
    if port is None:
        return await work
    transport, _ = await loop.create_datagram_endpoint(asyncio.DatagramProtocol, remote_addr=(HOST, port))
    vehicle = FakeVehicle(1)

    async def send() -> None:
        while True:
            transport.sendto(vehicle.telemetry())
            await asyncio.sleep(0.1)

    sending = asyncio.create_task(send())
    try:
        return await work
    finally:
        sending.cancel()


@pytest.mark.looptime
async def test_a_vehicle_on_the_link_is_healthy() -> None:
    work = examine([parse_link(f"udpin://{HOST}:{PORT}")], 254, 5.0, LoopClock())
    findings = diagnose(await beside_a_vehicle(work, PORT))
    assert [finding.code for finding in findings] == ["vehicle"]


@pytest.mark.looptime
async def test_a_vehicle_that_sends_to_another_usual_port_is_found_there() -> None:
    work = examine([parse_link(f"udpin://{HOST}:{PORT}")], 254, 5.0, LoopClock())
    examination = await beside_a_vehicle(work, OTHER_PORT)
    assert examination.elsewhere == [OTHER_PORT]
    assert [finding.code for finding in diagnose(examination)] == ["no_packets", "wrong_port"]


def run(arguments: list[str]) -> int | str | None:
    return exit_status(["doctor", *arguments])


@pytest.mark.parametrize("port", [PORT, None])
def test_exit_codes_text_and_json(
    port: int | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run_in_virtual_time(work: Coroutine[object, object, T]) -> T:
        loop = looptime.new_event_loop()
        try:
            return loop.run_until_complete(beside_a_vehicle(work, port))
        finally:
            loop.close()

    monkeypatch.setattr(asyncio, "run", run_in_virtual_time)
    link = f"udpin://{HOST}:{PORT}"
    is_healthy = port is not None
    assert run([link, "--seconds", "5", "--json"]) == int(not is_healthy)
    told = json.loads(capsys.readouterr().out)
    assert told["healthy"] is is_healthy
    assert [finding["level"] for finding in told["findings"]] == [Level.OK if is_healthy else Level.PROBLEM]
    assert run([link, "--seconds", "5"]) == int(not is_healthy)
    text = "No problems found." if is_healthy else f"PROBLEM nothing arrives on {link}"
    assert text in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nonsense"], "cannot be understood"),
        (["serial:///dev/no-such-radio:57600"], "does not exist: connect the radio"),
        ([f"udpin://{HOST}:14550?sign=/no/such.key"], "cannot be read"),
    ],
)
def test_what_cannot_start_is_a_sentence_and_exit_code_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(arguments) == 2
    assert words in capsys.readouterr().err


def test_a_taken_port_is_exit_code_2(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind((HOST, 0))
        assert run([f"udpin://{HOST}:{taken.getsockname()[1]}"]) == 2
    assert "is in use: stop the other ground station" in capsys.readouterr().err
