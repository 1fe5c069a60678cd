"""The command ``aos-gcs sim-camera``: cameras for autopilots in software."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from aos_sim.attached.service import AttachedCameras, AttachedOptions
from aos_sim.errors.model import error_model
from aos_sim.report import write_report
from aos_sim.world.scene import build_scene
from aos_sim.world_file import World, read_world_file, scene_parameters, write_world_file
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
    image_source,
    parse_origin,
    require_writable,
    stop_on_signals,
    terrain_of,
    work_until,
    world_of,
)


@dataclass(frozen=True, slots=True)
class _Files:
    world: Path | None
    report: Path | None


def sim_camera(
    *,
    link: Annotated[
        list[str],
        typer.Option(
            help="Connection to vehicles: tcpout://HOST:PORT (a port of ArduPilot's simulator), udpin://HOST:PORT "
            "(where PX4 sends) or tcpin://HOST:PORT. May be repeated; each vehicle on one of them only."
        ),
    ],
    gcs: Annotated[
        str | None,
        typer.Option(
            help="Links of the cameras to the ground station: udpout://HOST:PORT (each from its own port) or "
            "tcpout://HOST:PORT (default: through their autopilots)."
        ),
    ] = None,
    world: Annotated[
        Path | None,
        typer.Option(
            help="Show the world of this file, which --world-file of this command or of aos-gcs sim has written, "
            "instead of the one made of --origin, --seed and the options for its contents.",
            dir_okay=False,
        ),
    ] = None,
    origin: Annotated[
        str | None,
        typer.Option(
            help="The world's origin, south of the forest: LAT,LON,ALT in degrees and metres above sea level. "
            "(default: home of the vehicle with the lowest system id at the first exposure)"
        ),
    ] = None,
    seed: Seed = 1,
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
    image_size: ImageSize = 512,
    fov: FieldOfView = 50.0,
    errors: Errors = "rtk",
    no_render: NoRender = False,
    http_port: HttpPort = 0,
    world_file: Annotated[
        Path | None, typer.Option(help="Write the truth about the world here, as JSON, as soon as its place is known.")
    ] = None,
    report_file: ReportFile = None,
    exit_with_parent: ExitWithParent = False,
) -> None:
    """Attach a simulated camera to each autopilot that is heard, so that it can fly a search."""
    require_writable(world_file=world_file, report_file=report_file)
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
    place = parse_origin(origin) if origin is not None else None
    if world is not None:
        parameters, place = read_world_file(world)
    model = error_model(errors)
    options = AttachedOptions(
        links=tuple(link),
        gcs=gcs,
        origin=place,
        seed=seed,
        image_size_px=image_size,
        fov_rad=math.radians(fov),
        http_port=http_port,
        errors=model,
    )
    scene = build_scene(parameters, place)
    cameras = AttachedCameras(options, image_source(scene, model, no_render), scene.relief)
    asyncio.run(_serve(cameras, world_of(scene), _Files(world_file, report_file), exit_with_parent))


async def _serve(cameras: AttachedCameras, world: World, files: _Files, exit_with_parent: bool) -> None:
    """Run until a signal or the parent's end asks to stop."""

    def report() -> None:
        if files.report is not None:
            write_report(files.report, cameras.report())
        if files.world is not None and cameras.frame is not None:
            write_world_file(files.world, world, cameras.frame.origin, cameras.homes_enu_m(), cameras.start_utc_s)

    stop = stop_on_signals()
    async with asyncio.TaskGroup() as group:
        serving = group.create_task(cameras.run())
        await work_until(stop, exit_with_parent, report)
        serving.cancel()
