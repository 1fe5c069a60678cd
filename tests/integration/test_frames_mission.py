"""A whole mission on frames that the autopilots report and a companion computer drops into folders."""

from __future__ import annotations

from pathlib import Path

import pytest

from aos_gcs.mission.model.vehicles import Task
from aos_gcs.store.reader import MissionReader
from tests.fakes.program import running, unused_port

SPEED = 10.0
CONFIGURATION = """
clock_speed = {speed}
[link]
urls = ["udpin://127.0.0.1:{port}"]
[link.options.camera]
source = "reported"
folder = "{images}/{{vehicle_id}}"
file_name = "{{index:05d}}.tiff"
carrier = "level"
fov_deg = 50
[mission]
vehicles = 3
any_vehicles = true
area_deg = [[48.30007, 14.29966], [48.30007, 14.30034], [48.30079, 14.30034], [48.30079, 14.29966]]
origin_deg = [48.3, 14.3, 260.0]
auto_start = true
auto_return = true
[detection]
stop_at_first = true
[preflight]
upload_fence = true
[deadlines]
connect_s = 600
capture_s = 200
[safety]
max_link_age_s = 30
max_position_age_s = 30
[api]
enabled = false
[record]
folder = "{missions}"
"""


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_a_mission_flies_on_reported_exposures_and_files_in_a_folder(tmp_path: Path, autopilot: str) -> None:
    port = unused_port()
    images = tmp_path / "images"
    file = tmp_path / "mission.toml"
    missions = (tmp_path / "missions").as_posix()
    file.write_text(CONFIGURATION.format(speed=SPEED, port=port, images=images.as_posix(), missions=missions))
    simulator = ("--link", f"udpout://127.0.0.1:{port}", "--speed", str(SPEED), "--autopilot", autopilot)
    world = ("--vehicles", "3", "--trees-per-ha", "30", "--seed", "2", "--image-size", "192", "--errors", "none")
    async with (
        running(tmp_path / "sim", "sim", *simulator, *world, "--image-folder", str(images)) as swarm,
        running(tmp_path, "run", str(file)) as program,
    ):
        assert await program.ended(110) == 0, program.log + swarm.log
    assert program.output.startswith("found: ")
    with MissionReader(program.mission_folder) as reader:
        final = reader.last_snapshot()
    assert final is not None
    assert [vehicle.task for vehicle in final.vehicles] == [Task.LANDED] * 3
    for vehicle in final.vehicles:
        camera = vehicle.telemetry.camera
        assert camera is not None
        assert camera.source == "reported"
        assert camera.frames > 5
        assert (camera.refused, camera.torn, camera.failed) == (0, 0, 0)
