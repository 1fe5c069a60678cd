"""The simulated vehicles satisfy an independent MAVLink client: MAVSDK."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import aiohttp
import cv2
import numpy as np
import pytest

from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import SimulatedSwarm, SwarmOptions

pytest.importorskip("mavsdk", reason="needs the optional client mavsdk")

from mavsdk.asyncio.mavsdk import Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync, ActionError
from mavsdk.asyncio.plugins.camera import CameraAsync
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync
from mavsdk.component_type import ComponentType

from tests.fakes.program import unused_port
from tests.fakes.sim_errors import POSITIONS_ERR
from tests.timing import scaled_s

pytestmark = pytest.mark.timeout(60)

SPEED = 10.0
CAMERA = 100
# The client's heartbeat comes once per real second, which is ten seconds of the vehicles' time.
PATIENT = {"arducopter": {}, "px4": {"COM_DL_LOSS_T": 120}}
RETURN_HEIGHT = {"arducopter": ("RTL_ALT", 3000), "px4": ("NAV_DLL_ACT", 2)}


@dataclass
class Client:
    """The client's view of one vehicle."""

    system: Any
    action: ActionAsync
    telemetry: TelemetryAsync

    @classmethod
    async def of(cls, system: Any) -> Client:
        client = cls(system, ActionAsync(system), TelemetryAsync(system))
        await client.telemetry.set_rate_position(20.0)
        await client.telemetry.set_rate_health(10.0)
        await client.telemetry.set_rate_landed_state(10.0)
        return client


async def until(condition: Callable[[], Awaitable[bool]], limit_s: float = 15.0) -> None:
    """Wait for telemetry to show something."""
    async with asyncio.timeout(scaled_s(limit_s)):
        while not await condition():  # noqa: ASYNC110 - the client has no events for what it polls
            await asyncio.sleep(0.05)


@asynccontextmanager
async def flight(flavour: str, vehicles: int):
    """A simulated swarm and the client's view of each of its vehicles, all on one port of the client."""
    port = unused_port()
    options = SwarmOptions(
        vehicles=vehicles,
        links=(f"udpout://127.0.0.1:{port}",),
        speed=SPEED,
        autopilot=flavour,
        image_size_px=64,
        start_up_s=3.0,
        parameters=PATIENT[flavour],
        errors=POSITIONS_ERR,
    )
    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    async with SimulatedSwarm(options, CheckerboardGround()) as swarm, Mavsdk(configuration) as client:
        await client.add_any_connection(f"udpin://127.0.0.1:{port}")

        async def all_found() -> bool:
            return len(await client.get_systems()) == vehicles

        await until(all_found)
        systems = {await system.get_system_id(): system for system in await client.get_systems()}
        yield swarm, {system_id: await Client.of(systems[system_id]) for system_id in sorted(systems)}


async def is_healthy(client: Client) -> bool:
    health = await client.telemetry.health()
    return all(getattr(health, name) for name in vars(health) if name.startswith("is_"))


async def launch(client: Client, height_m: float) -> None:
    async def arrived() -> bool:
        return (await client.telemetry.position()).relative_altitude_m > height_m - 0.5

    await until(lambda: is_healthy(client))
    await client.action.set_takeoff_altitude(height_m)
    await client.action.arm()
    await client.action.takeoff()
    await until(arrived)


async def is_disarmed(client: Client) -> bool:
    return not await client.telemetry.armed()


async def take_photo(client: Client) -> Any:
    camera = CameraAsync(client.system)

    async def found() -> bool:
        return any(info.component_id == CAMERA for info in (await camera.camera_list()).cameras)

    await until(found)
    captures = camera.subscribe_capture_info()
    first = asyncio.ensure_future(anext(captures))
    await asyncio.sleep(0)
    await camera.take_photo(CAMERA)
    capture = await asyncio.wait_for(first, scaled_s(10.0))
    await captures.aclose()
    return capture


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
async def test_whole_flight(flavour):
    async with flight(flavour, 1) as (swarm, clients):
        client = clients[1]
        await launch(client, 20.0)
        goal = swarm.frame.to_geodetic((20.0, 30.0, 25.0))
        await client.action.goto_location(goal.latitude_deg, goal.longitude_deg, goal.altitude_amsl_m, 0.0)

        async def near() -> bool:
            position = await client.telemetry.position()
            flat = (position.latitude_deg - goal.latitude_deg, position.longitude_deg - goal.longitude_deg)
            return max(map(abs, flat)) < 5e-6 and abs(position.absolute_altitude_m - goal.altitude_amsl_m) < 0.2

        await until(near)
        assert np.linalg.norm(np.subtract(swarm.kinematics(1).position_enu_m, (20.0, 30.0, 25.0))) < 0.7

        capture = await take_photo(client)
        assert capture.is_success
        assert capture.index == 0
        assert capture.position.latitude_deg == pytest.approx(goal.latitude_deg, abs=1e-5)
        async with aiohttp.ClientSession() as session:
            async with session.get(capture.file_url) as response:
                assert response.status == 200
                data = await response.read()
            async with session.get(capture.file_url.replace("/0.tiff", "/1.tiff")) as response:
                assert response.status == 404
        _, pages = cv2.imdecodemulti(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert [page.shape for page in pages] == [(64, 64, 3), (64, 64)]

        with pytest.raises(ActionError):
            await client.action.disarm()
        await client.action.return_to_launch()
        await until(lambda: is_disarmed(client), 25.0)
        assert swarm.report().landed == 1
        assert np.linalg.norm(np.subtract(swarm.kinematics(1).position_enu_m, (0.0, 0.0, 0.0))) < 0.5


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
async def test_landing_and_parameters(flavour):
    async with flight(flavour, 1) as (swarm, clients):
        client = clients[1]
        name, value = RETURN_HEIGHT[flavour]
        parameters = ParamAsync(client.system)
        assert await parameters.get_param_int(name) == value
        await parameters.set_param_int(name, value + 1)
        assert swarm.vehicle(1).autopilot.parameters[name] == value + 1
        await parameters.set_param_int(name, value)
        await launch(client, 5.0)
        await client.action.land()
        await until(lambda: is_disarmed(client))
        assert swarm.kinematics(1).on_ground


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
async def test_only_the_addressed_vehicle_of_several_on_one_port_moves(flavour):
    async with flight(flavour, 3) as (swarm, clients):
        homes = swarm.homes_enu_m
        flown: set[int] = set()
        for system_id, client in clients.items():
            await launch(client, 5.0 + system_id)
            flown.add(system_id)
            for other in clients:
                height_m = swarm.kinematics(other).position_enu_m[2]
                assert height_m == pytest.approx(5.0 + other if other in flown else 0.0, abs=0.6)
            assert np.allclose(swarm.kinematics(system_id).position_enu_m[:2], homes[system_id][:2], atol=0.1)
