"""Geotagged photographs as frames: they bring their own poses."""

from __future__ import annotations

import io
from dataclasses import dataclass

from aos_drivers.frames.errors import FrameRefusedError
from aos_drivers.frames.files.images import Image, decode_image
from aos_gcs.errors import CaptureError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import amsl_above_home_m
from aos_gcs.geotags.photo import Geotag, read_geotag


@dataclass(frozen=True, slots=True, eq=False)
class Photograph:
    """One decoded photograph with its geotag."""

    image: Image
    bands: tuple[str, ...]
    tag: Geotag


def read_photograph(data: bytes, max_pixels: int) -> Photograph:
    """Return the content of a file.

    Raises:
        TornFrameError: its end is missing.
        CaptureError: it is no image of at most ``max_pixels``, or has no complete geotag.
    """
    image, bands = decode_image(data, max_pixels)
    try:
        return Photograph(image, bands, read_geotag(io.BytesIO(data)))
    except InputDataError as error:
        raise CaptureError(f"its tags cannot be used: {error}") from error


def position_of(tag: Geotag, home: GeodeticPosition | None) -> GeodeticPosition:
    """Return the position of a photograph.

    Heights above the place of takeoff come first: altitudes in tags are often tens of metres off, or above the
    ellipsoid.

    Raises:
        CaptureError: it has no altitude, or only the one above takeoff while home is unknown.
    """
    if home is not None and tag.relative_altitude_m is not None:
        altitude_amsl_m = amsl_above_home_m(home.altitude_amsl_m, tag.relative_altitude_m)
    elif tag.altitude_amsl_m is not None:
        altitude_amsl_m = tag.altitude_amsl_m
    else:
        raise CaptureError("its tags contain no altitude (RelativeAltitude, AbsoluteAltitude or GPSAltitude)")
    return GeodeticPosition(tag.latitude_deg, tag.longitude_deg, altitude_amsl_m)


def check_moment(tag: Geotag, asked_at_utc_s: float, tolerance_s: float) -> None:
    """Refuse a photograph that was taken before it was requested, however late its file appears.

    Raises:
        FrameRefusedError: it is older. One without a time of day is accepted.
    """
    if tag.utc_s is None:
        return
    early_s = asked_at_utc_s - tag.utc_s
    if early_s > tolerance_s:
        raise FrameRefusedError(
            f"it was taken {early_s:.1f} s before it was requested, by its own time; the limit is {tolerance_s:g} s "
            "(match_tolerance_s)"
        )
