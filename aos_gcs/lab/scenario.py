"""Scenarios: the parameters of the laboratory's experiments."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import Any

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.groundmap.detection import Posture
from aos_gcs.imaging.model import LeaderCriterion
from aos_gcs.lab.worlds import MAX_TREES_PER_HA, ErrorGrade, ForestType, TerrainShape

TREE_TOP_M = 18.0
"""No forest of the laboratory grows higher."""


class Fidelity(StrEnum):
    """Fidelity of the drones' sensors."""

    GEOMETRIC = "geometric"
    """Visibility rays to the target's surface: perfect detection, no images."""
    IMAGING = "imaging"
    """Rendered colour and thermal images through the imaging engine of missions."""


class TimeModel(StrEnum):
    """Model of the time that a step takes."""

    PAPER = "paper"
    """The longest way at ``speed_mps``; nothing else takes time (AOS-APSO paper, section Experiments)."""
    DYNAMICS = "dynamics"
    """Vehicles that accelerate and brake, and the time to see and to decide."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One experiment's forest, target, swarm and rules; the defaults are the paper's.

    Raises:
        ConfigurationError: a value is out of its range or does not fit the others; the text names the field.
    """

    trees_per_ha: float = 300.0
    forest: ForestType = ForestType.BROADLEAF
    terrain: TerrainShape = TerrainShape.FLAT
    forest_side_m: float = 100.0
    posture: Posture = Posture.STANDING
    target_speed_mps: float = 0.0
    """0: the target stays where it is. Only a standing one walks."""
    drones: int = 10
    altitude_m: float = 35.0
    """Height of the lowest layer above the ground."""
    layer_spacing_m: float = 1.0
    """Vertical distance of neighbouring drones; 0: all fly at one height."""
    spacing_m: float = 4.2
    """Spacing of the drones in the line in which they start."""
    fov_deg: float = 50.0
    image_size_px: int = 512
    """Width and height of the square images."""
    start_distance_m: float = 30.0
    """Distance from the middle of the line to the target, along the scanning direction."""
    duration_s: float = 20.0
    threshold: float = 0.163
    """T: normalised visibility from which the target is in view."""
    leader_criterion: LeaderCriterion = LeaderCriterion.CONTRIBUTION
    fidelity: Fidelity = Fidelity.GEOMETRIC
    errors: ErrorGrade = ErrorGrade.RTK
    """Errors of vehicles and cameras; only images show them."""
    time_model: TimeModel = TimeModel.PAPER
    speed_mps: float = 10.0
    min_step_s: float = 0.1
    """A step takes at least as long, also when nobody moves: cameras need time between two exposures."""
    acceleration_mps2: float = 3.5
    """Acceleration of the vehicles in the dynamic time model."""
    processing_s: float = 0.6
    """Time from arrival to the next command in the dynamic time model (default: reported for a real swarm of six)."""

    def __post_init__(self) -> None:
        for name, low, high in _RANGES:
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise ConfigurationError(f"{name} must lie within {low:g} and {high:g}, but is {value:g}.")
        if self.target_speed_mps > 0.0 and self.posture is not Posture.STANDING:
            raise ConfigurationError(
                f"target_speed_mps must be 0 for a {self.posture} target; only a standing one walks."
            )
        width_m = (self.drones - 1) * self.spacing_m
        if width_m > self.forest_side_m:
            raise ConfigurationError(
                f"spacing_m does not fit: {self.drones} drones at {self.spacing_m:g} m make a line of {width_m:g} m, "
                f"wider than forest_side_m, {self.forest_side_m:g} m; take fewer drones or a smaller spacing."
            )
        if self.start_distance_m > self.forest_side_m / 2:
            raise ConfigurationError(
                f"start_distance_m must be at most half of forest_side_m, {self.forest_side_m / 2:g} m, "
                f"but is {self.start_distance_m:g}; start nearer or take a larger forest."
            )

    @property
    def camera(self) -> CameraModel:
        """The camera that all drones carry."""
        return CameraModel.from_fov(self.image_size_px, self.image_size_px, math.radians(self.fov_deg))


_RANGES = (
    ("trees_per_ha", 0.0, MAX_TREES_PER_HA),
    ("forest_side_m", 40.0, 300.0),
    ("target_speed_mps", 0.0, 10.0),
    ("drones", 2, 100),
    ("altitude_m", TREE_TOP_M + 2.0, 200.0),
    ("layer_spacing_m", 0.0, 10.0),
    ("spacing_m", 0.1, 50.0),
    ("fov_deg", 5.0, 120.0),
    ("image_size_px", 32, 4096),
    ("start_distance_m", 0.0, 150.0),
    ("duration_s", 0.1, 3600.0),
    ("threshold", 0.001, 1.0),
    ("speed_mps", 0.1, 50.0),
    ("min_step_s", 0.01, 10.0),
    ("acceleration_mps2", 0.1, 20.0),
    ("processing_s", 0.0, 60.0),
)


def load_scenario(path: Path) -> dict[str, object]:
    """Return the settings in a TOML or JSON file, for :func:`parse_scenario`.

    Raises:
        ConfigurationError: the file cannot be read, or is no table of settings.
    """
    try:
        text = path.read_text(encoding="utf-8")
        settings = json.loads(text) if path.suffix.lower() == ".json" else tomllib.loads(text)
    except OSError as error:
        raise ConfigurationError(f"Cannot read the scenario {path}: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise ConfigurationError(f"The scenario {path} is neither TOML nor (as .json) JSON: {error}.") from error
    if not isinstance(settings, dict):
        raise ConfigurationError(f"The scenario {path} must be a table of settings, such as drones = 10.")
    return settings


def parse_scenario(settings: Mapping[str, object]) -> Scenario:
    """Return the scenario of these settings; absent ones take their defaults.

    Raises:
        ConfigurationError: a name is unknown, or a value has the wrong type or is out of its range.
    """
    defaults = {item.name: item.default for item in fields(Scenario)}
    for name in settings:
        if name not in defaults:
            raise ConfigurationError(f"A scenario has no field {name}; it has {', '.join(sorted(defaults))}.")
    values: dict[str, Any] = {name: _converted(name, value, defaults[name]) for name, value in settings.items()}
    return Scenario(**values)


def _converted(name: str, value: object, default: object) -> object:
    """Return a user's value in the type of the field's default."""
    if isinstance(default, StrEnum):
        if value not in tuple(type(default)):
            raise ConfigurationError(f"{name} must be one of {', '.join(type(default))}, but is {value!r}.")
        return type(default)(str(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigurationError(f"{name} must be a number, but is {value!r}.")
    if isinstance(default, int) and not float(value).is_integer():
        raise ConfigurationError(f"{name} must be a whole number, but is {value!r}.")
    return int(value) if isinstance(default, int) else float(value)
