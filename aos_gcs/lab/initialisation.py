"""Initialisations: forest, target's place, swarm's start and seed; the conditions that strategies share."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.walk import Route, clear_of_trunks, draw_walk, stand
from aos_gcs.lab.worlds import World, WorldParameters, build_world
from aos_gcs.swarm.line import line_axis, line_places

PAPER_FILE = "paper_initialisations.toml"

TARGET_SHARE = 0.15
"""Drawn targets stand at most so many sides of the forest off its middle, on both axes."""
WALK_SHARE = 0.3
"""Walking ones turn within so many sides of its middle."""
MAX_ASIDE_M = 8.0
EDGE_MARGIN_M = 5.0
"""Least distance of a target from the edge of the forest."""


@dataclass(frozen=True, slots=True)
class Initialisation:
    """Starting conditions of a run."""

    name: str
    world_seed: int
    target_offset_m: tuple[float, float]
    """East and north of the forest's middle; a place too near a trunk is replaced by one around it."""
    target_heading_deg: float
    scan_heading_deg: float
    """SD, the scanning direction at the start, clockwise from north."""
    aside_m: float
    """Offset of the swarm's start to the left of the line through the target along SD."""
    seed: int
    """Seed of the strategy's draws, the sensors' noise and the target's walk."""

    @property
    def scan_direction_enu(self) -> NDArray[np.float64]:
        """SD as a vector of length 1, shape (2,)."""
        heading_rad = math.radians(self.scan_heading_deg)
        return np.array([math.sin(heading_rad), math.cos(heading_rad)])


def draw_initialisations(count: int, seed: int, scenario: Scenario) -> tuple[Initialisation, ...]:
    """Return so many initialisations; the first ones of a longer list are the same.

    Raises:
        ConfigurationError: there is none to draw, or the seed is negative.
    """
    if not 1 <= count <= 100_000:
        raise ConfigurationError(f"The number of initialisations must lie within 1 and 100000, but is {count}.")
    if seed < 0:
        raise ConfigurationError(f"seed must be 0 or more, but is {seed}.")
    return tuple(_draw(number, seed, scenario) for number in range(count))


def _draw(number: int, seed: int, scenario: Scenario) -> Initialisation:
    rng = np.random.default_rng([seed, number])
    reach_m = TARGET_SHARE * scenario.forest_side_m
    east_m, north_m = rng.uniform(-reach_m, reach_m, 2)
    return Initialisation(
        name=f"{number:05d}",
        world_seed=int(rng.integers(2**31)),
        target_offset_m=(float(east_m), float(north_m)),
        target_heading_deg=float(rng.uniform(0.0, 360.0)),
        scan_heading_deg=float(rng.uniform(0.0, 360.0)),
        aside_m=float(rng.uniform(-MAX_ASIDE_M, MAX_ASIDE_M)),
        seed=int(rng.integers(2**31)),
    )


def paper_initialisations() -> tuple[Initialisation, ...]:
    """Return the three fixed ones that stand for the paper's."""
    return _parse(files("aos_gcs.lab").joinpath(PAPER_FILE).read_text(encoding="utf-8"), PAPER_FILE)


def load_initialisations(path: Path) -> tuple[Initialisation, ...]:
    """Return the initialisations in a TOML file of tables ``[[initialisation]]``.

    Raises:
        ConfigurationError: the file cannot be read, or a field is missing, unknown or of the wrong type.
    """
    try:
        return _parse(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"Cannot read the initialisations {path}: {error}.") from error


def check_initialisation(initialisation: Initialisation, scenario: Scenario) -> None:
    """Refuse a target that stands outside of the forest.

    Raises:
        ConfigurationError: naming the initialisation.
    """
    limit_m = scenario.forest_side_m / 2 - EDGE_MARGIN_M
    if max(map(abs, initialisation.target_offset_m)) > limit_m:
        raise ConfigurationError(
            f"target_offset_m of initialisation {initialisation.name} lies outside the forest: it must be within "
            f"{limit_m:g} m of its middle on both axes; move the target or enlarge forest_side_m."
        )


def world_parameters(initialisation: Initialisation, scenario: Scenario) -> WorldParameters:
    """Return which forest the initialisation stands for."""
    return WorldParameters(
        seed=initialisation.world_seed,
        trees_per_ha=scenario.trees_per_ha,
        forest=scenario.forest,
        terrain=scenario.terrain,
        side_m=scenario.forest_side_m,
        errors=scenario.errors,
    )


def open_world(initialisation: Initialisation, scenario: Scenario) -> World:
    """Build the forest of an initialisation; see :func:`aos_gcs.lab.worlds.build_world`."""
    return build_world(world_parameters(initialisation, scenario))


def target_walk(initialisation: Initialisation, scenario: Scenario, world: World) -> Route:
    """Return where the target is during the run."""
    low_m, high_m = world.area_enu_m.min(axis=0), world.area_enu_m.max(axis=0)
    middle_m = (low_m + high_m) / 2
    rng = np.random.default_rng([initialisation.seed, 1])
    place_m = clear_of_trunks(rng, middle_m + np.array(initialisation.target_offset_m), world.trunks_enu_m)
    if scenario.target_speed_mps == 0.0:
        return stand(place_m, math.radians(initialisation.target_heading_deg))
    reach_m = WALK_SHARE * scenario.forest_side_m
    return draw_walk(
        rng,
        place_m,
        speed_mps=scenario.target_speed_mps,
        duration_s=scenario.duration_s,
        low_enu_m=middle_m - reach_m,
        high_enu_m=middle_m + reach_m,
    )


def start_positions(initialisation: Initialisation, scenario: Scenario, walk: Route) -> NDArray[np.float64]:
    """Return the drones' places in the line they start in, shape (n, 2); its middle lies before the target."""
    direction = initialisation.scan_direction_enu
    middle_m = (
        walk.corners_enu_m[0] - scenario.start_distance_m * direction + initialisation.aside_m * line_axis(direction)
    )
    return line_places(middle_m, direction, scenario.drones, scenario.spacing_m)


def _parse(text: str, source: str) -> tuple[Initialisation, ...]:
    try:
        tables = tomllib.loads(text).get("initialisation")
    except tomllib.TOMLDecodeError as error:
        raise ConfigurationError(f"{source} is not TOML: {error}.") from error
    if not isinstance(tables, list) or not tables or not all(isinstance(table, dict) for table in tables):
        raise ConfigurationError(f"{source} must have tables [[initialisation]], one at least.")
    initialisations = tuple(_parse_one(table, source) for table in tables)
    if len({initialisation.name for initialisation in initialisations}) < len(initialisations):
        raise ConfigurationError(f"Two initialisations in {source} have the same name; give each its own.")
    return initialisations


def _parse_one(table: Mapping[str, Any], source: str) -> Initialisation:
    names = {item.name for item in fields(Initialisation)}
    if set(table) != names:
        wrong = ", ".join(sorted(names ^ set(table)))
        raise ConfigurationError(f"An initialisation in {source} has missing or unknown fields: {wrong}.")
    name, offset_m = table["name"], table["target_offset_m"]
    if not (isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9_-]{1,64}", name)):
        raise ConfigurationError(f"name in {source} must be letters, digits, - and _ only, but is {name!r}.")
    if not (isinstance(offset_m, list) and len(offset_m) == 2):
        raise ConfigurationError(f"target_offset_m of {name} in {source} must be [east, north] in metres.")
    for field in ("world_seed", "seed"):
        if not (isinstance(table[field], int) and table[field] >= 0):
            raise ConfigurationError(
                f"{field} of {name} in {source} must be a whole number from 0, but is {table[field]!r}."
            )
    numbers = {
        "target_offset_m east": offset_m[0],
        "target_offset_m north": offset_m[1],
        **{field: table[field] for field in ("target_heading_deg", "scan_heading_deg", "aside_m")},
    }
    for field, value in numbers.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise ConfigurationError(f"{field} of {name} in {source} must be a number, but is {value!r}.")
    return Initialisation(**{**table, "target_offset_m": (float(offset_m[0]), float(offset_m[1]))})
