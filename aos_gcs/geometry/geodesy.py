"""Geodetic positions and the local east-north-up frame of a mission.

Written out for single points, which flights convert all the time: pymap3d, which the tests compare with, takes thirty
times as long for one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aos_gcs.geometry.heights import AmslM, EllipsoidalM, amsl_m, ellipsoidal_m

EnuPoint = tuple[float, float, float]
"""East, north and up in metres."""

_EQUATORIAL_M = 6378137.0
_POLAR_M = _EQUATORIAL_M * (1.0 - 1.0 / 298.257223563)
"""Half axes of the WGS84 ellipsoid."""
_MEAN_RADIUS_M = 6_371_008.8
_ECCENTRICITY_SQUARED = 1.0 - (_POLAR_M / _EQUATORIAL_M) ** 2
_SECOND_ECCENTRICITY_SQUARED = (_EQUATORIAL_M / _POLAR_M) ** 2 - 1.0

_FRAME_UNDULATION_M: Final = 0.0
"""Height of the geoid above the ellipsoid within local frames; see :class:`LocalFrame`."""


@dataclass(frozen=True, slots=True)
class GeodeticPosition:
    """A WGS84 position. Degrees, as everywhere outside calculations; altitude above mean sea level in metres."""

    latitude_deg: float
    longitude_deg: float
    altitude_amsl_m: AmslM

    @classmethod
    def from_fields(cls, fields: Mapping[str, float]) -> GeodeticPosition:
        """Return the position of its own fields, as files hold them.

        Raises:
            KeyError: one is missing.
            TypeError: one is not a number.
            ValueError: one is not a number.
        """
        return cls(
            latitude_deg=float(fields["latitude_deg"]),
            longitude_deg=float(fields["longitude_deg"]),
            altitude_amsl_m=AmslM(float(fields["altitude_amsl_m"])),
        )


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """East-north-up axes tangential to the ellipsoid at ``origin``, whose altitude is above mean sea level.

    Positions enter and leave above mean sea level, too. In between they are as high above the ellipsoid: the geoid
    counts as the ellipsoid, whether or not it is known how far above it lies. A constant undulation N cancels, but for
    the scale: distances are shorter by N / 6,371 km, 7.5 millionths for 48 m and never more than 17. That is so with
    and without the grid of a geoid on a machine, so that a recorded mission is computed again with the same numbers.
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


def frame_scale_error(undulation_m: float) -> float:
    """Return by what share metres of local frames are too short where the geoid is that high above the ellipsoid."""
    return (undulation_m - _FRAME_UNDULATION_M) / _MEAN_RADIUS_M


def _ecef_m(position: GeodeticPosition) -> EnuPoint:
    """Return x, y and z from the centre of the Earth."""
    height_m = ellipsoidal_m(position.altitude_amsl_m, _FRAME_UNDULATION_M)
    latitude, longitude = math.radians(position.latitude_deg), math.radians(position.longitude_deg)
    to_axis_m = _EQUATORIAL_M / math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)
    radius_m = (to_axis_m + height_m) * math.cos(latitude)
    z_m = (to_axis_m * (1.0 - _ECCENTRICITY_SQUARED) + height_m) * math.sin(latitude)
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
    height_m = EllipsoidalM(radius_m * math.cos(latitude) + z_m * math.sin(latitude) - surface_m)
    altitude_m = amsl_m(height_m, _FRAME_UNDULATION_M)
    return GeodeticPosition(math.degrees(latitude), math.degrees(math.atan2(y_m, x_m)), altitude_m)
