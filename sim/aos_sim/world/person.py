"""Persons and their bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.walks import Walk
from aos_sim.world.mesh import FloatArray, Material, Mesh, concatenate, ellipsoid, tubes, uniform_mesh
from aos_sim.world.relief import Relief

_TROUSERS_SHADE = 0.55
"""Brightness of the trousers relative to the jacket."""
_SKIN_RGB = (205.0, 160.0, 130.0)
_HAIR_RGB = (60.0, 45.0, 35.0)
_HOOD_M = 0.012
"""Thickness of a hood, in statures."""
_BLANKET_K = 9.0
"""Difference by which the outside of a blanket is cooler than that of clothes."""
_BLANKET_SHADE = 0.7
_SIDES = 10
_SKY_SHARE = 0.5


class Posture(StrEnum):
    """Posture of a person."""

    STANDING = "standing"
    SITTING = "sitting"
    LYING = "lying"
    WALKING = "walking"
    """Posture in mid-stride."""


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """A person in the world."""

    name: str
    position_enu_m: NDArray[np.float64]
    """Point on the ground below the body's middle, shape (3,); of one who walks, at the beginning."""
    heading_rad: float
    """Direction of the chest (lying: of the feet), clockwise from north."""
    height_m: float
    """Stature, whatever the posture."""
    posture: Posture
    clothing_rgb: tuple[int, int, int]
    skin_temperature_celsius: float
    clothing_temperature_celsius: float
    hooded: bool = False
    gloved: bool = False
    masked: bool = False
    """Face behind a cloth that is as warm as the clothes."""
    blanket: bool = False
    """Covered from the shoulders to the knees by a blanket that insulates."""
    walk: Walk | None = None
    """None: the person stays in its place."""

    def at(self, at_s: float, relief: Relief | None = None) -> Person:
        """Return the person as it is, staying, at a moment: seconds since the world began.

        Args:
            at_s: the moment.
            relief: the ground on which it walks; None: level ground.
        """
        if self.walk is None:
            return self
        (east_m, north_m), heading_rad = self.walk.at(at_s)
        position_enu_m = self.position_enu_m + np.array([east_m, north_m, 0.0])
        if relief is not None:
            position_enu_m[2] = relief.height_m(*position_enu_m[:2])
        return replace(self, position_enu_m=position_enu_m, heading_rad=heading_rad, walk=None)


@dataclass(frozen=True, slots=True)
class _Limb:
    """A tapered limb; points are (right, front, up) for a stature of one."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    start_radius: float
    end_radius: float
    is_leg: bool


@dataclass(frozen=True, slots=True)
class _Body:
    """The proportions of a posture, in statures."""

    limbs: tuple[_Limb, ...]
    torso_centre: tuple[float, float, float]
    head_centre: tuple[float, float, float]
    blanket_size: tuple[float, float, float] = (0.16, 0.12, 0.34)
    """Half axes of a blanket, and its middle relative to the torso's."""
    blanket_front: float = 0.0
    blanket_up: float = -0.12


def person_mesh(person: Person) -> Mesh:
    """Build the body: trousers, jacket, hands and head, about a thousand triangles."""
    body = _BODIES.get(person.posture, _STANDING)
    clothing = np.asarray(person.clothing_rgb, dtype=np.float64)
    clothing_celsius, skin_celsius = person.clothing_temperature_celsius, person.skin_temperature_celsius

    def clothed(triangles: FloatArray, brightness: float = 1.0) -> Mesh:
        return uniform_mesh(triangles, Material.CLOTHING, clothing * brightness, clothing_celsius, _SKY_SHARE)

    def bare(triangles: FloatArray) -> Mesh:
        return uniform_mesh(triangles, Material.SKIN, _SKIN_RGB, skin_celsius, _SKY_SHARE)

    hair = uniform_mesh(_hair(body.head_centre), Material.SKIN, _HAIR_RGB, skin_celsius - 3.0, _SKY_SHARE)
    if person.hooded:
        hair = clothed(_hair(body.head_centre, _HOOD_M))
    hand = clothed if person.gloved else bare
    face = clothed if person.masked else bare
    parts = [clothed(ellipsoid(body.torso_centre, (0.125, 0.08, 0.19)))]
    parts += [clothed(_tube(limb), _TROUSERS_SHADE if limb.is_leg else 1.0) for limb in body.limbs]
    parts += [face(ellipsoid(body.head_centre, (0.045, 0.056, 0.066))), hair]
    parts += [hand(ellipsoid(limb.end, (0.025, 0.025, 0.045))) for limb in body.limbs if not limb.is_leg]
    if person.blanket:
        right, front, up = body.torso_centre
        centre = (right, front + body.blanket_front, up + body.blanket_up)
        cover_celsius = clothing_celsius - _BLANKET_K
        cover = ellipsoid(centre, body.blanket_size)
        parts.append(uniform_mesh(cover, Material.FABRIC, clothing * _BLANKET_SHADE, cover_celsius, _SKY_SHARE))
    mesh = concatenate(parts)
    placed = _placed(mesh.triangles_enu_m.astype(np.float64), person)
    return replace(mesh, triangles_enu_m=placed.astype(np.float32))


def _tube(limb: _Limb) -> FloatArray:
    return tubes([limb.start], [limb.end], [limb.start_radius], [limb.end_radius], sides=_SIDES)


def _hair(head_centre: tuple[float, float, float], thicker: float = 0.0) -> FloatArray:
    right, front, up = head_centre
    return ellipsoid((right, front - 0.012, up + 0.012), (0.046 + thicker, 0.052 + thicker, 0.058 + thicker))


def _placed(points: NDArray[np.float64], person: Person) -> NDArray[np.float64]:
    """Unit body (right, front, up) to the world."""
    if person.posture is Posture.LYING:
        # On the back, the middle of the body over the origin, feet ahead.
        points = np.stack([points[..., 0], 0.5 - points[..., 2], points[..., 1] + 0.08], axis=-1)
    sin, cos = math.sin(person.heading_rad), math.cos(person.heading_rad)
    R_body2enu = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(points * person.height_m @ R_body2enu.T + person.position_enu_m)


_STANDING = _Body(
    limbs=(
        _Limb((-0.055, 0.0, 0.0), (-0.055, 0.0, 0.5), 0.035, 0.055, is_leg=True),
        _Limb((0.055, 0.0, 0.0), (0.055, 0.0, 0.5), 0.035, 0.055, is_leg=True),
        _Limb((-0.125, 0.0, 0.79), (-0.17, 0.04, 0.46), 0.036, 0.026, is_leg=False),
        _Limb((0.125, 0.0, 0.79), (0.17, 0.04, 0.46), 0.036, 0.026, is_leg=False),
    ),
    torso_centre=(0.0, 0.0, 0.65),
    head_centre=(0.0, 0.01, 0.93),
)

_SITTING = _Body(
    limbs=(
        _Limb((-0.06, 0.0, 0.06), (-0.07, 0.22, 0.24), 0.056, 0.045, is_leg=True),
        _Limb((0.06, 0.0, 0.06), (0.07, 0.22, 0.24), 0.056, 0.045, is_leg=True),
        _Limb((-0.07, 0.22, 0.24), (-0.07, 0.34, 0.0), 0.043, 0.032, is_leg=True),
        _Limb((0.07, 0.22, 0.24), (0.07, 0.34, 0.0), 0.043, 0.032, is_leg=True),
        _Limb((-0.125, 0.0, 0.34), (-0.1, 0.2, 0.22), 0.036, 0.026, is_leg=False),
        _Limb((0.125, 0.0, 0.34), (0.1, 0.2, 0.22), 0.036, 0.026, is_leg=False),
    ),
    torso_centre=(0.0, -0.01, 0.19),
    head_centre=(0.0, 0.02, 0.47),
    blanket_size=(0.18, 0.26, 0.22),
    blanket_front=0.12,
    blanket_up=0.0,
)

_WALKING = _Body(
    limbs=(
        _Limb((-0.055, 0.17, 0.0), (-0.055, 0.0, 0.5), 0.035, 0.055, is_leg=True),
        _Limb((0.055, -0.17, 0.02), (0.055, 0.0, 0.5), 0.035, 0.055, is_leg=True),
        _Limb((-0.125, 0.0, 0.79), (-0.16, -0.14, 0.48), 0.036, 0.026, is_leg=False),
        _Limb((0.125, 0.0, 0.79), (0.16, 0.16, 0.5), 0.036, 0.026, is_leg=False),
    ),
    torso_centre=(0.0, 0.01, 0.65),
    head_centre=(0.0, 0.03, 0.93),
)

_BODIES = {Posture.SITTING: _SITTING, Posture.WALKING: _WALKING}
