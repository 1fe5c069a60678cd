"""The command ``aos-gcs sim``: the simulated swarm alone."""

from __future__ import annotations

import asyncio
import logging
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import AosError, ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.clock import SimTime, fast_utc_us
from aos_sim.errors.model import error_model
from aos_sim.map_picture import draw_map
from aos_sim.report import write_report
from aos_sim.swarm import SimulatedSwarm, SwarmOptions
from aos_sim.world.scene import Scene, SceneParameters, build_relief, build_scene
from aos_sim.world.terrain_file import write_geotiff
from aos_sim.world_file import scene_parameters, write_world_file
from aos_sim.world_options import (
    Animals,
    Cloths,
    ConditionsOption,
    Dressed,
    Errors,
    ExitWithParent,
    FieldOfView,
    HttpPort,
    ImageSize,
    InPairs,
    NoRender,
    PersonPosture,
    Persons,
    ReportFile,
    Seed,
    Stones,
    Stumps,
    TerrainOption,
    TreesPerHa,
    WalkingSpeed,
    Waters,
    WindSpeed,
    image_source,
    parse_origin,
    require_writable,
    stop_on_signals,
    terrain_of,
    work_until,
    world_of,
)

_log = logging.getLogger(__name__)

MAX_WIND_MPS = 50.0
_LATEST_UTC_S = 4_102_444_800.0
"""Latest start of a clock: the year 2100."""


@dataclass(frozen=True, slots=True)
class _Files:
    world: Path | None
    report: Path | None
    map: Path | None


def sim(
    *,
    vehicles: Annotated[int, typer.Option(help="Number of vehicles, 1 to 100.")] = 10,
    link: Annotated[
        list[str] | None,
        typer.Option(
            help="MAVLink connection of the vehicles: udpout://HOST:PORT (each sends from its own port), "
            "udpin://HOST:PORT (vehicle i listens on PORT + i), tcpout:// or tcpin://. May be repeated. "
            "(default: udpout://127.0.0.1:14550)"
        ),
    ] = None,
    seed: Seed = 1,
    speed: Annotated[
        float, typer.Option(help="Simulated seconds per second. Time slows down where the machine cannot keep up.")
    ] = 1.0,
    clock_start: Annotated[
        float | None,
        typer.Option(
            metavar="UTC",
            help="Start of a station's clock of the same --speed, in seconds since the Unix epoch: the vehicles' "
            "clocks agree with it. By default they agree with this computer's at the start.",
        ),
    ] = None,
    autopilot: Annotated[str, typer.Option(help="Behave like arducopter or px4.")] = "arducopter",
    first_system_id: Annotated[int, typer.Option(help="MAVLink system id of the first vehicle.")] = 1,
    origin: Annotated[
        str, typer.Option(help="Launch site: LAT,LON,ALT in degrees and metres above sea level.")
    ] = "48.3,14.3,260",
    launch_spacing: Annotated[
        float,
        typer.Option(metavar="M", help="Distance of two launch points; --errors gnss needs 10, and 5 is enough else."),
    ] = 5.0,
    trees_per_ha: TreesPerHa = 300.0,
    animals: Animals = 0,
    stones: Stones = 0,
    cloths: Cloths = 0,
    stumps: Stumps = 0,
    waters: Waters = 0,
    persons: Persons = 1,
    posture: PersonPosture = "standing",
    dressed: Dressed = False,
    in_pairs: InPairs = False,
    walking_speed: WalkingSpeed = 0.0,
    conditions: ConditionsOption = "cool",
    terrain: TerrainOption = "flat",
    terrain_file: Annotated[
        Path | None,
        typer.Option(
            help="Write the ground of --terrain here as a GeoTIFF: the elevation model of a service that flies there."
        ),
    ] = None,
    terrain_only: Annotated[bool, typer.Option("--terrain-only", help="Write --terrain-file and exit.")] = False,
    image_size: ImageSize = 512,
    fov: FieldOfView = 50.0,
    wind: WindSpeed = None,
    errors: Errors = "rtk",
    no_render: NoRender = False,
    no_camera: Annotated[
        bool, typer.Option("--no-camera", help="No cameras on board; aos-gcs sim-camera can attach some.")
    ] = False,
    image_folder: Annotated[
        Path | None,
        typer.Option(
            help="Have the autopilots trigger the cameras and report each exposure (CAMERA_FEEDBACK, or "
            "CAMERA_IMAGE_CAPTURED without a URL), and drop the images here: ID/00000.tiff and so on."
        ),
    ] = None,
    http_port: HttpPort = 0,
    param: Annotated[
        list[str] | None, typer.Option(help="Autopilot parameter NAME=VALUE for all vehicles. May be repeated.")
    ] = None,
    factory_settings: Annotated[
        bool,
        typer.Option("--factory-settings", help="Leave failsafes and fence as manufacturers deliver them: mostly off."),
    ] = False,
    battery_life: Annotated[
        float | None,
        typer.Option(metavar="S", help="Time in flight that a full battery lasts, in seconds; by default 30 minutes."),
    ] = None,
    swap: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="Put a full battery into vehicles that have stood on the ground for so many seconds after a flight.",
        ),
    ] = None,
    world_file: Annotated[
        Path | None, typer.Option(help="Write the truth about the world here, as JSON, before the first heartbeat.")
    ] = None,
    report_file: ReportFile = None,
    map_file: Annotated[
        Path | None, typer.Option(help="Write a base map of the forest here (PMTiles), without persons or animals.")
    ] = None,
    exit_with_parent: ExitWithParent = False,
) -> None:
    """Simulate a swarm of camera drones over a forest, each speaking MAVLink like a real one."""
    require_writable(world_file=world_file, report_file=report_file, map_file=map_file, terrain_file=terrain_file)
    if clock_start is not None and not 0.0 <= clock_start <= _LATEST_UTC_S:
        raise ConfigurationError(
            f"--clock-start must be seconds since the Unix epoch, 0 to {_LATEST_UTC_S:.0f}, but is {clock_start:g}; "
            "leave it out for this computer's time."
        )
    if terrain_only and terrain_file is None:
        raise ConfigurationError("--terrain-only writes the ground and exits: name its --terrain-file.")
    if wind is not None and not 0.0 <= wind <= MAX_WIND_MPS:
        raise ConfigurationError(f"--wind must lie within 0 and {MAX_WIND_MPS:g} m/s, got {wind:g}.")
    model = error_model(errors).with_wind(wind)
    options = SwarmOptions(
        vehicles=vehicles,
        links=tuple(link or ("udpout://127.0.0.1:14550",)),
        seed=seed,
        speed=speed,
        autopilot=autopilot,
        first_system_id=first_system_id,
        origin=parse_origin(origin),
        image_size_px=image_size,
        fov_rad=math.radians(fov),
        errors=model,
        launch_spacing_m=launch_spacing,
        cameras=not no_camera,
        image_folder=image_folder,
        http_port=http_port,
        battery_s=battery_life,
        swap_s=swap,
        parameters=_parse_parameters(param or []),
        factory_settings=factory_settings,
    )
    parameters = scene_parameters(
        {
            "seed": seed,
            "trees_per_ha": trees_per_ha,
            "animals": animals,
            "stones": stones,
            "cloths": cloths,
            "stumps": stumps,
            "waters": waters,
            "persons": persons,
            "posture": posture,
            "dressed": dressed,
            "in_pairs": in_pairs,
            "walking_mps": walking_speed,
            "conditions": conditions,
            "terrain": terrain_of(terrain),
        }
    )
    if terrain_file is not None:
        _write_terrain(terrain_file, parameters, options.origin)
    if terrain_only:
        return
    scene = build_scene(parameters, options.origin)
    swarm = SimulatedSwarm(options, image_source(scene, model, no_render), scene.relief)
    if clock_start is not None:
        swarm.now = SimTime(0, fast_utc_us(swarm.now.start_utc_us, speed, clock_start))
    files = _Files(world_file, report_file, map_file)
    asyncio.run(_simulate(swarm, scene, files, exit_with_parent))


def _write_terrain(path: Path, parameters: SceneParameters, origin: GeodeticPosition) -> None:
    relief = build_relief(parameters, origin)
    if relief is None:
        raise ConfigurationError("--terrain-file needs ground that is not level: give --terrain, too.")
    write_geotiff(path, relief, origin)


async def _simulate(swarm: SimulatedSwarm, scene: Scene, files: _Files, exit_with_parent: bool) -> None:
    """Run until a signal or the parent's end asks to stop."""

    def report() -> None:
        if files.report is not None:
            write_report(files.report, swarm.report())

    stop = stop_on_signals()
    if files.world is not None:
        boards = {one.system_id: one.autopilot.identity.board_id for one in swarm.vehicles}
        origin, start_utc_s = swarm.options.origin, swarm.start_utc_s
        write_world_file(files.world, world_of(scene), origin, swarm.homes_enu_m, start_utc_s, board_ids=boards)
    async with swarm, asyncio.TaskGroup() as group:
        if files.map is not None:
            # Beside the vehicles, which it must not delay.
            group.create_task(asyncio.to_thread(_draw_map, files.map, scene, swarm.options.origin))
        await work_until(stop, exit_with_parent, report)


def _draw_map(path: Path, scene: Scene, origin: GeodeticPosition) -> None:
    """Draw the base map. Vehicles fly without one as well."""
    try:
        draw_map(path, scene, origin)
    except AosError as error:
        _log.warning("No base map: %s", error)


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
