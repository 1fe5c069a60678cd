"""``aos-gcs run`` as a process of its own: without vehicles, told to end, and with a simulated swarm."""

from __future__ import annotations

import signal
import socket
from pathlib import Path

import pytest

from aos_gcs.mission.model import Outcome, Phase, Task
from aos_gcs.store.reader import MissionReader
from tests.fakes.program import running

CONFIGURATION = """
clock_speed = {speed}
[link]
urls = ["udpin://127.0.0.1:{port}"]
[mission]
vehicles = 3
area_deg = [[48.30007, 14.29966], [48.30007, 14.30034], [48.30079, 14.30034], [48.30079, 14.29966]]
origin_deg = [48.3, 14.3, 260.0]
auto_start = true
auto_return = true
[preflight]
upload_fence = true
[deadlines]
connect_s = {connect_s}
capture_s = {capture_s}
[safety]
max_link_age_s = {age_s}
max_position_age_s = {age_s}
[api]
enabled = false
[record]
folder = "{folder}"
"""


@pytest.fixture
def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


def write_file(folder: Path, port: int, *, connect_s: float, speed: float = 1.0) -> str:
    file = folder / "mission.toml"
    text = CONFIGURATION.format(
        port=port,
        speed=speed,
        connect_s=connect_s,
        capture_s=20.0 * speed,
        age_s=3.0 * speed,
        folder=(folder / "missions").as_posix(),
    )
    file.write_text(text, encoding="utf-8")
    return str(file)


async def test_without_vehicles_it_ends_on_the_ground_and_says_so(tmp_path: Path, free_port: int) -> None:
    async with running(tmp_path, "run", write_file(tmp_path, free_port, connect_s=0.5)) as program:
        assert await program.ended(60) == 1
    assert program.output.startswith("failed: ")
    assert "0 of 3" in program.output
    assert str(program.mission_folder) in program.output
    assert "Traceback" not in program.log
    with MissionReader(program.mission_folder) as reader:
        outcome, final = reader.outcome(), reader.last_snapshot()
    assert outcome is not None
    assert outcome.outcome is Outcome.FAILED
    assert final is not None
    assert final.phase is Phase.DONE


async def test_told_to_end_it_does_so_quietly(tmp_path: Path, free_port: int) -> None:
    async with running(tmp_path, "run", write_file(tmp_path, free_port, connect_s=60.0)) as program:
        await program.until(lambda: list(program.missions.glob("*/mission.sqlite")) != [], 60)
        program.stop(signal.SIGTERM)
        assert await program.ended(30) == 128 + signal.SIGTERM
    assert "Traceback" not in program.log


@pytest.mark.slow
async def test_a_simulated_swarm_is_led_like_any_other(tmp_path: Path, free_port: int) -> None:
    link, speed = f"udpout://127.0.0.1:{free_port}", 10.0
    world = ("--trees-per-ha", "30", "--seed", "2", "--image-size", "192")
    service_file = write_file(tmp_path, free_port, connect_s=60.0 * speed, speed=speed)
    async with (
        running(tmp_path / "sim", "sim", "--vehicles", "3", "--link", link, "--speed", str(speed), *world),
        running(tmp_path, "run", service_file) as program,
    ):
        assert await program.ended(110) == 0, program.log
    assert program.output.startswith("found: ")
    with MissionReader(program.mission_folder) as reader:
        final = reader.last_snapshot()
    assert final is not None
    assert [vehicle.task for vehicle in final.vehicles] == [Task.LANDED] * 3
