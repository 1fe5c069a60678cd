"""Images of a scene from any pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_sim.errors.model import NONE
from aos_sim.errors.sensor import CameraSensor, RenderedFrame
from aos_sim.errors.wind import Wind
from aos_sim.render.ground_rays import HORIZON, GroundRays
from aos_sim.render.lighting import light_ground, shade_mesh
from aos_sim.render.raycaster import NO_HIT, RayCaster
from aos_sim.render.rays import image_rays, pixel_rays, pixels_around, ray_directions
from aos_sim.render.sway import Sway
from aos_sim.world.conditions import CLIMATES
from aos_sim.world.distractors import distractor_mesh
from aos_sim.world.mesh import FloatArray, concatenate
from aos_sim.world.person import Person, person_mesh
from aos_sim.world.scene import Scene

SKY_RGB = (186, 204, 222)
SKY_TEMPERATURE_CELSIUS = -10.0

_WHITE_NOISE = CameraSensor(NONE.thermal, NONE.optics)
_STANDS_M = 0.05
"""A body is hidden by ground that lies more than this before it: its feet touch it."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonMasks:
    """Masks of a person as a camera sees it, and as it would without the forest; each of shape (H, W)."""

    visible: NDArray[np.bool_]
    unoccluded: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _BodyHits:
    """The rays that meet a body, whether or not a tree stands before it."""

    pixel: NDArray[np.intp]
    triangle: NDArray[np.int32]
    is_visible: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _Rays:
    """A view of one moment."""

    pose: Pose
    camera: CameraModel
    at_s: float = 0.0


class LitForest:
    """Trees and ground in their light: the part of a world that never changes."""

    def __init__(self, scene: Scene) -> None:
        mesh = scene.forest.mesh
        self.caster = RayCaster(mesh.triangles_enu_m)
        self.ground = light_ground(scene, self.caster)
        self.ground_rays = GroundRays(scene.relief)
        sky = np.array([[*SKY_RGB, SKY_TEMPERATURE_CELSIUS]], np.float32)
        # Sky comes last: the index of a miss, -1, picks it.
        climate = CLIMATES[scene.parameters.conditions]
        self.appearance = np.concatenate([shade_mesh(mesh, self.caster, climate), sky])


class _Bodies:
    """Persons and distractors, apart from the forest so that they can be seen without it."""

    def __init__(self, scene: Scene, forest: RayCaster) -> None:
        meshes = [scene.draped(person_mesh(person), person.position_enu_m) for person in scene.persons]
        meshes += [scene.draped(distractor_mesh(body), body.position_enu_m) for body in scene.distractors]
        mesh = concatenate(meshes)
        self.caster = RayCaster(mesh.triangles_enu_m)
        self.appearance = shade_mesh(mesh, forest, CLIMATES[scene.parameters.conditions])
        sizes = np.array([len(part) for part in meshes], dtype=np.intp)
        self.body_of_triangle = np.repeat(np.arange(len(meshes)), sizes)
        self.corners_enu_m = [_bounding_box(part.triangles_enu_m) for part in meshes]

    def pixels(self, pose: Pose, camera: CameraModel) -> NDArray[np.intp]:
        """Return the pixels that can show a body."""
        can_show = np.zeros(camera.width_px * camera.height_px, dtype=np.bool_)
        for corners_enu_m in self.corners_enu_m:
            can_show[pixels_around(corners_enu_m, pose, camera)] = True
        return np.flatnonzero(can_show)


class Renderer:
    """Renders one scene.

    Immutable after construction: any number of threads may call the methods at once, each with a generator of its own,
    and they run in parallel. Equal arguments (the generator's state included) give equal frames.

    Raises:
        ConfigurationError: if embreex, which comes with ``aos-gcs[sim]``, is not installed.
    """

    def __init__(self, scene: Scene, forest: LitForest | None = None, wind: Wind = NONE.wind) -> None:
        """Prepare a scene; ``forest`` saves seconds where another renderer has prepared the same trees."""
        self.scene = scene
        self._wind = wind
        self._sway = Sway(wind, scene.parameters.seed)
        self._forest = LitForest(scene) if forest is None else forest
        self._walks = any(person.walk is not None for person in scene.persons)
        self._bodies = _Bodies(scene, self._forest.caster)

    def _bodies_at(self, at_s: float) -> _Bodies:
        """Return the bodies where they are at a moment."""
        if not self._walks:
            return self._bodies
        return _Bodies(replace(self.scene, persons=self.scene.persons_at(at_s)), self._forest.caster)

    def with_persons(self, persons: Sequence[Person]) -> Renderer:
        """Return a renderer of the same forest and distractors with other persons, or none; takes milliseconds."""
        return Renderer(replace(self.scene, persons=tuple(persons)), self._forest, self._wind)

    def render(
        self, pose: Pose, camera: CameraModel, rng: np.random.Generator, backdrop_stride: int = 1
    ) -> RenderedFrame:
        """Expose one frame of a camera without errors but white noise.

        Args:
            pose: pose of the camera.
            camera: its model.
            rng: draws the sensors' noise.
            backdrop_stride: as of :meth:`view`.
        """
        return _WHITE_NOISE.expose(self.view(pose, camera, 0.0, backdrop_stride), rng)

    def view(self, pose: Pose, camera: CameraModel, at_s: float, backdrop_stride: int = 1) -> FloatArray:
        """Return red, green, blue (0 to 255) and °C of what there is to see, shape (H, W, 4).

        Args:
            pose: pose of the camera.
            camera: its model.
            at_s: moment, seconds since the world began, which decides how the trees sway and where persons walk.
            backdrop_stride: 2 renders only every second pixel of every second row where no body can be, which takes
                less than half of the time; the pixels between repeat them.
        """
        image = self._appearance(_Rays(pose, camera, at_s), backdrop_stride)
        return image.reshape(camera.height_px, camera.width_px, 4)

    def person_masks(self, pose: Pose, camera: CameraModel, name: str | None = None) -> PersonMasks:
        """Return the pixels of the person of that name, or of all persons.

        Raises:
            KeyError: if nobody has that name.
        """
        hits = self._body_hits(_Rays(pose, camera), self._bodies, self._bodies.pixels(pose, camera))
        wanted = np.zeros(len(self.scene.persons) + len(self.scene.distractors), dtype=np.bool_)
        wanted[: len(self.scene.persons)] = [name in (None, person.name) for person in self.scene.persons]
        if name is not None and not wanted.any():
            raise KeyError(f"no person is called {name!r}; there are {[person.name for person in self.scene.persons]}")
        is_wanted = wanted[self._bodies.body_of_triangle[hits.triangle]]
        masks = np.zeros((2, camera.height_px * camera.width_px), dtype=np.bool_)
        masks[0, hits.pixel[is_wanted & hits.is_visible]] = True
        masks[1, hits.pixel[is_wanted]] = True
        visible, unoccluded = masks.reshape(2, camera.height_px, camera.width_px)
        return PersonMasks(visible, unoccluded)

    def visible_body_pixels(self, pose: Pose, camera: CameraModel) -> NDArray[np.intp]:
        """Return how many pixels show each body: the persons, then the distractors, shape (bodies,)."""
        hits = self._body_hits(_Rays(pose, camera), self._bodies, self._bodies.pixels(pose, camera))
        bodies = self._bodies.body_of_triangle[hits.triangle[hits.is_visible]]
        return np.bincount(bodies, minlength=len(self.scene.persons) + len(self.scene.distractors))

    def _appearance(self, rays: _Rays, backdrop_stride: int) -> FloatArray:
        """Red, green, blue and °C per pixel, shape (H * W, 4)."""
        pose, camera, bodies = rays.pose, rays.camera, self._bodies_at(rays.at_s)
        near_bodies = bodies.pixels(pose, camera)
        if backdrop_stride == 1:
            image = self._backdrop(rays, ray_directions(pose, camera))
        else:
            thinned = image_rays(pose, camera, backdrop_stride)
            colours = self._backdrop(rays, thinned.reshape(-1, 3)).reshape(*thinned.shape[:2], 4)
            image = colours.repeat(backdrop_stride, axis=0).repeat(backdrop_stride, axis=1)
            image = image[: camera.height_px, : camera.width_px].reshape(-1, 4)
            image[near_bodies] = self._backdrop(rays, pixel_rays(near_bodies, pose, camera))
        hits = self._body_hits(rays, bodies, near_bodies)
        image[hits.pixel[hits.is_visible]] = bodies.appearance[hits.triangle[hits.is_visible]]
        return image

    def _backdrop(self, rays: _Rays, directions: FloatArray) -> FloatArray:
        """Red, green, blue and °C of trees, ground and sky per direction, shape (n, 4)."""
        caster, ground_rays, origin_m = self._forest.caster, self._forest.ground_rays, rays.pose.position_enu_m
        if ground_rays.relief is None:
            triangle = caster.first_hit(*self._swaying(rays, directions))
            ground = np.flatnonzero((triangle == NO_HIT) & (directions[:, 2] < HORIZON))
            distance = np.float32(-origin_m[2]) / directions[ground, 2]
        else:
            reach = ground_rays.reach(origin_m, directions)
            triangle, forest_distance = caster.first_hit_with_distance(*self._swaying(rays, directions, reach))
            ground = np.flatnonzero(np.isfinite(reach) & (reach <= forest_distance))
            distance = reach[ground]
        colours = self._forest.appearance[triangle]
        down, (east, north, _) = directions[ground], origin_m
        colours[ground] = self._forest.ground.sample(east + distance * down[:, 0], north + distance * down[:, 1])
        return colours

    def _body_hits(self, rays: _Rays, bodies: _Bodies, pixel: NDArray[np.intp]) -> _BodyHits:
        directions = pixel_rays(pixel, rays.pose, rays.camera)
        triangle, distance = bodies.caster.first_hit_with_distance(rays.pose.position_enu_m, directions)
        is_hit = triangle != NO_HIT
        pixel, triangle, distance, directions = pixel[is_hit], triangle[is_hit], distance[is_hit], directions[is_hit]
        if self.scene.relief is None:
            _, forest_distance = self._forest.caster.first_hit_with_distance(*self._swaying(rays, directions))
            return _BodyHits(pixel, triangle, distance < forest_distance)
        reach = self._forest.ground_rays.reach(rays.pose.position_enu_m, directions)
        _, forest_distance = self._forest.caster.first_hit_with_distance(*self._swaying(rays, directions, reach))
        return _BodyHits(pixel, triangle, distance < np.minimum(forest_distance, reach + np.float32(_STANDS_M)))

    def _swaying(
        self, rays: _Rays, directions: FloatArray, reach: FloatArray | None = None
    ) -> tuple[NDArray[np.floating], FloatArray]:
        """Return origins and directions that meet the forest at rest as these meet it at their moment.

        ``reach`` is how far they go to the ground, where it is not level.
        """
        origin_m = rays.pose.position_enu_m
        if not self._sway.moves:
            return origin_m, directions
        if reach is None:
            return self._sway.shear(origin_m, directions, rays.at_s)
        at_ground_m = np.where(np.isfinite(reach), origin_m[2] + reach * directions[:, 2], 0.0).astype(np.float32)
        return self._sway.shear(origin_m, directions, rays.at_s, at_ground_m)


def _bounding_box(triangles_m: FloatArray) -> NDArray[np.float64]:
    """Corners of the axis-parallel box round a mesh, shape (8, 3)."""
    low, high = triangles_m.min(axis=(0, 1)), triangles_m.max(axis=(0, 1))
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1)
    return np.asarray(corners.reshape(8, 3), dtype=np.float64)
