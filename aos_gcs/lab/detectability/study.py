"""What single frames mark of persons in simulated forests, by the direction of each view.

Every person is looked at from many directions: drawn at random over the image, or along the line of one vehicle. What
the detector marks in a frame is counted where the person is; errors of poses and cameras are those of the grade.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import plane_to_image
from aos_gcs.groundmap.detection import Posture
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.step.examination import examine
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.lab.walk import free_place
from aos_gcs.lab.worlds import Target, TargetViews, WorldParameters, build_world

BANDS: Final = ("red", "green", "blue", "thermal")
_SIDE_M = 80.0
"""Side of a forest: no view of a person in its middle looks beyond it."""
_PLACES_M = 10.0
"""Persons are at most so far from the middle, on both axes."""
_LOWEST_M, _HIGHEST_M = 35.0, 45.0
"""Heights of the cameras: those of the usual layers of ten vehicles."""
_FOV_RAD = math.radians(50.0)
_REACH = 0.42
"""Largest horizontal distance of a view per metre of height: inside the image by the size of a person."""
_LINE_STEPS = 0.4 / 40.0, 2.8 / 40.0
"""Range of the same for neighbours along the line of one vehicle, 0.4 m to 2.8 m."""
_TOLERANCE_M = 0.25
"""Marks so far beside the person's outline are his: poses and lenses err."""


@dataclass(frozen=True, slots=True)
class DetectabilitySettings:
    """Settings that all forests of a study have in common.

    Raises:
        ConfigurationError: a value is out of its range; the text names it.
    """

    places: int = 2
    """Places of persons in each forest; every other one is looked at along a line."""
    views: int = 12
    """Frames of each person."""
    version: str = ""
    """Version of the program: results of another one belong to another study."""

    def __post_init__(self) -> None:
        for name, high in (("places", 100), ("views", 100)):
            if not 2 <= getattr(self, name) <= high:
                raise ConfigurationError(f"{name} must lie within 2 and {high}, but is {getattr(self, name)}.")


@dataclass(frozen=True, slots=True, order=True)
class ForestKey:
    """One forest of the study."""

    trees_per_ha: float
    seed: int


@dataclass(frozen=True, slots=True)
class WatchedPerson:
    """A person, and what each of some frames has marked of him."""

    posture: Posture
    along_line: bool
    """Whether the views lie along a line, as those of one vehicle; else at random over the image."""
    tangents: tuple[tuple[float, float], ...]
    """Direction to each camera from the person's place: east and north per metre of height."""
    marked: tuple[tuple[int, ...], ...]
    """Cells of a raster around the person, 5 cm each, that the frame's anomalies take up where the person is."""
    seen_m2: tuple[float, ...]
    """Area of the person that no leaf hides, projected on the ground."""
    whole_m2: tuple[float, ...]
    """The same without the forest."""
    cell_m2: float
    """Area of a cell of ``marked``."""


@dataclass(frozen=True, slots=True)
class WatchedForest:
    """A forest, and the persons that were watched in it."""

    key: ForestKey
    persons: tuple[WatchedPerson, ...]


def watch_forest(settings: DetectabilitySettings, key: ForestKey) -> WatchedForest:
    """Watch persons of each posture at random places of a forest; equal arguments give equal results."""
    return WatchedForest(key, tuple(_persons(settings, key)))


def _persons(settings: DetectabilitySettings, key: ForestKey) -> Iterator[WatchedPerson]:
    rng = np.random.default_rng([key.seed, round(key.trees_per_ha), 7])
    world = build_world(WorldParameters(seed=key.seed, trees_per_ha=key.trees_per_ha, side_m=_SIDE_M))
    camera = CameraModel.from_fov(512, 512, _FOV_RAD)
    imaging = ImagingSettings()
    for number in range(settings.places):
        place_m = free_place(rng, world.area_enu_m.mean(axis=0), _PLACES_M, world.trunks_enu_m)
        tangents = _directions(rng, settings.views, along_line=number % 2 == 1)
        for posture in Posture:
            target = Target((float(place_m[0]), float(place_m[1])), float(rng.uniform(0.0, 2.0 * math.pi)), posture)
            poses = _poses(place_m, tangents, rng)
            shown = world.view_target(poses, camera, target)
            images = world.render(poses, camera, target, rng)
            marked = [
                marked_cells(Frame(1, image, BANDS, pose, camera), shown, view, imaging)
                for view, (image, pose) in enumerate(zip(images, poses, strict=True))
            ]
            cell_m2 = shown.resolution_m**2
            yield WatchedPerson(
                posture=posture,
                along_line=number % 2 == 1,
                tangents=tuple((float(east), float(north)) for east, north in tangents),
                marked=tuple(marked),
                seen_m2=tuple(float(one) * cell_m2 for one in shown.seen.sum(axis=(1, 2))),
                whole_m2=tuple(float(one) * cell_m2 for one in shown.unoccluded.sum(axis=(1, 2))),
                cell_m2=cell_m2,
            )


def _directions(rng: np.random.Generator, views: int, *, along_line: bool) -> NDArray[np.float64]:
    """Return directions to cameras, shape (views, 2)."""
    if not along_line:
        return rng.uniform(-_REACH, _REACH, (views, 2))
    step = rng.uniform(*_LINE_STEPS)
    along = (np.arange(views) - (views - 1) / 2.0) * step + rng.uniform(-0.5, 0.5) * step
    across = np.full(views, rng.uniform(-_REACH, _REACH))
    return np.column_stack((across, along) if rng.integers(2) else (along, across))


def _poses(place_m: NDArray[np.float64], tangents: NDArray[np.float64], rng: np.random.Generator) -> list[Pose]:
    heights_m = rng.uniform(_LOWEST_M, _HIGHEST_M, len(tangents))
    positions_m = np.column_stack((place_m + tangents * heights_m[:, np.newaxis], heights_m))
    return [nadir_pose(position_m) for position_m in positions_m]


def marked_cells(frame: Frame, shown: TargetViews, view: int, settings: ImagingSettings) -> tuple[int, ...]:
    """Return the cells of the person's raster that the frame marks, where the person would be without the forest."""
    reach = round(_TOLERANCE_M / shown.resolution_m)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    outline = cv2.dilate(shown.unoccluded[view].astype(np.uint8), kernel)
    rows, columns = np.nonzero(outline)
    x_m = shown.west_m + (columns + 0.5) * shown.resolution_m
    y_m = shown.north_m - (rows + 0.5) * shown.resolution_m
    u, v, w = plane_to_image(frame.camera, frame.pose, 0.0) @ np.stack((x_m, y_m, np.ones_like(x_m)))
    pixels = np.rint(np.stack((v / w, u / w))).astype(np.int64)
    within = (pixels >= 0).all(axis=0) & (pixels < np.array([[frame.camera.height_px], [frame.camera.width_px]])).all(
        axis=0
    )
    mask = examine(frame, settings).mask()
    hit = mask[pixels[0, within], pixels[1, within]] > 0
    return tuple(int(cell) for cell in (rows * outline.shape[1] + columns)[within][hit])


def forest_keys(densities: Sequence[float], forests: int, seed: int) -> tuple[ForestKey, ...]:
    """Return the forests of a study, so many of each density.

    Raises:
        ConfigurationError: there is none.
    """
    if forests < 1 or seed < 0:
        raise ConfigurationError(f"--forests must be at least 1 and --seed at least 0, but are {forests} and {seed}.")
    return tuple(ForestKey(density, seed + number) for number in range(forests) for density in densities)
