"""The command ``aos-gcs sim``: the simulated swarm alone."""

from __future__ import annotations

import asyncio
import math
import os
import signal
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.camera.image import ImageSource
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.report import Target, World, write_report, write_world_file
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from aos_sim.vehicle.kinematics import EnuPoint
from aos_sim.world.scene import Scene, SceneParameters, build_scene

REPORT_PERIOD_S = 1.0
PARENT_CHECK_PERIOD_S = 0.5


@dataclass(frozen=True, slots=True)
class _Files:
    world: Path | None
    report: Path | None


def sim(
    *,
    vehicles: Annotated[int, typer.Option(help="Number of vehicles, 1 to 100.")] = 10,
    link: Annotated[
        list[str] | None,
        typer.Option(
            help="MAVLink connection of the vehicles: udpout://HOST:PORT (each sends from its own port), "
            "udpin://HOST:PORT (vehicle i listens on PORT + i), tcpout:// or tcpin://. May be repeated. "
            "[default: udpout://127.0.0.1:14550]"
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the world, the wind and the noise.")] = 1,
    speed: Annotated[
        float, typer.Option(help="Simulated seconds per second. Time slows down where the machine cannot keep up.")
    ] = 1.0,
    autopilot: Annotated[str, typer.Option(help="Behave like arducopter or px4.")] = "arducopter",
    first_system_id: Annotated[int, typer.Option(help="MAVLink system id of the first vehicle.")] = 1,
    origin: Annotated[
        str, typer.Option(help="Launch site: LAT,LON,ALT in degrees and metres above sea level.")
    ] = "48.3,14.3,260",
    trees_per_ha: Annotated[float, typer.Option(help="Density of the forest.")] = 300.0,
    animals: Annotated[int, typer.Option(help="Deer and boars in the forest, which distract the search.")] = 0,
    stones: Annotated[int, typer.Option(help="Sun-warmed stones in the forest.")] = 0,
    cloths: Annotated[int, typer.Option(help="Bright cloths in the forest, as warm as the air.")] = 0,
    image_size: Annotated[int, typer.Option(help="Width and height of the images in pixels.")] = 512,
    fov: Annotated[float, typer.Option(help="Field of view of the cameras in degrees.")] = 50.0,
    wind: Annotated[float, typer.Option(help="Mean wind in m/s, from the west, with gusts.")] = 0.0,
    no_render: Annotated[
        bool, typer.Option("--no-render", help="Show the cameras a chequered ground instead of the forest.")
    ] = False,
    no_camera: Annotated[
        bool, typer.Option("--no-camera", help="No cameras on board; aos-gcs sim-camera can attach some.")
    ] = False,
    http_port: Annotated[int, typer.Option(help="Port of the image server; 0 takes any free one.")] = 0,
    param: Annotated[
        list[str] | None, typer.Option(help="Autopilot parameter NAME=VALUE for all vehicles. May be repeated.")
    ] = None,
    world_file: Annotated[
        Path | None, typer.Option(help="Write the truth about the world here, as JSON, before the first heartbeat.")
    ] = None,
    report_file: Annotated[
        Path | None, typer.Option(help="Write the truth about the flight here, as JSON, once a second and at the end.")
    ] = None,
    exit_with_parent: Annotated[
        bool, typer.Option("--exit-with-parent", help="End when the process that started this one has ended.")
    ] = False,
) -> None:
    """Simulate a swarm of camera drones over a forest, each speaking MAVLink like a real one."""
    options = SwarmOptions(
        vehicles=vehicles,
        links=tuple(link or ("udpout://127.0.0.1:14550",)),
        seed=seed,
        speed=speed,
        autopilot=autopilot,
        first_system_id=first_system_id,
        origin=_parse_origin(origin),
        image_size_px=image_size,
        fov_rad=math.radians(fov),
        wind_mps=wind,
        cameras=not no_camera,
        http_port=http_port,
        parameters=_parse_parameters(param or []),
    )
    scene = build_scene(
        SceneParameters(seed=seed, trees_per_ha=trees_per_ha, animals=animals, stones=stones, cloths=cloths)
    )
    source = CheckerboardGround() if no_render else _make_renderer(scene)
    files = _Files(world_file, report_file)
    asyncio.run(_simulate(SimulatedSwarm(options, source), _world_of(scene), files, exit_with_parent))


async def _simulate(swarm: SimulatedSwarm, world: World, files: _Files, exit_with_parent: bool) -> None:
    """Run until a signal or the parent's end asks to stop."""
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for signal_number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(signal_number, stop.set)
    if files.world is not None:
        options = swarm.options
        write_world_file(files.world, world, options.origin, options.seed, swarm.homes_enu_m)
    async with swarm, asyncio.TaskGroup() as group:
        helpers = []
        if files.report is not None:
            helpers.append(group.create_task(_report_regularly(swarm, files.report)))
        if exit_with_parent:
            helpers.append(group.create_task(_stop_with_parent(stop)))
        await stop.wait()
        for helper in helpers:
            helper.cancel()
    if files.report is not None:
        write_report(files.report, swarm.report())


async def _report_regularly(swarm: SimulatedSwarm, path: Path) -> None:
    while True:
        write_report(path, swarm.report())
        await asyncio.sleep(REPORT_PERIOD_S)


async def _stop_with_parent(stop: asyncio.Event) -> None:
    parent = os.getppid()
    while os.getppid() == parent:  # noqa: ASYNC110 - nothing announces the end of a parent
        await asyncio.sleep(PARENT_CHECK_PERIOD_S)
    stop.set()


def _make_renderer(scene: Scene) -> ImageSource:
    """Make the renderer; imported here because its ray tracer is an optional dependency."""
    try:
        from aos_sim.render import Renderer  # noqa: PLC0415
    except ImportError as error:
        raise ConfigurationError(
            f"The renderer needs the module {error.name}; install aos-gcs[sim] or give --no-render."
        ) from error
    return Renderer(scene)


def _world_of(scene: Scene) -> World:
    return World(
        area_enu_m=tuple((float(east), float(north)) for east, north in scene.area_enu_m),
        targets=tuple(Target(person.name, _point(person.position_enu_m), person.height_m) for person in scene.persons),
        trees_per_ha=scene.parameters.trees_per_ha,
    )


def _point(position_enu_m: NDArray[np.float64]) -> EnuPoint:
    east_m, north_m, up_m = position_enu_m
    return float(east_m), float(north_m), float(up_m)


def _parse_origin(text: str) -> GeodeticPosition:
    try:
        latitude_deg, longitude_deg, altitude_amsl_m = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ConfigurationError(f"--origin must be LAT,LON,ALT (three numbers), got {text!r}.") from error
    if not (abs(latitude_deg) < 90.0 and abs(longitude_deg) <= 180.0 and math.isfinite(altitude_amsl_m)):
        raise ConfigurationError(f"--origin must be a latitude, a longitude and an altitude, got {text!r}.")
    return GeodeticPosition(latitude_deg, longitude_deg, altitude_amsl_m)


def _parse_parameters(texts: list[str]) -> dict[str, float]:
    parameters = {}
    for text in texts:
        name, separator, value = text.partition("=")
        try:
            parameters[name] = float(value)
        except ValueError as error:
            raise ConfigurationError(f"--param must be NAME=VALUE with a number, got {text!r}.") from error
        if not separator or not math.isfinite(parameters[name]):
            raise ConfigurationError(f"--param must be NAME=VALUE with a number, got {text!r}.")
    return parameters
