"""The whole scene of a simulated search: launch clearing, forest, the persons to find, and what distracts from them.

Frame: ENU metres, origin on the ground in the middle of the launch site. The ground is the plane z = 0, or a relief of
the height 0 at the origin. The launch clearing lies south of the forest, which is a square and the search area.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.walks import Walk
from aos_sim.world.conditions import Conditions
from aos_sim.world.distractors import Distractor, DistractorKind, make_distractor
from aos_sim.world.forest import Forest, grow_forest
from aos_sim.world.ground import Ground, make_ground
from aos_sim.world.mesh import Mesh
from aos_sim.world.person import Person, Posture
from aos_sim.world.relief import Relief
from aos_sim.world.species import BROADLEAF, Species
from aos_sim.world.terrain import FLAT, check_terrain, make_relief

FOREST_SOUTH_M = 8.0
CLEARING_SOUTH_M = -20.0

_MAX_TREES_PER_HA = 2000.0
_MAX_BODIES = 100
_TRUNK_CLEARANCE_M = 2.0
_DISTRACTOR_CLEARANCE_M = 8.0
"""Distance that distractors keep from persons and from one another where there is room for it."""
_PLACE_CANDIDATES = 256
_COMPANY_M = (0.8, 2.0)
"""Least and greatest distance of two persons who keep company."""
_DRESS_SHARES = np.array([0.4, 0.4, 0.3])
"""Share of persons with a hood, with gloves and, of those who sit or lie, with a blanket."""
_MAX_WALKING_MPS = 5.0
_WALK_M = 8.0
"""Length of the line along which a person walks to and fro."""
_WALK_CANDIDATES = 16
_CLOTHING_COLOURS = ((196, 44, 40), (226, 108, 28), (40, 84, 190), (214, 190, 40), (170, 50, 130))


@dataclass(frozen=True, slots=True)
class SceneParameters:
    """Parameters of a scene.

    Raises:
        ConfigurationError: if a value is out of its range.
    """

    seed: int = 1
    trees_per_ha: float = 300.0
    """Tree density, 0 (no forest) to 2000."""
    side_m: float = 100.0
    """Side of the forest square."""
    species: Species = BROADLEAF
    """Species of all trees."""
    persons: int = 1
    """Number from 0 to 100."""
    posture: Posture = Posture.STANDING
    animals: int = 0
    """Deer and boars, from 0 to 100, as are stones and cloths."""
    stones: int = 0
    cloths: int = 0
    stumps: int = 0
    waters: int = 0
    conditions: Conditions = Conditions.COOL
    """Weather and time of day."""
    dressed: bool = False
    """Whether hoods, gloves and blankets are drawn; without, nobody wears any."""
    in_pairs: bool = False
    """Whether every second person keeps company to the one before."""
    walking_mps: float = 0.0
    """Speed at which persons in the posture *walking* go to and fro; 0: they stay in mid-stride."""
    terrain: str = FLAT
    """Shape of the ground: ``flat``, ``hills``, ``slope:PERCENT`` or the name of a file with heights."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigurationError(f"seed must be 0 or more, got {self.seed}.")
        if not 0.0 <= self.trees_per_ha <= _MAX_TREES_PER_HA:
            raise ConfigurationError(f"trees_per_ha must lie within 0 and 2000, got {self.trees_per_ha}.")
        if not 10.0 <= self.side_m <= 300.0:
            raise ConfigurationError(f"side_m must lie within 10 and 300 metres, got {self.side_m}.")
        for name in ("persons", "animals", "stones", "cloths", "stumps", "waters"):
            if not 0 <= getattr(self, name) <= _MAX_BODIES:
                raise ConfigurationError(f"{name} must lie within 0 and {_MAX_BODIES}, got {getattr(self, name)}.")
        if self.posture not in tuple(Posture):
            raise ConfigurationError(f"posture must be one of {', '.join(Posture)}, got {self.posture!r}.")
        if not 0.0 <= self.walking_mps <= _MAX_WALKING_MPS:
            raise ConfigurationError(f"walking_mps must lie within 0 and {_MAX_WALKING_MPS:g}, got {self.walking_mps}.")
        if self.walking_mps > 0.0 and self.posture != Posture.WALKING:
            raise ConfigurationError(f"walking_mps needs the posture walking, got {self.posture}.")
        if self.conditions not in tuple(Conditions):
            raise ConfigurationError(f"conditions must be one of {', '.join(Conditions)}, got {self.conditions!r}.")
        check_terrain(self.terrain)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A world, in which persons may walk and nothing else changes."""

    parameters: SceneParameters
    persons: tuple[Person, ...]
    """The targets."""
    forest: Forest
    """Trees; its mesh has a material, colour and temperature per triangle."""
    ground: Ground
    area_enu_m: NDArray[np.float64]
    """Search area: corners of the forest square, counter-clockwise from the south-west, shape (4, 2)."""
    distractors: tuple[Distractor, ...] = ()
    """Distractors in the scene."""
    relief: Relief | None = None
    """Shape of the ground; None: the plane z = 0."""

    def persons_at(self, at_s: float) -> tuple[Person, ...]:
        """Return the persons as they are, staying, at a moment: seconds since the world began."""
        return tuple(person.at(at_s, self.relief) for person in self.persons)

    def draped(self, mesh: Mesh, place_enu_m: NDArray[np.float64]) -> Mesh:
        """Return a body that stands or lies at a place as it follows the slope of the ground there."""
        if self.relief is None:
            return mesh
        flat_m = mesh.triangles_enu_m - np.array([0.0, 0.0, place_enu_m[2]], np.float32)
        return replace(mesh, triangles_enu_m=self.relief.lifted(flat_m))


def build_scene(parameters: SceneParameters, origin: GeodeticPosition | None = None) -> Scene:
    """Build the world of these parameters: equal ones give equal worlds.

    The persons' places do not depend on their posture or on distractors, nor the ground on the forest's density.
    Everything stands at the same places on every terrain.

    Args:
        parameters: what there is.
        origin: place of the origin on the globe, which a terrain of a file needs.

    Raises:
        ConfigurationError: the terrain is that of a file that cannot be used.
    """
    forest_rng, person_rng, ground_rng, distractor_rng, dress_rng, walk_rng = np.random.default_rng(
        parameters.seed
    ).spawn(6)
    side = parameters.side_m
    west = -side / 2
    forest = grow_forest(forest_rng, (west, FOREST_SOUTH_M), side, parameters.trees_per_ha, parameters.species)
    persons = tuple(_make_person(person_rng, index, parameters, forest) for index in range(1, parameters.persons + 1))
    if parameters.in_pairs:
        persons = _paired(dress_rng, persons)
    if parameters.dressed:
        persons = tuple(_dressed(dress_rng, person) for person in persons)
    if parameters.walking_mps > 0.0:
        persons = tuple(_walking(walk_rng, person, parameters.walking_mps, forest.trunk_enu_m) for person in persons)
    scene = Scene(
        parameters=parameters,
        persons=persons,
        forest=forest,
        ground=make_ground(ground_rng, west, FOREST_SOUTH_M, side),
        area_enu_m=_rectangle(west, FOREST_SOUTH_M, -west, FOREST_SOUTH_M + side),
        distractors=_make_distractors(distractor_rng, parameters, forest, persons),
    )
    relief = build_relief(parameters, origin)
    return scene if relief is None else _standing_on(relief, scene)


def build_relief(parameters: SceneParameters, origin: GeodeticPosition | None = None) -> Relief | None:
    """Build the ground of a scene alone, by the arguments of :func:`build_scene`; None where it is level."""
    east_m = parameters.side_m / 2
    box = (-east_m, CLEARING_SOUTH_M, east_m, FOREST_SOUTH_M + parameters.side_m)
    return make_relief(parameters.terrain, parameters.seed, box, level_north_m=FOREST_SOUTH_M, origin=origin)


def _standing_on(relief: Relief, scene: Scene) -> Scene:
    """Return a scene of level ground with everything at the same place on another ground."""
    return replace(
        scene,
        relief=relief,
        forest=scene.forest.on(relief),
        persons=tuple(replace(person, position_enu_m=relief.lifted(person.position_enu_m)) for person in scene.persons),
        distractors=tuple(
            replace(body, position_enu_m=relief.lifted(body.position_enu_m)) for body in scene.distractors
        ),
    )


def _make_person(rng: np.random.Generator, index: int, parameters: SceneParameters, forest: Forest) -> Person:
    east, north = _place(rng, _window(parameters.side_m), [(forest.trunk_enu_m, _TRUNK_CLEARANCE_M)])
    return Person(
        name=f"person-{index}",
        position_enu_m=np.array([east, north, 0.0]),
        heading_rad=float(rng.uniform(0.0, 2 * math.pi)),
        height_m=float(rng.uniform(1.68, 1.82)),
        posture=Posture(parameters.posture),
        clothing_rgb=_CLOTHING_COLOURS[int(rng.integers(len(_CLOTHING_COLOURS)))],
        skin_temperature_celsius=float(rng.uniform(31.0, 33.0)),
        clothing_temperature_celsius=float(rng.uniform(24.0, 28.0)),
    )


def _paired(rng: np.random.Generator, persons: tuple[Person, ...]) -> tuple[Person, ...]:
    """Return the persons with every second one beside the one before."""
    placed = list(persons)
    for index in range(1, len(placed), 2):
        direction_rad, away_m = rng.uniform(0.0, 2 * math.pi), rng.uniform(*_COMPANY_M)
        offset_m = away_m * np.array([math.sin(direction_rad), math.cos(direction_rad), 0.0])
        placed[index] = replace(placed[index], position_enu_m=placed[index - 1].position_enu_m + offset_m)
    return tuple(placed)


def _dressed(rng: np.random.Generator, person: Person) -> Person:
    hooded, gloved, covered = rng.random(3) < _DRESS_SHARES
    rests = person.posture in (Posture.SITTING, Posture.LYING)
    return replace(person, hooded=bool(hooded), gloved=bool(gloved), blanket=bool(covered) and rests)


def _walking(rng: np.random.Generator, person: Person, speed_mps: float, trunks_enu_m: NDArray[np.float64]) -> Person:
    """Return a person who walks, in the one of some directions drawn that keeps farthest from all trunks."""
    along_m = np.linspace(-_WALK_M / 2, _WALK_M / 2, 17)
    ways = []
    for heading_rad in rng.uniform(0.0, 2 * math.pi, _WALK_CANDIDATES):
        ahead = np.array([math.sin(heading_rad), math.cos(heading_rad)])
        places_enu_m = person.position_enu_m[:2] + along_m[:, np.newaxis] * ahead
        offsets_m = places_enu_m[:, np.newaxis] - trunks_enu_m[np.newaxis, :, :2]
        ways.append((float(np.linalg.norm(offsets_m, axis=2).min(initial=math.inf)), float(heading_rad)))
    _, heading_rad = max(ways)
    return replace(person, heading_rad=heading_rad, walk=Walk(speed_mps, _WALK_M, heading_rad))


def _make_distractors(
    rng: np.random.Generator, parameters: SceneParameters, forest: Forest, persons: tuple[Person, ...]
) -> tuple[Distractor, ...]:
    animals = (DistractorKind.DEER, DistractorKind.BOAR)
    kinds = [animals[int(rng.integers(2))] for _ in range(parameters.animals)]
    kinds += [DistractorKind.STONE] * parameters.stones + [DistractorKind.CLOTH] * parameters.cloths
    kinds += [DistractorKind.STUMP] * parameters.stumps + [DistractorKind.WATER] * parameters.waters
    taken_enu_m = [person.position_enu_m[:2] for person in persons]
    distractors = []
    for kind in kinds:
        others = np.array(taken_enu_m).reshape(-1, 2)
        obstacles = [(forest.trunk_enu_m, _TRUNK_CLEARANCE_M), (others, _DISTRACTOR_CLEARANCE_M)]
        place = _place(rng, _window(parameters.side_m), obstacles)
        taken_enu_m.append(place)
        distractors.append(make_distractor(rng, kind, np.array([*place, 0.0])))
    return tuple(distractors)


def _window(side_m: float) -> NDArray[np.float64]:
    """South-western and north-eastern corner of the part of the forest where bodies are placed, shape (2, 2)."""
    return np.array([[-0.2 * side_m, FOREST_SOUTH_M + 0.27 * side_m], [0.2 * side_m, FOREST_SOUTH_M + 0.57 * side_m]])


def _place(
    rng: np.random.Generator,
    window_enu_m: NDArray[np.float64],
    obstacles: Sequence[tuple[NDArray[np.float64], float]],
) -> NDArray[np.float64]:
    """Return a place in a window, shape (2,): the first of many candidates that keeps clear of all obstacles.

    ``obstacles`` are points, shape (n, 2), with the distance to keep from them; where there is no such place, the one
    that comes nearest to it.
    """
    candidates = rng.uniform(window_enu_m[0], window_enu_m[1], (_PLACE_CANDIDATES, 2))
    room = np.ones(_PLACE_CANDIDATES)
    for points_enu_m, clearance_m in obstacles:
        if len(points_enu_m):
            distance_m = np.linalg.norm(candidates[:, None] - points_enu_m[None], axis=2).min(axis=1)
            room = np.minimum(room, distance_m / clearance_m)
    return np.asarray(candidates[int(np.argmax(room))])


def _rectangle(west: float, south: float, east: float, north: float) -> NDArray[np.float64]:
    return np.array([[west, south], [east, south], [east, north], [west, north]])
