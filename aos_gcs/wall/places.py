"""Place that the middle of a picture shows."""

from __future__ import annotations

from typing import Final

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.model.steps import Picture
from aos_gcs.wall.model import FrameFacts, ViewedPlace

_LEAST_DESCENT: Final = 0.2
"""Smallest downward part of the axis of a camera that is followed to the ground: flatter ones end anywhere."""


def viewed_place(frame: FrameFacts, ground_amsl_m: float | None) -> ViewedPlace:
    """Return where the camera's axis meets level ground; the camera's own place where it does not, or none is known."""
    east, north, up = frame.axis_enu
    height_m = 0.0 if ground_amsl_m is None else frame.altitude_amsl_m - ground_amsl_m
    if -up < _LEAST_DESCENT or height_m <= 0.0:
        return ViewedPlace(frame.latitude_deg, frame.longitude_deg, is_camera=True)
    camera = GeodeticPosition(frame.latitude_deg, frame.longitude_deg, frame.altitude_amsl_m)
    reach = height_m / -up
    place = LocalFrame(camera).to_geodetic((reach * east, reach * north, reach * up))
    return ViewedPlace(place.latitude_deg, place.longitude_deg)


def raster_place(picture: Picture, origin: GeodeticPosition | None) -> ViewedPlace | None:
    """Return the middle of a raster; None while the mission's origin is unknown."""
    if origin is None:
        return None
    middle_enu_m = (picture.west_m + picture.east_m) / 2.0, (picture.south_m + picture.north_m) / 2.0, 0.0
    place = LocalFrame(origin).to_geodetic(middle_enu_m)
    return ViewedPlace(place.latitude_deg, place.longitude_deg)
