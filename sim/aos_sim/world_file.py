"""The truth about a world, in a file: for those who check what a service has found, and for showing it again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.walks import Walk
from aos_sim.report import write_json
from aos_sim.world.conditions import Conditions
from aos_sim.world.person import Posture
from aos_sim.world.scene import SceneParameters
from aos_sim.world.terrain import FLAT

_SCENE_KEYS = ("seed", "trees_per_ha", "animals", "stones", "cloths")
_LATER_KEYS = ("stumps", "waters", "persons", "posture", "conditions", "dressed", "in_pairs", "walking_mps", "terrain")
"""Fields that files of older versions lack; they had their defaults."""


@dataclass(frozen=True, slots=True)
class Target:
    """A person to be found."""

    name: str
    position_enu_m: tuple[float, float, float]
    height_m: float
    walk: Walk | None = None
    """Way about the position since the world began; None: the person stays."""


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
    stumps: int = 0
    waters: int = 0
    persons: int = 1
    posture: str = Posture.STANDING
    conditions: str = Conditions.COOL
    dressed: bool = False
    in_pairs: bool = False
    walking_mps: float = 0.0
    terrain: str = FLAT
    """Terrain as in :attr:`aos_sim.world.scene.SceneParameters.terrain`; a file with its whole path."""


def scene_parameters(fields: Mapping[str, Any]) -> SceneParameters:
    """Return the parameters of a world from the fields of its file.

    Raises:
        KeyError: a field is missing.
        ConfigurationError: a value is out of its range.
    """
    scene = {key: fields[key] for key in _SCENE_KEYS}
    return SceneParameters(**scene, **{key: fields[key] for key in _LATER_KEYS if key in fields})


def write_world_file(
    path: Path,
    world: World,
    origin: GeodeticPosition,
    homes_enu_m: Mapping[int, tuple[float, float, float]],
    start_utc_s: float,
    *,
    board_ids: Mapping[int, str] | None = None,
) -> None:
    """Write the world file, atomically.

    Args:
        path: the file.
        world: what it tells.
        origin: origin of the world's frame.
        homes_enu_m: launch points by system id.
        start_utc_s: time by the simulation's clock, since the Unix epoch, at which the world began.
        board_ids: identifiers of the flight controllers by system id; None: they are not the world's own.
    """
    boards = {} if board_ids is None else {key: {"board_id": board_id} for key, board_id in board_ids.items()}
    vehicles = [{"system_id": key, "home_enu_m": home, **boards.get(key, {})} for key, home in homes_enu_m.items()]
    write_json(
        path,
        {
            "origin": asdict(origin),
            "start_utc_s": start_utc_s,
            **asdict(world),
            "vehicles": vehicles,
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
        origin = GeodeticPosition.from_fields(content["origin"])
        return scene_parameters(content), origin
    except OSError as error:
        raise InputDataError(f"The world file {path} cannot be read: {error.strerror}.") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputDataError(
            f"{path} is not a world file ({error}); aos-gcs sim and aos-gcs sim-camera write one with --world-file."
        ) from error
