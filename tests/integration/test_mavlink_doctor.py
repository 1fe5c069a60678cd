"""``aos-gcs doctor`` on real sockets."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from aos_drivers.links.address import parse_link
from aos_drivers.mavlink.doctor.command import examine
from aos_drivers.mavlink.doctor.diagnosis import Level, diagnose
from aos_gcs.cli import main
from aos_gcs.clock import LoopClock
from tests.fakes.mavlink_vehicle import FakeVehicle

HOST = "127.0.0.1"
SPEED = 8.0


@pytest.fixture(autouse=True)
def no_usual_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the ports of this computer to whoever uses them."""
    monkeypatch.setattr("aos_drivers.mavlink.doctor.command._USUAL_PORTS", ())


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


@contextmanager
def vehicle_sending_to(port: int, period_s: float) -> Iterator[None]:
    """A vehicle that sends everything each ``period_s``, until left."""
    stop = threading.Event()

    def send() -> None:
        vehicle = FakeVehicle(1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            while not stop.wait(period_s):
                link.sendto(vehicle.telemetry(), (HOST, port))

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


async def test_a_vehicle_on_a_socket_is_healthy() -> None:
    port = free_port()
    with vehicle_sending_to(port, 0.005):
        examination = await examine([parse_link(f"udpin://{HOST}:{port}")], 254, 5.0, LoopClock(SPEED))
    findings = diagnose(examination)
    assert [finding.code for finding in findings] == ["vehicle"]


async def test_a_vehicle_that_sends_to_another_usual_port_is_found_there(monkeypatch: pytest.MonkeyPatch) -> None:
    other = free_port()
    monkeypatch.setattr("aos_drivers.mavlink.doctor.command._USUAL_PORTS", (other,))
    with vehicle_sending_to(other, 0.005):
        examination = await examine([parse_link(f"udpin://{HOST}:{free_port()}")], 254, 5.0, LoopClock(SPEED))
    assert examination.elsewhere == [other]
    assert [finding.code for finding in diagnose(examination)] == ["no_packets", "wrong_port"]


def run(arguments: list[str]) -> int | str | None:
    with pytest.raises(SystemExit) as left:
        main(["doctor", *arguments])
    return left.value.code


def test_exit_codes_and_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("aos_drivers.mavlink.doctor.command.LoopClock", lambda: LoopClock(SPEED))
    port = free_port()
    link = f"udpin://{HOST}:{port}"
    with vehicle_sending_to(port, 0.005):
        assert run([link, "--seconds", "5", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["healthy"] is True
    assert [finding["level"] for finding in told["findings"]] == [Level.OK]
    assert run([link, "--seconds", "5"]) == 1
    assert f"PROBLEM nothing arrives on {link}" in capsys.readouterr().out


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
