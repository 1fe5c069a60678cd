"""Common parts of the simulator's commands: options of the world and the cameras, and the way they end."""

from __future__ import annotations

import asyncio
import math
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM
from aos_sim.camera.image import ImageSource
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.errors.model import ErrorModel
from aos_sim.vehicle.kinematics import EnuPoint
from aos_sim.world.scene import Scene
from aos_sim.world.terrain import is_file
from aos_sim.world_file import Target, World

_PERIOD_S = 1.0

Seed = Annotated[int, typer.Option(help="Seed of the world, the wind and the noise.")]
TreesPerHa = Annotated[float, typer.Option(help="Density of the forest.")]
Animals = Annotated[int, typer.Option(help="Deer and boars in the forest, which distract the search.")]
Stones = Annotated[int, typer.Option(help="Sun-warmed stones in the forest.")]
Cloths = Annotated[int, typer.Option(help="Bright cloths in the forest, as warm as the air.")]
Stumps = Annotated[int, typer.Option(help="Sun-warmed stumps in the forest.")]
Waters = Annotated[int, typer.Option(help="Puddles in the forest, colder than the ground.")]
Persons = Annotated[int, typer.Option(help="Persons in the forest.")]
PersonPosture = Annotated[
    str, typer.Option("--posture", help="Posture of the persons: standing, sitting, lying or walking.")
]
Dressed = Annotated[bool, typer.Option("--dressed", help="Dress the persons in hoods, gloves and blankets.")]
InPairs = Annotated[bool, typer.Option("--in-pairs", help="Place every second person beside another one.")]
WalkingSpeed = Annotated[
    float,
    typer.Option("--walking-speed", help="Speed in m/s at which walking persons go to and fro; 0: they stay."),
]
TerrainOption = Annotated[
    str,
    typer.Option(
        "--terrain",
        help="Shape of the ground: flat, hills, slope:PERCENT (rising to the north from the launch site on) or a "
        "GeoTIFF or ASC file with heights.",
    ),
]
ConditionsOption = Annotated[
    str, typer.Option("--conditions", help="Weather and time of day: cool, clear, overcast, night or warm.")
]
ImageSize = Annotated[int, typer.Option(help="Width and height of the images in pixels.")]
FieldOfView = Annotated[float, typer.Option(help="Field of view of the cameras in degrees.")]
Errors = Annotated[
    str,
    typer.Option(
        help="Errors of vehicles and cameras: none, rtk (as in the field, with corrected positions) or gnss (with "
        "positions by satellites alone)."
    ),
]
WindSpeed = Annotated[
    float | None,
    typer.Option("--wind", help="Mean wind in m/s, from the west, with gusts (default: that of --errors)."),
]
NoRender = Annotated[
    bool, typer.Option("--no-render", help="Show the cameras a chequered ground instead of the forest.")
]
HttpPort = Annotated[int, typer.Option(help="Port of the image server; 0 takes any free one.")]
ReportFile = Annotated[
    Path | None, typer.Option(help="Write the truth about the flight here, as JSON, once a second and at the end.")
]
ExitWithParent = Annotated[
    bool, typer.Option("--exit-with-parent", help="End when the process that started this one has ended.")
]


def parse_origin(text: str) -> GeodeticPosition:
    """Read ``LAT,LON,ALT``.

    Raises:
        ConfigurationError: the text is no such place.
    """
    try:
        latitude_deg, longitude_deg, altitude_amsl_m = (float(part) for part in text.split(","))
    except ValueError as error:
        raise ConfigurationError(f"--origin must be LAT,LON,ALT (three numbers), got {text!r}.") from error
    if not (abs(latitude_deg) < 90.0 and abs(longitude_deg) <= 180.0 and math.isfinite(altitude_amsl_m)):
        raise ConfigurationError(f"--origin must be a latitude, a longitude and an altitude, got {text!r}.")
    return GeodeticPosition(latitude_deg, longitude_deg, AmslM(altitude_amsl_m))


def require_writable(**files: Path | None) -> None:
    """Refuse files that cannot be written, before anything is simulated.

    Args:
        files: files by the name of their option; None: not wanted.

    Raises:
        ConfigurationError: a file cannot be written; the text names the option and the remedy.
    """
    for name, path in files.items():
        option = f"--{name.replace('_', '-')}"
        if path is None:
            continue
        if path.is_dir():
            raise ConfigurationError(f"{option}: {path} is a folder; name a file in it.")
        if not path.parent.is_dir():
            raise ConfigurationError(f"{option}: there is no folder {path.parent}; make it, or name another file.")
        if not os.access(path.parent, os.W_OK | os.X_OK):
            raise ConfigurationError(f"{option}: no file can be written in {path.parent}; name one in another folder.")


def terrain_of(text: str) -> str:
    """Return a terrain as a world file can hold it: a file with its whole path."""
    return str(Path(text).resolve()) if is_file(text) else text


def image_source(scene: Scene, errors: ErrorModel, no_render: bool) -> ImageSource:
    """Return what the cameras see.

    Raises:
        ConfigurationError: the renderer is not installed.
    """
    if no_render:
        return CheckerboardGround(scene.relief)
    try:
        from aos_sim.render import Renderer  # noqa: PLC0415 - its ray tracer is an optional dependency
    except ImportError as error:
        raise ConfigurationError(
            f"The renderer needs the module {error.name}; install aos-gcs[sim] or give --no-render."
        ) from error
    return Renderer(scene, wind=errors.wind)


def world_of(scene: Scene) -> World:
    """Return what the world file tells of a scene."""
    parameters = scene.parameters
    return World(
        area_enu_m=tuple((float(east), float(north)) for east, north in scene.area_enu_m),
        targets=tuple(
            Target(person.name, _point(person.position_enu_m), person.height_m, person.walk) for person in scene.persons
        ),
        seed=parameters.seed,
        trees_per_ha=parameters.trees_per_ha,
        animals=parameters.animals,
        stones=parameters.stones,
        cloths=parameters.cloths,
        stumps=parameters.stumps,
        waters=parameters.waters,
        persons=parameters.persons,
        posture=str(parameters.posture),
        conditions=str(parameters.conditions),
        dressed=parameters.dressed,
        in_pairs=parameters.in_pairs,
        walking_mps=parameters.walking_mps,
        terrain=parameters.terrain,
    )


def _point(position_enu_m: NDArray[np.float64]) -> EnuPoint:
    east_m, north_m, up_m = position_enu_m
    return float(east_m), float(north_m), float(up_m)


def stop_on_signals() -> asyncio.Event:
    """Return an event that is set by the first signal to end."""
    stop = asyncio.Event()
    for signal_number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(signal_number, stop.set)
    return stop


async def work_until(stop: asyncio.Event, with_parent: bool, work: Callable[[], None]) -> None:
    """Do some work once a second, and a last time at the end: when ``stop`` is set.

    Args:
        stop: ends the work.
        with_parent: whether the end of the process that has started this one ends it, too.
        work: returns at once.
    """
    parent = os.getppid()
    while not stop.is_set() and not (with_parent and os.getppid() != parent):
        work()
        with suppress(TimeoutError):
            async with asyncio.timeout(_PERIOD_S):
                await stop.wait()
    work()
