"""The geotag of a photograph: position, attitude and focal length, whatever names its manufacturer uses."""

from __future__ import annotations

import math
import struct
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.heights import AboveHomeM, AmslM
from aos_gcs.geotags.attitude import R_cam2enu_of_tags
from aos_gcs.geotags.dewarp import factory_camera
from aos_gcs.geotags.exif import ExifTags, exif_tags
from aos_gcs.geotags.sensors import Sensor, sensor_of
from aos_gcs.geotags.xmp import first_number, parse_xmp

_BROKEN = (OSError, ValueError, SyntaxError, KeyError, IndexError, TypeError, ArithmeticError, struct.error)
"""Errors that Pillow raises for damaged files, SyntaxError among them."""

_WIDTH, _HEIGHT = 0x0100, 0x0101
"""Tags of TIFF files with the size of the pixels as they are stored."""
_R_FILE2SHOWN = {
    1: np.eye(3),
    3: np.diag([-1.0, -1.0, 1.0]),
    6: np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    8: np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
}
"""Axes of the rows and columns in the file to those of the picture as it is to be shown, by EXIF's ``Orientation``; the
other values are mirrored."""

_LATITUDE = ("GpsLatitude", "GPSLatitude", "Latitude")
_LONGITUDE = ("GpsLongitude", "GPSLongitude", "GpsLongtitude", "GPSLongtitude", "Longitude")
"""``Longtitude`` is what the firmware of some aircraft says."""

MAX_ALTITUDE_M = 20_000.0
_MAX_SIGMA_M = 1000.0
"""Standard deviation from which a receiver does not know where it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Geotag:
    """Position, attitude, time and camera of a photograph."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: AmslM | None
    """Altitude as recorded by the aircraft: errors of tens of metres are usual; some are above the ellipsoid."""
    relative_altitude_m: AboveHomeM | None
    """Height above the place of takeoff."""
    R_cam2enu: NDArray[np.float64]
    """Orientation of the rows and columns as they stand in the file, shape (3, 3)."""
    width_px: int
    height_px: int
    focal_px: float | None
    """None where it is not told, which does not concern the factory's calibration."""
    utc_s: float | None
    """Time of exposure since the Unix epoch; None where it, or its time zone, is not recorded."""
    sensor: Sensor | None = None
    """The aircraft's camera; None where it is not told."""
    position_sigma_m: tuple[float, float, float] | None = None
    """Standard deviations along east, north and up, from an RTK receiver; None where they are not told."""
    has_rtk_fix: bool | None = None
    """Whether the RTK receiver had its fixed solution; None without such a receiver."""
    is_turned: bool = False
    """Whether the picture is to be shown turned: the attitude in its tags is that of the turned one."""
    model: str | None = None
    """Name of the camera's model; None where it is not told."""
    software: str | None = None
    """Program that has written the file last, or the camera's firmware; None where it is not told."""
    factory: CameraModel | None = None
    """Camera as its factory has calibrated it; None where that is not told, or the picture is corrected by it."""
    yaw_beside_aircraft_rad: float | None = None
    """Yaw of the gimbal less that of the aircraft, [-pi, pi]; None where one is not told."""

    def camera(self, horizontal_fov_rad: float | None = None) -> CameraModel:
        """Return the camera, calibrated where that is told; a field of view replaces what the metadata tell.

        Raises:
            InputDataError: if neither is known.
        """
        if horizontal_fov_rad is None:
            if self.factory is not None:
                return self.factory
            if self.focal_px is None:
                raise InputDataError(
                    "it has no CalibratedFocalLength of its own, FocalLengthIn35mmFilm or CameraHorizontalFOV, nor "
                    "FocalLength with FocalPlaneXResolution"
                )
            horizontal_fov_rad = 2.0 * math.atan(self.width_px / 2.0 / self.focal_px)
        return CameraModel.from_fov(self.width_px, self.height_px, horizontal_fov_rad)


def read_geotag(source: Path | BinaryIO) -> Geotag:
    """Read the geotag of a photograph, a file or its bytes, without decoding its pixels.

    Raises:
        InputDataError: with the reason alone, so that it can stand behind the file's name.
        ConfigurationError: if pillow or defusedxml is not installed.
    """
    pil: Any = load_extra("PIL.Image", "geo", "Reading the position of a photograph")
    try:
        with warnings.catch_warnings(action="ignore"), pil.open(source) as image:
            width_px, height_px = _stored_size(image)
            exif = exif_tags(image.getexif(), width_px)
            packet = image.info.get("xmp", b"")
    except (*_BROKEN, pil.DecompressionBombError) as error:
        raise InputDataError("it is not a readable image") from error
    xmp = parse_xmp(packet) if packet else {}
    tag = geotag(exif, xmp, width_px, height_px)
    return replace(tag, sensor=sensor_of(xmp, source.name if isinstance(source, Path) else ""))


def _stored_size(image: Any) -> tuple[int, int]:
    """Return width and height of the pixels as they are stored: Pillow tells those of a TIFF as it is to be shown."""
    tags = image.getexif() if image.format == "TIFF" else {}
    width_px, height_px = image.size
    return int(tags.get(_WIDTH, width_px)), int(tags.get(_HEIGHT, height_px))


def geotag(exif: ExifTags, xmp: Mapping[str, str], width_px: int, height_px: int) -> Geotag:
    """Combine EXIF and XMP; values of XMP have more digits and come first.

    Raises:
        InputDataError: naming the tag that is missing, or of no use.
    """
    latitude_deg, longitude_deg = first_number(xmp, *_LATITUDE), first_number(xmp, *_LONGITUDE)
    if latitude_deg is None or longitude_deg is None:
        latitude_deg, longitude_deg = exif.latitude_deg, exif.longitude_deg
    if latitude_deg is None or longitude_deg is None:
        raise InputDataError("it has no GPSLatitude and GPSLongitude")
    if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0) or (latitude_deg == longitude_deg == 0.0):
        raise InputDataError(f"its position, {latitude_deg:g}, {longitude_deg:g}, is not on the earth: it had no fix")
    if exif.orientation not in _R_FILE2SHOWN:
        raise InputDataError(f"its Orientation tag, {exif.orientation}, says that it is mirrored")
    altitude_m, relative_m = first_number(xmp, "AbsoluteAltitude"), first_number(xmp, "RelativeAltitude")
    for name in ("AbsoluteAltitude", "RelativeAltitude"):
        value_m = first_number(xmp, name)
        if value_m is not None and abs(value_m) > MAX_ALTITUDE_M:
            raise InputDataError(f"its {name}, {value_m:g} m, is not a plausible altitude of an aircraft")
    return Geotag(
        latitude_deg=latitude_deg,
        longitude_deg=longitude_deg,
        altitude_amsl_m=exif.altitude_amsl_m if altitude_m is None else AmslM(altitude_m),
        relative_altitude_m=None if relative_m is None else AboveHomeM(relative_m),
        R_cam2enu=R_cam2enu_of_tags(xmp) @ _R_FILE2SHOWN[exif.orientation],
        width_px=width_px,
        height_px=height_px,
        focal_px=_focal_px(exif, xmp, width_px, height_px),
        utc_s=_utc_s(xmp) or exif.utc_s,
        position_sigma_m=_position_sigma_m(xmp),
        has_rtk_fix=_has_rtk_fix(xmp),
        is_turned=exif.orientation != 1,
        model=exif.model,
        software=exif.software,
        factory=_factory(exif, xmp, width_px, height_px),
        yaw_beside_aircraft_rad=_yaw_beside_aircraft_rad(xmp),
    )


def _position_sigma_m(xmp: Mapping[str, str]) -> tuple[float, float, float] | None:
    east_m, north_m, up_m = (first_number(xmp, name) for name in ("RtkStdLon", "RtkStdLat", "RtkStdHgt"))
    if east_m is None or north_m is None or up_m is None or min(east_m, north_m, up_m) <= 0.0:
        return None
    if max(east_m, north_m, up_m) > _MAX_SIGMA_M:
        return None
    return east_m, north_m, up_m


def _yaw_beside_aircraft_rad(xmp: Mapping[str, str]) -> float | None:
    gimbal_deg, aircraft_deg = (first_number(xmp, name) for name in ("GimbalYawDegree", "FlightYawDegree"))
    if gimbal_deg is None or aircraft_deg is None:
        return None
    return math.remainder(math.radians(gimbal_deg - aircraft_deg), 2.0 * math.pi)


def _has_rtk_fix(xmp: Mapping[str, str]) -> bool | None:
    flag = first_number(xmp, "RtkFlag")
    # DJI: 0 no solution, 16 single, 34 float, 50 fixed; without a receiver the tag is missing.
    return None if flag is None else flag == 50.0


def _factory(exif: ExifTags, xmp: Mapping[str, str], width_px: int, height_px: int) -> CameraModel | None:
    is_as_taken = exif.original_width_px == width_px and exif.digital_zoom == 1.0
    is_its_own = is_as_taken and _is_of_this_picture(exif, xmp)
    return factory_camera(xmp, width_px, height_px) if is_its_own else None


def _utc_s(xmp: Mapping[str, str]) -> float | None:
    """Return the time of exposure that some cameras tell to the microsecond, since the Unix epoch."""
    try:
        return datetime.strptime(f"{xmp['UTCAtExposure']} +0000", "%Y:%m:%d %H:%M:%S.%f %z").timestamp()
    except (KeyError, ValueError):
        return None


def _focal_px(exif: ExifTags, xmp: Mapping[str, str], width_px: int, height_px: int) -> float | None:
    calibrated_px = first_number(xmp, "CalibratedFocalLength", "CalibratedFocalLength/X")
    if calibrated_px is not None and calibrated_px > 0.0 and _is_of_this_picture(exif, xmp):
        return calibrated_px * exif.digital_zoom * width_px / exif.original_width_px
    if exif.focal_per_width is not None:
        return exif.focal_per_width * width_px
    fov_deg = first_number(xmp, "CameraHorizontalFOV")
    if fov_deg is not None and 0.0 < fov_deg < 180.0:
        return width_px / 2.0 / math.tan(math.radians(fov_deg) / 2.0)
    # Last, because cameras round it to whole millimetres.
    return None if exif.focal_per_diagonal is None else exif.focal_per_diagonal * math.hypot(width_px, height_px)


def _is_of_this_picture(exif: ExifTags, xmp: Mapping[str, str]) -> bool:
    """Return whether the centre that belongs to a calibrated focal length is about that of the picture.

    The thermal camera of DJI's M3T tells a focal length in micrometres and 0 for its centre, that of Skydio's X2 the
    calibration of the colour camera beside it, and a picture that was reduced, and has lost its EXIF, that of before.
    """
    centre_px = first_number(xmp, "CalibratedOpticalCenterX", "CalibratedOpticalCenter/X")
    return centre_px is None or 0.25 < centre_px / exif.original_width_px < 0.75
