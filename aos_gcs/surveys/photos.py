"""Recordings of photographs with positions in their metadata."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.distortion import LensDistortion
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import Pose
from aos_gcs.geotags.photo import Geotag, read_geotag
from aos_gcs.surveys.images import BANDS_OF_CHANNELS, check_image, read_image
from aos_gcs.surveys.model import Survey, SurveyImage

SUFFIXES = frozenset({".jpg", ".jpeg"})


@dataclass(frozen=True, slots=True, eq=False)
class _Photo:
    path: Path
    tag: Geotag
    camera: CameraModel
    height_m: float
    """Height above the ground."""
    ground_amsl_m: float
    """Altitude of the ground in the altitude reference of this photograph."""


def read_photos(
    folder: Path,
    *,
    ground_amsl_m: float | None = None,
    horizontal_fov_rad: float | None = None,
    lens: LensDistortion | None = None,
) -> Survey:
    """Read the geotags of all JPEG files of a folder.

    The world is east-north-up about the first photograph's place, with z = 0 on the ground.

    Args:
        folder: folder of the photographs, read in the order of their names.
        ground_amsl_m: altitude of the ground, to be compared with the photographs' absolute altitudes. None: the ground
            is where the flight began, and the photographs' relative altitudes are heights above it.
        horizontal_fov_rad: replaces the focal lengths in the photographs' metadata.
        lens: lens of all photographs.

    Raises:
        InputDataError: if there is no photograph, or none can be used; the text names the reason.
        ConfigurationError: if pillow or defusedxml is not installed.
    """
    if not folder.is_dir():
        raise InputDataError(f"The image folder {folder} does not exist; check the path.")
    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    if not paths:
        raise InputDataError(
            f"The folder {folder} has no JPEG photographs (.jpg, .jpeg); for other images give their --poses."
        )
    photos: list[_Photo] = []
    left_out: dict[str, str] = {}
    bands: tuple[str, ...] | None = None
    for path in paths:
        try:
            photo = _read(path, ground_amsl_m, horizontal_fov_rad, lens)
            bands = bands or BANDS_OF_CHANNELS[read_image(path).shape[2]]
        except InputDataError as error:
            left_out[path.name] = str(error)
            continue
        photos.append(photo)
    if bands is None:
        name, reason = next(iter(left_out.items()))
        raise InputDataError(f"None of the {len(paths)} photographs in {folder} can be used; {name}: {reason}")
    origin = GeodeticPosition(
        photos[0].tag.latitude_deg,
        photos[0].tag.longitude_deg,
        float(np.median([photo.ground_amsl_m for photo in photos])),
    )
    return Survey(tuple(_placed(photo, LocalFrame(origin)) for photo in photos), bands, origin, left_out)


def _read(
    path: Path, ground_amsl_m: float | None, horizontal_fov_rad: float | None, lens: LensDistortion | None
) -> _Photo:
    check_image(path)
    tag = read_geotag(path)
    camera = replace(tag.camera(horizontal_fov_rad), distortion=lens)
    if ground_amsl_m is not None:
        if tag.altitude_amsl_m is None:
            raise InputDataError("it has neither AbsoluteAltitude nor GPSAltitude")
        return _Photo(path, tag, camera, tag.altitude_amsl_m - ground_amsl_m, ground_amsl_m)
    if tag.relative_altitude_m is None:
        raise InputDataError("it has no RelativeAltitude; give the altitude of the ground (--ground)")
    # Without an absolute altitude only the map's scale suffers, by a millionth per six metres.
    takeoff_amsl_m = 0.0 if tag.altitude_amsl_m is None else tag.altitude_amsl_m - tag.relative_altitude_m
    return _Photo(path, tag, camera, tag.relative_altitude_m, takeoff_amsl_m)


def _placed(photo: _Photo, world: LocalFrame) -> SurveyImage:
    altitude_m = world.origin.altitude_amsl_m + photo.height_m
    position = GeodeticPosition(photo.tag.latitude_deg, photo.tag.longitude_deg, altitude_m)
    return SurveyImage(photo.path, Pose(world.to_enu(position), photo.tag.R_cam2enu), photo.camera)
