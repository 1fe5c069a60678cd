"""Recorded flights with the places of their persons."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.surfaces.dem_files import read_dem
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.input_values import finite_number, shown
from aos_gcs.surveys.model import Survey, SurveyImage
from aos_gcs.surveys.poses_file import read_poses

POSES_FILE, PERSONS_FILE, IMAGE_FOLDER = "poses.json", "persons.json", "images"
TERRAIN_ENDINGS = (".obj", ".obj.gz", ".tif", ".tiff")
_COORDINATES = ("x_m", "y_m", "z_m")


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A flight, the ground below it and the persons there, in the world of its poses."""

    name: str
    survey: Survey
    surface: FocalSurface
    persons_m: NDArray[np.float64]
    """Places of all persons, shape (n, 3)."""
    to_enu: NDArray[np.float64]
    """Rotation from the world of the poses to x east, y north, z up, shape (3, 3)."""

    def pose_enu(self, pose: Pose) -> Pose:
        """Return a pose in the east-north-up world about the same origin."""
        return Pose(self.to_enu @ pose.position_enu_m, self.to_enu @ pose.R_cam2enu)


@dataclass(frozen=True, slots=True)
class FocalSurfaceOptions:
    """Focal surface as the command's user gives it."""

    dem: Path | None = None
    """Terrain; None: the one that lies in the recording's folder."""
    offset_m: float = 0.0
    """Shift of the terrain along z."""
    plane_z_m: float | None = None
    """A plane instead of terrain."""

    def surface(self, folder: Path) -> FocalSurface:
        """Return the surface of a recording.

        Raises:
            InputDataError: if the folder does not hold exactly one terrain where it has to.
        """
        if self.plane_z_m is not None:
            return Plane(self.plane_z_m)
        return read_dem(self.dem or _terrain_in(folder)).moved(self.offset_m)


def open_recording(folder: Path, fov_rad: float | None, ground: FocalSurfaceOptions) -> Recording:
    """Open a folder with ``images``, ``poses.json``, ``persons.json`` and, unless given otherwise, a terrain.

    Args:
        folder: the folder.
        fov_rad: full horizontal field of view; None where the poses file tells the camera.
        ground: focal surface.

    Raises:
        InputDataError: if a part of it is missing, or not of this recording; the text names the field.
    """
    persons_m = read_persons(folder / PERSONS_FILE)
    survey = read_poses(folder / POSES_FILE, folder / IMAGE_FOLDER, fov_rad)
    if len(survey.bands) != 1:
        raise InputDataError(
            f"The images of {folder} have the bands {', '.join(survey.bands)}: a thermal recording has one."
        )
    looks_down = float(np.median([image.pose.R_cam2enu[2, 2] for image in survey.images])) < 0.0
    to_enu = np.eye(3) if looks_down else np.diag([1.0, -1.0, -1.0])
    for index, place_m in enumerate(persons_m):
        if not any(holds(image, place_m) for image in survey.images):
            raise InputDataError(
                f"{folder / PERSONS_FILE}, persons[{index}] is in no image of {folder}: is the file of another "
                "recording, or in another frame of reference?"
            )
    return Recording(folder.name, survey, ground.surface(folder), persons_m, to_enu)


def holds(image: SurveyImage, place_m: NDArray[np.float64]) -> bool:
    """Tell whether a place, shape (3,), lies within an image."""
    u, v = project_points(place_m[None], image.camera, image.pose)[0]
    return bool(-0.5 <= u <= image.camera.width_px - 0.5 and -0.5 <= v <= image.camera.height_px - 0.5)


def read_persons(path: Path) -> NDArray[np.float64]:
    """Return the places in ``{"persons": [{"x_m": ..., "y_m": ..., "z_m": ...}, ...]}``, shape (n, 3).

    They are in the world of the poses. An empty list says that nobody is there.

    Raises:
        InputDataError: naming the file, the field, and what is wrong with it.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputDataError(f"The file of persons {path} cannot be read: {error.strerror}.") from error
    except (ValueError, RecursionError) as error:
        raise InputDataError(f"The file of persons {path} is not valid JSON: {error}.") from error
    persons = document.get("persons") if isinstance(document, dict) else None
    if not isinstance(persons, list):
        raise InputDataError(f"The file of persons {path} needs a list 'persons'; an empty one if nobody is there.")
    places = [_place(person, f"{path}, persons[{index}]") for index, person in enumerate(persons)]
    return np.array(places, dtype=np.float64).reshape(-1, 3)


def _place(person: object, name: str) -> list[float]:
    if not isinstance(person, dict):
        raise InputDataError(f"{name} must be an object with {', '.join(_COORDINATES)}.")
    return [_coordinate(person.get(key), f"{name}: '{key}'") for key in _COORDINATES]


def _coordinate(value: Any, name: str) -> float:
    number = finite_number(value)
    if number is None:
        raise InputDataError(f"{name} must be a finite number of metres, got {shown(value)}.")
    return number


def _terrain_in(folder: Path) -> Path:
    found = [path for path in sorted(folder.iterdir()) if path.name.lower().endswith(TERRAIN_ENDINGS)]
    if len(found) != 1:
        there = ", ".join(path.name for path in found) or "none"
        raise InputDataError(
            f"{folder} needs one terrain ({', '.join(TERRAIN_ENDINGS)}), but has {there}: name it with --dem, or "
            "give a plane with --plane-z."
        )
    return found[0]
