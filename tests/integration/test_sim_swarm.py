"""The simulated swarm over real sockets, and as a process of its own."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import sys
from contextlib import closing
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import LinkError
from aos_sim.__main__ import main
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.packets import Parser
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from tests.fakes.program import gone, unused_port
from tests.fakes.sim_errors import POSITIONS_ERR
from tests.timing import scaled_s

HOST = "127.0.0.1"


def udp_socket() -> socket.socket:
    receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    receiver.bind((HOST, 0))
    receiver.setblocking(False)
    return receiver


def small(link: str, **changes) -> SwarmOptions:
    values = {"vehicles": 2, "links": (link,), "speed": 10.0, "image_size_px": 32, "start_up_s": 0.0}
    return SwarmOptions(**{**values, "errors": POSITIONS_ERR, **changes})


def packed(message) -> bytes:
    return message.pack(mavlink.MAVLink(None, 254, 190))


def heartbeat() -> bytes:
    kind = (mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3)
    return packed(mavlink.MAVLink_heartbeat_message(*kind))


async def receive(receiver: socket.socket) -> tuple[list, tuple]:
    data, address = await asyncio.get_running_loop().sock_recvfrom(receiver, 4096)
    return Parser().feed(data), address


async def test_each_vehicle_has_a_port_of_its_own_and_answers_there():
    with closing(udp_socket()) as receiver:
        port = receiver.getsockname()[1]
        async with SimulatedSwarm(small(f"udpout://{HOST}:{port}"), CheckerboardGround()) as swarm:
            ports: dict[int, set] = {}
            async with asyncio.timeout(scaled_s(30)):
                while len(ports) < 2:
                    messages, address = await receive(receiver)
                    for message in messages:
                        ports.setdefault(message.get_srcSystem(), set()).add(address)
            assert all(len(addresses) == 1 for addresses in ports.values())
            assert ports[1] != ports[2]
            arm = mavlink.MAVLink_command_long_message(2, 1, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1, *[0.0] * 6)
            for address in ports[1] | ports[2]:
                receiver.sendto(packed(arm), address)
            async with asyncio.timeout(scaled_s(30)):
                while True:
                    messages, _ = await receive(receiver)
                    acks = [m for m in messages if m.get_type() == "COMMAND_ACK"]
                    if acks:
                        break
            assert [(ack.get_srcSystem(), ack.result) for ack in acks] == [(2, mavlink.MAV_RESULT_ACCEPTED)]
            assert not swarm.vehicle(1).autopilot.flight.armed
            assert swarm.vehicle(2).autopilot.flight.armed


async def test_listening_vehicles_answer_whoever_spoke():
    base = unused_port()
    async with SimulatedSwarm(small(f"udpin://{HOST}:{base}", vehicles=1), CheckerboardGround()):
        with closing(udp_socket()) as receiver:
            receiver.sendto(b"\xfd garbage that is no message" + heartbeat(), (HOST, base))
            async with asyncio.timeout(scaled_s(30)):
                messages, _ = await receive(receiver)
            assert {message.get_srcSystem() for message in messages} == {1}


async def test_tcp_both_ways():
    heard: asyncio.Queue[int] = asyncio.Queue(100)

    async def listen(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        parser = Parser()
        while data := await reader.read(4096):
            for message in parser.feed(data):
                if not heard.full():
                    heard.put_nowait(message.get_srcSystem())
        writer.close()

    port = unused_port(socket.SOCK_STREAM)
    server = await asyncio.start_server(listen, HOST, port)
    async with server, SimulatedSwarm(small(f"tcpout://{HOST}:{port}"), CheckerboardGround()):
        async with asyncio.timeout(scaled_s(30)):
            seen: set[int] = set()
            while len(seen) < 2:
                seen.add(await heard.get())
        assert seen == {1, 2}
    async with SimulatedSwarm(small(f"tcpin://{HOST}:{port}", vehicles=1), CheckerboardGround()):
        reader, writer = await asyncio.open_connection(HOST, port)
        writer.write(heartbeat())
        async with asyncio.timeout(scaled_s(30)):
            assert Parser().feed(await reader.read(4096))[0].get_srcSystem() == 1
        writer.close()
        await writer.wait_closed()


async def test_taken_ports_are_named():
    with closing(udp_socket()) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(LinkError, match=f"udpin://{HOST}:{port}"):
            async with SimulatedSwarm(small(f"udpin://{HOST}:{port}", vehicles=1), CheckerboardGround()):
                pass
    with closing(socket.create_server((HOST, 0))) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(LinkError, match="--http-port"):
            async with SimulatedSwarm(small(f"udpout://{HOST}:1", http_port=port), CheckerboardGround()):
                pass


async def test_error_of_the_body_is_not_wrapped():
    with pytest.raises(KeyError):
        async with SimulatedSwarm(small(f"udpout://{HOST}:1"), CheckerboardGround()):
            raise KeyError


class Process:
    """``python -m aos_sim`` with its files in a folder."""

    def __init__(self, folder: Path, port: int) -> None:
        self.world, self.report = folder / "world.json", folder / "report.json"
        self.arguments = [
            *("-m", "aos_sim", "--vehicles", "2", "--speed", "5", "--no-render", "--trees-per-ha", "20"),
            *("--link", f"udpout://{HOST}:{port}", "--world-file", str(self.world), "--report-file", str(self.report)),
        ]


async def test_process_writes_its_files_and_ends_cleanly_on_a_signal(tmp_path):
    with closing(udp_socket()) as receiver:
        sim = Process(tmp_path, receiver.getsockname()[1])
        process = await asyncio.create_subprocess_exec(sys.executable, *sim.arguments)
        async with asyncio.timeout(scaled_s(60)):
            await receive(receiver)
            world = json.loads(sim.world.read_text())
            process.send_signal(signal.SIGTERM)
            assert await process.wait() == 0
    scene = {"seed", "trees_per_ha", "animals", "stones", "stumps", "cloths", "waters", "conditions"}
    persons = {"persons", "posture", "dressed", "in_pairs", "walking_mps", "terrain", "targets"}
    assert set(world) == scene | persons | {"origin", "start_utc_s", "area_enu_m", "vehicles"}
    assert world["origin"] == {"latitude_deg": 48.3, "longitude_deg": 14.3, "altitude_amsl_m": 260.0}
    assert len(world["targets"][0]["position_enu_m"]) == 3
    assert [vehicle["system_id"] for vehicle in world["vehicles"]] == [1, 2]
    report = json.loads(sim.report.read_text())
    assert report["landed"] == 2
    assert report["min_separation_m"] == pytest.approx(5.0)
    assert report["sim_time_s"] > 0.0


async def test_process_ends_with_its_parent(tmp_path):
    with closing(udp_socket()) as receiver:
        sim = Process(tmp_path, receiver.getsockname()[1])
        starter = (
            "import subprocess, sys; print(subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL).pid); input()"
        )
        parent = await asyncio.create_subprocess_exec(
            *(sys.executable, "-c", starter, sys.executable, *sim.arguments, "--exit-with-parent"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        async with asyncio.timeout(scaled_s(60)):
            child = int(await parent.stdout.readline())
            await receive(receiver)
            parent.stdin.close()
            await parent.wait()
            await gone(child)
    assert json.loads(sim.report.read_text())["landed"] == 2


async def test_wrong_input_of_the_process_gives_a_sentence_and_exit_code_2():
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "aos_sim", "--no-render", "--vehicles", "0"),
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "NO_COLOR": "1"},
    )
    _, errors = await process.communicate()
    assert process.returncode == 2
    assert "--vehicles must lie within 1 and 100" in errors.decode()
    assert len(errors.decode().splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--link", "udp:14550"], "KIND://HOST:PORT"),
        (["--origin", "48,14"], "LAT,LON,ALT"),
        (["--param", "RTL_ALT"], "NAME=VALUE"),
        (["--errors", "exact"], "--errors must be one of none, rtk, gnss, got 'exact'"),
        (["--wind", "-1"], "--wind must lie within 0 and 50 m/s, got -1"),
    ],
)
def test_wrong_options_are_named(arguments, sentence, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["aos_sim", "--no-render", *arguments])
    with pytest.raises(SystemExit, match="2"):
        main()
    assert sentence in capsys.readouterr().err
