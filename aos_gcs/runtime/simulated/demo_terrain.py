"""The ground of a simulated mission as the elevation model of its service, and the layers that clear it."""

from __future__ import annotations

import asyncio
import math
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from aos_gcs.config.model import ServiceConfig
from aos_gcs.config.settings import mission_settings
from aos_gcs.elevation.model import ModelKind
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.mission.preflight.checks import RETURN_CLIMB
from aos_gcs.planning.plan import plan_of
from aos_gcs.planning.settings import FlightSettings, MissionSettings, TerrainSettings
from aos_gcs.planning.terrain.check import highest_flown_ground_m

LEVEL = "flat"
FLOOR_ABOVE_GROUND_M = 25.0
"""Floor above the ground: 10 m below the lowest layer, as altitudes by satellites alone err by metres."""
SIMULATED = "simulated vehicles"
"""Why a simulated mission may fly although its returns may climb through the layers of others."""
EXIT_REFUSED = 2
"""Exit code of a simulator that cannot use an option; it has said so in one line."""

_FILE_ENDINGS = (".tif", ".tiff", ".asc")
_LAUNCH_SITE_ENU_M = ((-50.0, -22.0), (50.0, -22.0), (50.0, 0.0), (-50.0, 0.0))
"""Corners of the place where the simulator's vehicles stand, however many."""


async def elevation_model(terrain: str, *, seed: int, origin: str, folder: Path) -> Path | None:
    """Return the file of the ground that the simulator has; None where it is level.

    Args:
        terrain: as of the simulator's option ``--terrain``.
        seed: seed of the world.
        origin: as of the simulator's option ``--origin``.
        folder: folder for the file, made if need be; a file that the user has named stays where it is.

    Raises:
        ConfigurationError: the simulator refuses the terrain, or the file cannot be written.
    """
    if terrain == LEVEL:
        return None
    if terrain.lower().endswith(_FILE_ENDINGS):
        return await asyncio.to_thread(Path(terrain).resolve)
    path = folder / f"terrain-{terrain.replace(':', '-')}-{seed}.tif"
    await asyncio.to_thread(_make, folder)
    # Put in its place as a whole: another mission may read a file of the same name.
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        written = Path(temporary) / path.name
        await _simulator(
            *("--terrain", terrain, "--terrain-file", str(written), "--terrain-only"),
            *("--seed", str(seed), "--origin", origin),
        )
        await asyncio.to_thread(written.replace, path)
    return await asyncio.to_thread(path.resolve)


def above_ground(settings: MissionSettings, file: Path, *, follow: bool = False) -> MissionSettings:
    """Return the settings of a mission that knows its ground, with layers raised by the highest that it flies over.

    Args:
        settings: settings with the origin.
        file: elevation model.
        follow: whether the layers follow the ground, and are as high above it as usual.

    Raises:
        ConfigurationError: the file cannot be used, or the ground below the mission is not known.
    """
    ground = TerrainSettings(
        files=(str(file),), kind=ModelKind.TERRAIN, floor_above_ground_m=FLOOR_ABOVE_GROUND_M, follow=follow
    )
    known = replace(settings, terrain=ground)
    if follow:
        overrides = {**settings.preflight.overrides, RETURN_CLIMB: SIMULATED}
        return replace(
            known,
            flight=replace(settings.flight, lowest_layer_m=FlightSettings().lowest_layer_m),
            preflight=replace(settings.preflight, overrides=overrides),
        )
    try:
        highest_m = highest_flown_ground_m(plan_of(known), known, _LAUNCH_SITE_ENU_M)
    except InputDataError as error:
        raise ConfigurationError(str(error)) from error
    lowest_m = FlightSettings().lowest_layer_m + max(0, math.ceil(highest_m))
    return replace(known, flight=replace(settings.flight, lowest_layer_m=lowest_m))


def terrain_tables(file: Path, config: ServiceConfig, *, follow: bool = False) -> dict[str, Any]:
    """Return the tables of a configuration by which a service flies over the ground of a file.

    Args:
        file: elevation model.
        config: configuration without it.
        follow: whether the layers follow the ground.

    Raises:
        ConfigurationError: the file cannot be used, or the ground below the mission is not known.
    """
    settings = above_ground(mission_settings(config), file, follow=follow)
    flight = {
        "lowest_layer_m": settings.flight.lowest_layer_m,
        "layer_spacing_m": settings.flight.layer_spacing_m,
    }
    table = {
        "files": [str(file)],
        "kind": str(ModelKind.TERRAIN),
        "floor_above_ground_m": FLOOR_ABOVE_GROUND_M,
        "follow": follow,
    }
    overrides = [f"{name}: {reason}" for name, reason in settings.preflight.overrides.items()]
    preflight = {**config.preflight.model_dump(), "overrides": overrides}
    return {"terrain": table, "flight": flight, "preflight": preflight}


async def _simulator(*arguments: str) -> None:
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "aos_gcs", "sim", *arguments),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
    )
    _, said = await process.communicate()
    if process.returncode != 0:
        lines = said.decode(errors="replace").strip().splitlines() or ["it said nothing"]
        raise ConfigurationError(lines[-1].removeprefix("aos-gcs: "))


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigurationError(f"The folder {folder} for the ground cannot be made: {error.strerror}.") from error
