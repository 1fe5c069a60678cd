"""The truth about a world, in a file: for those who check what a service has found, and for showing it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.report import write_json
from aos_sim.world.scene import SceneParameters

_SCENE_KEYS = ("seed", "trees_per_ha", "animals", "stones", "cloths")


@dataclass(frozen=True, slots=True)
class Target:
    """A person to be found."""

    name: str
    position_enu_m: tuple[float, float, float]
    height_m: float


@dataclass(frozen=True, slots=True)
class World:
    """Location of the simulation."""

    area_enu_m: tuple[tuple[float, float], ...]
    """Corners of the search area."""
    targets: tuple[Target, ...] = ()
    seed: int = 1
    trees_per_ha: float = 0.0
    animals: int = 0
    stones: int = 0
    cloths: int = 0


def write_world_file(
    path: Path, world: World, origin: GeodeticPosition, homes_enu_m: Mapping[int, tuple[float, float, float]]
) -> None:
    """Write the world file, atomically. ``homes_enu_m`` is by system id."""
    write_json(
        path,
        {
            "origin": asdict(origin),
            **asdict(world),
            "vehicles": [{"system_id": system_id, "home_enu_m": home} for system_id, home in homes_enu_m.items()],
        },
    )


def read_world_file(path: Path) -> tuple[SceneParameters, GeodeticPosition]:
    """Return the parameters of a world and its origin.

    Raises:
        InputDataError: the file cannot be read or is no world file.
        ConfigurationError: a value is out of its range.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        origin = GeodeticPosition(**{key: float(value) for key, value in content["origin"].items()})
        scene = {key: content[key] for key in _SCENE_KEYS}
    except OSError as error:
        raise InputDataError(f"The world file {path} cannot be read: {error.strerror}.") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputDataError(
            f"{path} is no world file ({error}); aos-gcs sim and aos-gcs sim-camera write one with --world-file."
        ) from error
    return SceneParameters(**scene), origin
