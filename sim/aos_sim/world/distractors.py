"""Distractors: warm animals, sun-warmed stones and stumps, bright cloth, puddles.

Sizes and temperatures are assumptions for a cool morning (ground 10.8 °C, clothed persons 24-28 °C with bare skin at
31-33 °C): fur insulates, so that an animal looks cooler than a person but for its head and legs; a stone is warmest on
its top, as is the cut of a stump; cloth has the temperature of the air and only its colour stands out; water is cold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.mesh import FloatArray, Material, Mesh, concatenate, ellipsoid, tubes, uniform_mesh

_SKY_SHARE = 0.5
_STONE_TOP_K = 3.0
"""Temperature difference between the top of a stone and its sides."""
_FUR_COLOURS = {"deer": (132, 92, 60), "boar": (70, 62, 56)}
_CLOTH_COLOURS = ((226, 108, 28), (196, 44, 40), (60, 120, 220), (236, 224, 60), (240, 240, 240))


class DistractorKind(StrEnum):
    """Kind of a distractor."""

    DEER = "deer"
    BOAR = "boar"
    STONE = "stone"
    CLOTH = "cloth"
    STUMP = "stump"
    WATER = "water"


@dataclass(frozen=True, slots=True, eq=False)
class Distractor:
    """Something in the world that is not a person."""

    kind: DistractorKind
    position_enu_m: NDArray[np.float64]
    """Point on the ground below its middle, shape (3,)."""
    heading_rad: float
    """Direction of the long axis (an animal: of its head), clockwise from north."""
    length_m: float
    width_m: float
    height_m: float
    colour_rgb: tuple[int, int, int]
    temperature_celsius: float
    """Temperature of the fur or cloth, or of the top of the stone."""
    bare_temperature_celsius: float
    """Temperature of an animal's head and legs; the others have one temperature."""


def make_distractor(rng: np.random.Generator, kind: DistractorKind, position_enu_m: NDArray[np.float64]) -> Distractor:
    """Draw size, colour, temperature and heading of a kind."""
    heading_rad = float(rng.uniform(0.0, 2 * math.pi))
    length, width, height = _draw_size(rng, kind)
    if kind is DistractorKind.STONE:
        grey = int(rng.integers(120, 180))
        colour, celsius, bare_celsius = (grey, grey - 4, grey - 10), float(rng.uniform(14.0, 26.0)), math.nan
    elif kind is DistractorKind.CLOTH:
        colour = _CLOTH_COLOURS[int(rng.integers(len(_CLOTH_COLOURS)))]
        celsius, bare_celsius = float(rng.uniform(9.5, 12.5)), math.nan
    elif kind is DistractorKind.STUMP:
        colour, celsius, bare_celsius = (150, 118, 82), float(rng.uniform(14.0, 24.0)), math.nan
    elif kind is DistractorKind.WATER:
        colour, celsius, bare_celsius = (58, 68, 74), float(rng.uniform(6.0, 10.0)), math.nan
    else:
        colour, celsius = _FUR_COLOURS[kind], float(rng.uniform(15.5, 22.5))
        bare_celsius = celsius + float(rng.uniform(3.0, 6.0))
    return Distractor(kind, position_enu_m, heading_rad, length, width, height, colour, celsius, bare_celsius)


def _draw_size(rng: np.random.Generator, kind: DistractorKind) -> tuple[float, float, float]:
    """Length, width and height in metres."""
    if kind is DistractorKind.STONE:
        length = float(rng.uniform(0.5, 1.6))
        return length, length * float(rng.uniform(0.5, 1.0)), length * float(rng.uniform(0.3, 0.5))
    if kind is DistractorKind.CLOTH:
        return float(rng.uniform(0.8, 1.8)), float(rng.uniform(0.4, 0.9)), 0.06
    if kind is DistractorKind.STUMP:
        length = float(rng.uniform(0.4, 0.8))
        return length, length * float(rng.uniform(0.85, 1.0)), float(rng.uniform(0.3, 0.6))
    if kind is DistractorKind.WATER:
        return float(rng.uniform(1.0, 3.0)), float(rng.uniform(0.6, 1.6)), 0.02
    length = float(rng.uniform(1.1, 1.8))
    if kind is DistractorKind.DEER:
        return length, 0.28 * length, 0.72 * length
    return length, 0.34 * length, 0.58 * length


def distractor_mesh(distractor: Distractor) -> Mesh:
    """Build the body."""
    size_m = np.array([distractor.width_m, distractor.length_m, distractor.height_m])
    is_animal = distractor.kind in (DistractorKind.DEER, DistractorKind.BOAR)
    mesh = _animal(distractor) if is_animal else _mound(distractor)
    sin, cos = math.sin(distractor.heading_rad), math.cos(distractor.heading_rad)
    R_body2enu = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    placed_m = mesh.triangles_enu_m * size_m @ R_body2enu.T + distractor.position_enu_m
    return replace(mesh, triangles_enu_m=placed_m.astype(np.float32))


def _mound(distractor: Distractor) -> Mesh:
    """Half sunk into the ground: an ellipsoid of twice the height; units as in :func:`_animal`."""
    triangles = ellipsoid((0.0, 0.0, 0.0), (0.5, 0.5, 1.0))
    if distractor.kind is DistractorKind.CLOTH:
        celsius = np.full(len(triangles), distractor.temperature_celsius)
        return uniform_mesh(triangles, Material.FABRIC, distractor.colour_rgb, celsius, _SKY_SHARE)
    if distractor.kind is DistractorKind.WATER:
        return uniform_mesh(
            triangles, Material.WATER, distractor.colour_rgb, distractor.temperature_celsius, _SKY_SHARE
        )
    below_top = 1.0 - np.clip(triangles[..., 2].mean(axis=1), 0.0, 1.0)
    celsius = distractor.temperature_celsius - _STONE_TOP_K * below_top
    return uniform_mesh(triangles, Material.STONE, distractor.colour_rgb, celsius, _SKY_SHARE)


def _animal(animal: Distractor) -> Mesh:
    """Trunk with fur, warmer head and legs; (right, front, up) in units of width, length and height."""

    def part(triangles: FloatArray, celsius: float) -> Mesh:
        return uniform_mesh(triangles, Material.FUR, animal.colour_rgb, celsius, _SKY_SHARE)

    feet = [(right, front, 0.0) for right in (-0.3, 0.3) for front in (-0.28, 0.22)]
    hips = [(right, front, 0.55) for right, front, _ in feet]
    legs = tubes(feet, hips, np.full(4, 0.05), np.full(4, 0.09), sides=6)
    return concatenate(
        [
            part(ellipsoid((0.0, -0.05, 0.66), (0.5, 0.38, 0.3)), animal.temperature_celsius),
            part(ellipsoid((0.0, 0.38, 0.84), (0.24, 0.14, 0.16)), animal.bare_temperature_celsius),
            part(legs, animal.bare_temperature_celsius),
        ]
    )
