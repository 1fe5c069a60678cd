"""Scripts of one's own and the examples fly simulated vehicles, within the limits of a mission."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from aos_gcs.airspace.limits import SafetyOverrides
from aos_gcs.errors import ConfigurationError, MissionError
from aos_gcs.planning.settings import Deadlines, FlightSettings
from aos_gcs.scripting import ScriptOptions, open_swarm
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.swarm import DEFAULT_ORIGIN, SimulatedSwarm
from aos_sim.swarm import SwarmOptions as SimulatorOptions
from tests.fakes.program import unused_port
from tests.fakes.relief import hill, terrain, write_relief
from tests.timing import scaled_s

EXAMPLES = Path(__file__).parents[2] / "examples"
SPEED = 20.0
MAVSDK_SPEED = 5.0
"""A busy machine makes MAVSDK drop messages; a vehicle whose battery is silent for 30 s of its own returns."""
AREA_ENU_M = ((0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (0.0, 30.0))


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def options(vehicles: int, driver: str = "mavlink", speed: float = SPEED) -> ScriptOptions:
    """Deadlines and ages are in clock seconds: a busy machine may leave a vehicle unheard for seconds of real time."""

    def clock_s(real_s: float) -> float:
        """Return the clock seconds that pass in a limit of real time, as it holds on this machine."""
        return speed * scaled_s(real_s)

    return ScriptOptions(
        vehicles=vehicles,
        area_enu_m=AREA_ENU_M,
        driver=driver,
        flight=FlightSettings(lowest_layer_m=12.0, layer_spacing_m=3.0),
        deadlines=Deadlines(
            connect_s=clock_s(15.0),
            preflight_s=clock_s(15.0),
            command_s=clock_s(5.0),
            takeoff_s=clock_s(10.0),
            transfer_s=clock_s(10.0),
            capture_s=clock_s(10.0),
            land_s=clock_s(10.0),
            lost_s=clock_s(5.0),
            all_lost_s=clock_s(10.0),
        ),
        safety=SafetyOverrides(max_link_age_s=clock_s(3.0), max_position_age_s=clock_s(3.0)),
        clock_speed=speed,
    )


@asynccontextmanager
async def simulator(vehicles: int, speed: float = SPEED) -> AsyncIterator[tuple[SimulatedSwarm, list[str]]]:
    port = unused_port()
    settings = SimulatorOptions(
        vehicles=vehicles,
        links=(f"udpout://127.0.0.1:{port}",),
        speed=speed,
        image_size_px=32,
        start_up_s=2.0,
        # What a busy machine needs between two heartbeats, in real time, and between arming and take-off.
        parameters={"FS_GCS_TIMEOUT": scaled_s(3.0), "DISARM_DELAY": 120.0},
    )
    async with SimulatedSwarm(settings, CheckerboardGround()) as swarm:
        yield swarm, [f"udpin://127.0.0.1:{port}"]


def assert_all_are_home(simulated: SimulatedSwarm) -> None:
    assert simulated.report().landed == simulated.options.vehicles
    for vehicle_id, home_enu_m in simulated.homes_enu_m.items():
        assert math.dist(simulated.kinematics(vehicle_id).position_enu_m, home_enu_m) < 1.0


@pytest.mark.slow
async def test_the_square_is_flown_by_three_vehicles_that_come_home(capsys: pytest.CaptureFixture[str]) -> None:
    async with simulator(3) as (simulated, links):
        await example("fly_square").run(links, options(3), 10.0)
        assert_all_are_home(simulated)
    assert capsys.readouterr().out.splitlines() == [
        "corner 0 m east, 10 m north",
        "corner 10 m east, 10 m north",
        "corner 10 m east, 0 m north",
        "corner 0 m east, 0 m north",
        "all have landed",
    ]


async def test_frames_are_collected_where_the_vehicles_are_sent(tmp_path: Path) -> None:
    pytest.importorskip("mavsdk", reason="needs the optional library mavsdk")
    async with simulator(2, MAVSDK_SPEED) as (simulated, links):
        flight = options(2, "mavsdk", MAVSDK_SPEED)
        await example("collect_frames").run(links, flight, tmp_path, stations=2, step_m=5.0)
        assert_all_are_home(simulated)
    assert names(tmp_path) == [f"vehicle{vehicle:03d}_image{image:05d}.npz" for vehicle in (1, 2) for image in (0, 1)]
    first, second = (np.load(tmp_path / f"vehicle002_image{image:05d}.npz") for image in (0, 1))
    assert first["image"].shape == (32, 32, 4)
    assert list(first["bands"]) == ["red", "green", "blue", "thermal"]
    assert (second["position"][0] - first["position"][0]) * 111_200 == pytest.approx(5.0, abs=1.0)
    assert first["position"][2] - simulated.frame.origin.altitude_amsl_m == pytest.approx(15.0, abs=1.0)


@pytest.mark.slow
async def test_a_script_cannot_leave_the_fence_and_everybody_comes_home_all_the_same() -> None:
    impatient = replace(options(2), deadlines=replace(options(2).deadlines, transfer_s=40.0))

    async def fly_far_away(links: list[str]) -> None:
        async with open_swarm(links, impatient) as swarm:
            await swarm.take_off()
            await swarm.fly_to({2: (20.0, 500.0)})

    async with simulator(2) as (simulated, links):
        with pytest.raises(MissionError, match=r"vehicle 2 did not reach its place: .*fence"):
            await fly_far_away(links)
        assert_all_are_home(simulated)


async def test_a_script_over_a_hill_does_not_start(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    ground = write_relief(tmp_path / "ground.tif", hill(15.0, 15.0, 9.0, radius_m=6.0), cell=2.0, origin=DEFAULT_ORIGIN)
    over_a_hill = replace(options(2), terrain=terrain(ground, floor_above_ground_m=5.0))
    async with simulator(2) as (simulated, links):
        with pytest.raises(MissionError, match=r"Search area: at .* the ground rises to (8\.\d|9\.\d) m"):
            async with open_swarm(links, over_a_hill):
                pass
        assert_all_are_home(simulated)


@pytest.mark.slow
async def test_a_script_cannot_fly_into_a_hill_beside_its_area(tmp_path: Path) -> None:
    pytest.importorskip("rasterio")
    ground = write_relief(tmp_path / "ground.tif", hill(15.0, 60.0, 30.0, radius_m=8.0), origin=DEFAULT_ORIGIN)
    beside_a_hill = replace(
        options(2),
        terrain=terrain(ground, floor_above_ground_m=5.0),
        deadlines=replace(options(2).deadlines, transfer_s=40.0),
    )

    async def fly_into_it(links: list[str]) -> None:
        async with open_swarm(links, beside_a_hill) as swarm:
            await swarm.take_off()
            await swarm.fly_to({2: (15.0, 55.0)})

    async with simulator(2) as (simulated, links):
        with pytest.raises(MissionError, match=r"vehicle 2 did not reach its place: .* above the ground at"):
            await fly_into_it(links)
        assert_all_are_home(simulated)


async def test_an_unknown_driver_is_refused_by_name() -> None:
    wrong = ScriptOptions(vehicles=1, area_enu_m=AREA_ENU_M, driver="carrier-pigeon")
    with pytest.raises(ConfigurationError, match="carrier-pigeon"):
        async with open_swarm(["udpin://127.0.0.1:14550"], wrong):
            pass
