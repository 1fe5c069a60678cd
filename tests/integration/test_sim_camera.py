"""Cameras beside vehicles that have none: over real sockets, in a flight and in a whole mission."""

from __future__ import annotations

import asyncio
import dataclasses
import math
import socket
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import aiohttp
import cv2
import numpy as np
import pytest

from aos_drivers.mavlink import open_mavlink
from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.clock import LoopClock
from aos_gcs.config.file import parse_config
from aos_gcs.errors import CaptureError, LinkError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.vehicles import Task
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.ports import Capture, DriverContext, Vehicle
from aos_gcs.runtime.service import open_service
from aos_gcs.scripting import ScriptOptions, open_swarm
from aos_sim.attached.service import AttachedCameras, AttachedOptions
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm
from aos_sim.swarm import SwarmOptions as SimulatorOptions
from aos_sim.world.relief import Relief
from aos_sim.world.scene import SceneParameters, build_scene
from tests.fakes.program import unused_port
from tests.timing import scaled_s

HOST = "127.0.0.1"
SPEED = 2.0
VALLEY_M = 5.0
VALLEY = Relief(np.full((2, 2), -VALLEY_M), west_m=-500.0, south_m=-500.0, cell_m=1000.0)
"""Ground that lies below the launch points."""
PLACE = ("latitude_deg", "longitude_deg", "absolute_altitude_m")


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(scaled_s(30.0)):
        while not condition():  # noqa: ASYNC110 - nothing announces what is waited for
            await asyncio.sleep(0.05)


def script_options(vehicles: int, driver: str = "mavlink") -> ScriptOptions:
    """Deadlines and ages are in clock seconds; what takes real time is given many times as many."""
    return ScriptOptions(
        vehicles=vehicles,
        driver=driver,
        area_enu_m=((0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0)),
        flight=FlightSettings(lowest_layer_m=12.0, layer_spacing_m=3.0),
        deadlines=Deadlines(connect_s=600.0, preflight_s=600.0, command_s=200.0, takeoff_s=300.0, capture_s=400.0),
        safety=SafetyOverrides(max_link_age_s=60.0, max_position_age_s=60.0),
        clock_speed=SPEED,
    )


@asynccontextmanager
async def flying(
    autopilot: str, vehicles: int, speed: float = SPEED
) -> AsyncIterator[tuple[SimulatedSwarm, AttachedCameras, str]]:
    """Vehicles without cameras, cameras beside them, and the link of a ground station for both."""
    gcs_port, camera_port = unused_port(), unused_port()
    simulated = SimulatorOptions(
        vehicles=vehicles,
        links=(f"udpout://{HOST}:{gcs_port}", f"udpout://{HOST}:{camera_port}"),
        autopilot=autopilot,
        speed=speed,
        step_ticks=5,
        start_up_s=0.2 * speed,
        cameras=False,
    )
    attached = AttachedOptions(
        links=(f"udpin://{HOST}:{camera_port}",), gcs=f"udpout://{HOST}:{gcs_port}", image_size_px=32
    )
    cameras = AttachedCameras(attached, CheckerboardGround(), VALLEY)
    async with SimulatedSwarm(simulated, CheckerboardGround()) as swarm, asyncio.TaskGroup() as group:
        serving = group.create_task(cameras.run())
        yield swarm, cameras, f"udpin://{HOST}:{gcs_port}"
        serving.cancel()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("autopilot", "driver"), [("arducopter", "mavlink"), ("px4", "mavlink"), ("arducopter", "mavsdk")]
)
async def test_vehicles_without_cameras_deliver_what_the_cameras_beside_them_see(autopilot: str, driver: str) -> None:
    if driver == "mavsdk":
        pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    options = script_options(2, driver)
    async with flying(autopilot, 2) as (simulated, cameras, link), open_swarm([link], options) as swarm:
        await swarm.take_off()
        await swarm.fly_to({1: (-2.5, 20.0), 2: (2.5, 20.0)})
        result = await swarm.capture()
        assert {capture.vehicle_id for capture in result.captures} == {1, 2}
        for capture in result.captures:
            assert capture.image.shape == (32, 32, 4)
            true_enu_m = simulated.kinematics(capture.vehicle_id).position_enu_m
            assert math.dist(simulated.frame.to_enu(capture.position), true_enu_m) < 1.5
        report = cameras.report()
        assert [camera.refused for camera in report.cameras] == [0, 0]
        assert all(camera.images and camera.tells_true_pose for camera in report.cameras)
        assert report.min_separation_m == pytest.approx(5.0, abs=0.5)
        assert report.min_height_above_ground_m == pytest.approx(12.0 + VALLEY_M, abs=1.0), "that of the lowest layer"
        assert cameras.frame is not None
        assert cameras.homes_enu_m()[1] == pytest.approx((0.0, 0.0, 0.0), abs=0.02)


async def test_ten_cameras_expose_at_the_same_time_again_and_again() -> None:
    # In one event loop, ten fast vehicles would send more datagrams than it reads in time.
    async with flying("arducopter", 10, speed=1.0) as (simulated, cameras, link):
        clock = LoopClock()
        async with open_mavlink([link], DriverContext(clock, lambda: True, lambda _: None)) as fleet:

            async def capture(vehicle: Vehicle) -> Capture:
                while True:
                    try:
                        return await vehicle.capture(clock.now_s() + 5.0)
                    except CaptureError:  # its camera has not been heard yet
                        await asyncio.sleep(0.1)

            await until(lambda: len(fleet.vehicles()) == 10)
            await until(lambda: simulated.vehicle(10).autopilot.position_known)
            for index in range(3):
                captures = await asyncio.gather(*map(capture, fleet.vehicles().values()))
                assert sorted(capture.vehicle_id for capture in captures) == list(range(1, 11))
                for taken in captures:
                    home_enu_m = simulated.homes_enu_m[taken.vehicle_id]
                    assert math.dist(simulated.frame.to_enu(taken.position), home_enu_m) < 0.1
                    assert taken.image_index >= index
        assert cameras.report().images >= 30


async def test_an_independent_client_takes_a_photograph_with_a_camera_beside_a_vehicle() -> None:
    pytest.importorskip("mavsdk", reason="needs the optional client mavsdk")
    from mavsdk.asyncio.mavsdk import Configuration, Mavsdk  # noqa: PLC0415
    from mavsdk.asyncio.plugins.camera import CameraAsync  # noqa: PLC0415
    from mavsdk.component_type import ComponentType  # noqa: PLC0415

    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    async with flying("arducopter", 1) as (simulated, _, link), Mavsdk(configuration) as client:
        await client.add_any_connection(link)
        async with asyncio.timeout(scaled_s(20.0)):
            while not (systems := await client.get_systems()):  # noqa: ASYNC110 - the client has no events for it
                await asyncio.sleep(0.05)
            camera = CameraAsync(systems[0])
            while not (found := (await camera.camera_list()).cameras):  # noqa: ASYNC110
                await asyncio.sleep(0.05)
            captures = camera.subscribe_capture_info()
            first = asyncio.ensure_future(anext(captures))
            await asyncio.sleep(0)
            await camera.take_photo(found[0].component_id)
            capture = await first
            await captures.aclose()
        assert (found[0].component_id, found[0].model_name) == (100, "simulated RGB+thermal")
        assert capture.is_success
        position = GeodeticPosition(*(getattr(capture.position, name) for name in PLACE))
        assert math.dist(simulated.frame.to_enu(position), simulated.kinematics(1).position_enu_m) < 0.1
        async with aiohttp.ClientSession() as http, http.get(capture.file_url) as response:
            assert len(cv2.imdecodemulti(np.frombuffer(await response.read(), np.uint8), cv2.IMREAD_UNCHANGED)[1]) == 2


async def test_two_vehicles_with_one_system_id_get_no_images(caplog: pytest.LogCaptureFixture) -> None:
    first_port, second_port, gcs_port = (unused_port() for _ in range(3))
    attached = AttachedOptions(
        links=(f"udpin://{HOST}:{first_port}", f"udpin://{HOST}:{second_port}"), gcs=f"udpout://{HOST}:{gcs_port}"
    )
    cameras = AttachedCameras(attached, CheckerboardGround())

    def alone(port: int) -> SimulatedSwarm:
        options = SimulatorOptions(vehicles=1, links=(f"udpout://{HOST}:{port}",), cameras=False, start_up_s=0.0)
        return SimulatedSwarm(options, CheckerboardGround())

    async with alone(first_port), alone(second_port), asyncio.TaskGroup() as group:
        serving = group.create_task(cameras.run())
        await until(lambda: "give each vehicle its own id" in caplog.text)
        serving.cancel()
    assert "system id 1 is heard from" in caplog.text


async def test_a_link_is_tried_until_somebody_answers_and_again_when_it_is_lost() -> None:
    port = unused_port(socket.SOCK_STREAM)
    cameras = AttachedCameras(AttachedOptions(links=(f"tcpout://{HOST}:{port}",)), CheckerboardGround())
    async with asyncio.TaskGroup() as group:
        serving = group.create_task(cameras.run())
        await asyncio.sleep(0.1)
        for system_id in (1, 2):
            options = SimulatorOptions(
                vehicles=1, first_system_id=system_id, links=(f"tcpin://{HOST}:{port}",), cameras=False
            )
            async with SimulatedSwarm(options, CheckerboardGround()):
                await until(lambda heard=system_id: heard in {camera.system_id for camera in cameras.report().cameras})
        serving.cancel()


async def test_a_taken_port_ends_the_service_with_its_name() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind((HOST, 0))
        link = f"udpin://{HOST}:{taken.getsockname()[1]}"
        with pytest.raises(LinkError, match=link):
            await AttachedCameras(AttachedOptions(links=(link,)), CheckerboardGround()).run()


@pytest.mark.slow
@pytest.mark.timeout(400)
async def test_a_mission_finds_a_person_with_cameras_beside_the_vehicles(tmp_path: Path) -> None:
    renderer = pytest.importorskip("aos_sim.render", reason="needs the optional ray tracer").Renderer
    vehicles, speed, origin = 5, 3.0, GeodeticPosition(48.3, 14.3, 260.0)
    gcs_port, camera_port = unused_port(), unused_port()
    simulator = [
        *(sys.executable, "-m", "aos_sim", "--vehicles", str(vehicles), "--speed", str(speed)),
        *("--no-camera", "--no-render", "--trees-per-ha", "0", "--exit-with-parent"),
        *("--link", f"udpout://{HOST}:{gcs_port}", "--link", f"udpout://{HOST}:{camera_port}"),
    ]
    attached = AttachedOptions(
        links=(f"udpin://{HOST}:{camera_port}",), gcs=f"udpout://{HOST}:{gcs_port}", origin=origin, image_size_px=256
    )
    scene = build_scene(SceneParameters(trees_per_ha=20.0))
    cameras = AttachedCameras(attached, renderer(scene))
    settings = {
        "clock_speed": speed,
        "link": {"urls": [f"udpin://{HOST}:{gcs_port}"]},
        "mission": {
            "vehicles": vehicles,
            "any_vehicles": True,
            "origin_deg": dataclasses.astuple(origin),
            "area_enu_m": [[-25.0, 8.0], [25.0, 8.0], [25.0, 88.0], [-25.0, 88.0]],
            "auto_start": True,
            "auto_return": True,
        },
        "detection": {"stop_at_first": True},
        "preflight": {"upload_fence": True},
        "deadlines": {
            "connect_s": 200.0,
            "preflight_s": 500.0,
            "command_s": 60.0,
            "capture_s": 60.0,
            "search_s": 3600.0,
            "lost_s": 30.0,
            "all_lost_s": 60.0,
        },
        "safety": {"max_link_age_s": 15.0, "max_position_age_s": 15.0},
        "api": {"enabled": False},
        "record": {"folder": tmp_path},
    }
    process = await asyncio.create_subprocess_exec(*simulator)
    try:
        async with asyncio.TaskGroup() as group:
            serving = group.create_task(cameras.run())
            async with open_service(parse_config(settings, source="test")) as service:
                snapshot = await service.run()
            serving.cancel()
    finally:
        process.terminate()
        await process.wait()
    assert [vehicle.task for vehicle in snapshot.vehicles] == [Task.LANDED] * vehicles
    assert snapshot.outcome is Outcome.FOUND
    assert snapshot.target is not None
    error_m = np.linalg.norm(scene.persons[0].position_enu_m[:2] - snapshot.target.position_enu_m[:2])
    assert error_m < 1.0
    assert cameras.report().images > 0.8 * vehicles * snapshot.step
