"""Photographs with geotags, written as JPEG: EXIF, and the XMP that most programs know best, DJI's.

Make and model tell the truth; only the names of the tags are DJI's. :mod:`aos_gcs.geotags.photo` reads them back.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import R_CAM2SENSOR_FRD, R_NED2ENU
from aos_gcs.geometry.rotations import yaw_pitch_roll_from_R
from aos_gcs.geotags.exif import EXIF_IFD, FULL_FRAME_DIAGONAL_MM, GPS_IFD

MAKE: Final = "aos-gcs"
QUALITY: Final = 92
_SENSOR_MM: Final = 36.0
"""Width of the sensor for which focal lengths in millimetres are written: cameras tell theirs in pixels alone."""
_DRONE_NAMESPACE: Final = "http://www.dji.com/drone-dji/1.0/"
_MICRODEGREES: Final = 10_000_000
"""Parts of a second of arc, 3 micrometres on the ground."""
_COMPONENTS_TYPE: Final = (b"\x91\x01\x00\x01\x00\x00\x00\x04", b"\x91\x01\x00\x07\x00\x00\x00\x04")
"""The entry of ComponentsConfiguration: pillow writes its four values as bytes, EXIF asks for the type *undefined*."""
_SRGB, _CENTRED, _BY_CENTIMETRE, _BY_INCH, _TRUE_NORTH = 1, 1, 3, 2, "T"


@dataclass(frozen=True, slots=True, eq=False)
class PhotoTag:
    """Place, attitude, time and camera of a picture."""

    position: GeodeticPosition
    """Projection centre."""
    height_above_ground_m: float
    R_cam2enu: NDArray[np.float64]
    """Orientation, shape (3, 3)."""
    focal_px: float
    model: str
    """Kind of the picture, in ASCII."""
    utc_s: float
    """Time of exposure since the Unix epoch."""
    position_sigma_m: float | None = None
    """Standard deviation of the horizontal position; None where it is not known."""


def tagged_jpeg(rgb: NDArray[np.uint8], tag: PhotoTag) -> bytes:
    """Return a picture, shape (rows, columns, 3), as a JPEG file with its geotag.

    Raises:
        ConfigurationError: pillow is not installed.
    """
    pil: Any = load_extra("PIL.Image", "geo", "Writing photographs")
    rows, columns = rgb.shape[:2]
    file = io.BytesIO()
    exif = _exif(pil.Exif(), tag, columns, rows).tobytes().replace(*_COMPONENTS_TYPE)
    pil.fromarray(rgb).save(file, "JPEG", quality=QUALITY, dpi=(72, 72), exif=exif, xmp=_xmp(tag))
    return file.getvalue()


def _exif(exif: Any, tag: PhotoTag, width_px: int, height_px: int) -> Any:
    rational: Any = load_extra("PIL.TiffImagePlugin", "geo", "Writing photographs").IFDRational
    moment = datetime.fromtimestamp(round(tag.utc_s, 3), UTC)
    stamp, fraction = f"{moment:%Y:%m:%d %H:%M:%S}", f"{moment.microsecond // 1000:03d}"
    focal_mm = _SENSOR_MM * tag.focal_px / width_px
    equivalent_mm = FULL_FRAME_DIAGONAL_MM * tag.focal_px / math.hypot(width_px, height_px)
    main: Mapping[int, object] = {
        0x010F: MAKE,
        0x0110: tag.model,
        0x0112: 1,
        0x011A: rational(72, 1),
        0x011B: rational(72, 1),
        0x0128: _BY_INCH,
        0x0131: MAKE,
        0x0132: stamp,
        0x0213: _CENTRED,
    }
    camera: Mapping[int, object] = {
        0x9000: b"0232",
        0x9003: stamp,
        0x9004: stamp,
        0x9010: "+00:00",
        0x9011: "+00:00",
        0x9012: "+00:00",
        0x9101: b"\x01\x02\x03\x00",
        0x9291: fraction,
        0x920A: rational(round(1000.0 * focal_mm), 1000),
        0xA000: b"0100",
        0xA001: _SRGB,
        0xA002: width_px,
        0xA003: height_px,
        0xA20E: rational(round(10_000_000.0 * width_px / _SENSOR_MM), 1_000_000),
        0xA20F: rational(round(10_000_000.0 * width_px / _SENSOR_MM), 1_000_000),
        0xA210: _BY_CENTIMETRE,
        0xA405: min(65_535, max(1, round(equivalent_mm))),
    }
    for table, values in ((exif, main), (exif.get_ifd(EXIF_IFD), camera), (exif.get_ifd(GPS_IFD), _gps(tag, rational))):
        for name, value in values.items():
            table[name] = value
    return exif


def _gps(tag: PhotoTag, rational: Any) -> dict[int, object]:
    place, moment = tag.position, datetime.fromtimestamp(tag.utc_s, UTC)
    yaw_deg = _angles_deg(tag.R_cam2enu)[0] % 360.0
    values: dict[int, object] = {
        0: b"\x02\x03\x00\x00",
        1: "NS"[place.latitude_deg < 0.0],
        2: _sexagesimal(abs(place.latitude_deg), rational),
        3: "EW"[place.longitude_deg < 0.0],
        4: _sexagesimal(abs(place.longitude_deg), rational),
        5: b"\x01" if place.altitude_amsl_m < 0.0 else b"\x00",
        6: rational(round(1000.0 * abs(place.altitude_amsl_m)), 1000),
        7: tuple(rational(part, 1) for part in (moment.hour, moment.minute, moment.second)),
        16: _TRUE_NORTH,
        17: rational(round(100.0 * yaw_deg) % 36_000, 100),
        18: "WGS-84",
        29: f"{moment:%Y:%m:%d}",
    }
    if tag.position_sigma_m is not None and math.isfinite(tag.position_sigma_m):
        values[31] = rational(round(1000.0 * tag.position_sigma_m), 1000)
    return values


def _sexagesimal(angle_deg: float, rational: Any) -> tuple[Any, Any, Any]:
    seconds, parts = divmod(round(angle_deg * 3600 * _MICRODEGREES), _MICRODEGREES)
    minutes, seconds = divmod(seconds, 60)
    degrees, minutes = divmod(minutes, 60)
    return rational(degrees, 1), rational(minutes, 1), rational(seconds * _MICRODEGREES + parts, _MICRODEGREES)


def _angles_deg(R_cam2enu: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return yaw, pitch and roll of the optical axis about north, east and down."""
    yaw, pitch, roll = yaw_pitch_roll_from_R(R_NED2ENU @ R_cam2enu @ R_CAM2SENSOR_FRD.T)
    return math.degrees(yaw), math.degrees(pitch), math.degrees(roll)


def _xmp(tag: PhotoTag) -> bytes:
    yaw_deg, pitch_deg, roll_deg = _angles_deg(tag.R_cam2enu)
    values = {
        "GpsLatitude": f"{tag.position.latitude_deg:+.9f}",
        "GpsLongitude": f"{tag.position.longitude_deg:+.9f}",
        "AbsoluteAltitude": f"{tag.position.altitude_amsl_m:+.3f}",
        "RelativeAltitude": f"{tag.height_above_ground_m:+.3f}",
        "GimbalYawDegree": f"{yaw_deg:+.4f}",
        "GimbalPitchDegree": f"{pitch_deg:+.4f}",
        "GimbalRollDegree": f"{roll_deg:+.4f}",
        "FlightYawDegree": f"{yaw_deg:+.4f}",
        "CalibratedFocalLength": f"{tag.focal_px:.4f}",
    }
    attributes = " ".join(f"drone-dji:{name}={quoteattr(value)}" for name, value in values.items())
    return (
        '<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>'
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        f'<rdf:Description rdf:about="" xmlns:drone-dji="{_DRONE_NAMESPACE}" {attributes}/>'
        '</rdf:RDF></x:xmpmeta><?xpacket end="w"?>'
    ).encode()
