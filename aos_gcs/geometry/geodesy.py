"""Geodetic positions and the local east-north-up frame of a mission.

Written out for single points, which flights convert all the time: pymap3d, which the tests compare with, takes thirty
times as long for one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

EnuPoint = tuple[float, float, float]
"""East, north and up in metres."""

_EQUATORIAL_M = 6378137.0
_POLAR_M = _EQUATORIAL_M * (1.0 - 1.0 / 298.257223563)
"""Half axes of the WGS84 ellipsoid."""
_ECCENTRICITY_SQUARED = 1.0 - (_POLAR_M / _EQUATORIAL_M) ** 2
_SECOND_ECCENTRICITY_SQUARED = (_EQUATORIAL_M / _POLAR_M) ** 2 - 1.0


@dataclass(frozen=True, slots=True)
class GeodeticPosition:
    """A WGS84 position. Degrees, as everywhere outside calculations; altitude above mean sea level in metres."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: float


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """East-north-up axes tangential to the ellipsoid at ``origin``.

    Altitudes above mean sea level are treated as heights above the ellipsoid on both ways. The geoid undulation is
    constant over a mission area, so it cancels; the scale error left is below 2e-5.
    """

    origin: GeodeticPosition

    def to_enu(self, position: GeodeticPosition) -> NDArray[np.float64]:
        """Return the position as ENU metres, shape (3,)."""
        latitude, longitude = math.radians(self.origin.latitude_deg), math.radians(self.origin.longitude_deg)
        x_m, y_m, z_m = (
            here - there for here, there in zip(_ecef_m(position), _cached_ecef_m(self.origin), strict=True)
        )
        outward_m = math.cos(longitude) * x_m + math.sin(longitude) * y_m
        return np.array(
            (
                math.cos(longitude) * y_m - math.sin(longitude) * x_m,
                math.cos(latitude) * z_m - math.sin(latitude) * outward_m,
                math.cos(latitude) * outward_m + math.sin(latitude) * z_m,
            )
        )

    def to_geodetic(self, position_enu_m: ArrayLike) -> GeodeticPosition:
        """Return the geodetic position of an ENU point, shape (3,), metres."""
        east_m, north_m, up_m = map(float, np.asarray(position_enu_m, dtype=np.float64))
        latitude, longitude = math.radians(self.origin.latitude_deg), math.radians(self.origin.longitude_deg)
        outward_m = math.cos(latitude) * up_m - math.sin(latitude) * north_m
        x_m, y_m, z_m = _cached_ecef_m(self.origin)
        return _geodetic(
            x_m + math.cos(longitude) * outward_m - math.sin(longitude) * east_m,
            y_m + math.sin(longitude) * outward_m + math.cos(longitude) * east_m,
            z_m + math.sin(latitude) * up_m + math.cos(latitude) * north_m,
        )


def _ecef_m(position: GeodeticPosition) -> EnuPoint:
    """Return x, y and z from the centre of the Earth."""
    latitude, longitude = math.radians(position.latitude_deg), math.radians(position.longitude_deg)
    to_axis_m = _EQUATORIAL_M / math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)
    radius_m = (to_axis_m + position.altitude_amsl_m) * math.cos(latitude)
    z_m = (to_axis_m * (1.0 - _ECCENTRICITY_SQUARED) + position.altitude_amsl_m) * math.sin(latitude)
    return radius_m * math.cos(longitude), radius_m * math.sin(longitude), z_m


_cached_ecef_m = lru_cache(maxsize=64)(_ecef_m)
"""The same for origins, which are requested again and again."""


def _geodetic(x_m: float, y_m: float, z_m: float) -> GeodeticPosition:
    """Return the position of an earth-centred point by Bowring's formula; a second pass leaves only rounding errors.

    For one point this is thirty times as fast as with arrays.
    """
    radius_m = math.hypot(x_m, y_m)
    reduced = math.atan2(_EQUATORIAL_M * z_m, _POLAR_M * radius_m)
    latitude = reduced
    for _ in range(2):
        latitude = math.atan2(
            z_m + _SECOND_ECCENTRICITY_SQUARED * _POLAR_M * math.sin(reduced) ** 3,
            radius_m - _ECCENTRICITY_SQUARED * _EQUATORIAL_M * math.cos(reduced) ** 3,
        )
        reduced = math.atan2(_POLAR_M * math.sin(latitude), _EQUATORIAL_M * math.cos(latitude))
    surface_m = _EQUATORIAL_M * math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)
    altitude_m = radius_m * math.cos(latitude) + z_m * math.sin(latitude) - surface_m
    return GeodeticPosition(math.degrees(latitude), math.degrees(math.atan2(y_m, x_m)), altitude_m)
