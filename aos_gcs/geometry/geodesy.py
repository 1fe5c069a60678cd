"""Geodetic positions and the local east-north-up frame of a mission."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import ArrayLike, NDArray

EnuPoint = tuple[float, float, float]
"""East, north and up in metres."""


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
        origin = self.origin
        return np.array(
            pymap3d.geodetic2enu(
                position.latitude_deg,
                position.longitude_deg,
                position.altitude_amsl_m,
                origin.latitude_deg,
                origin.longitude_deg,
                origin.altitude_amsl_m,
            ),
            dtype=np.float64,
        )

    def to_geodetic_all(self, positions_enu_m: ArrayLike) -> list[GeodeticPosition]:
        """Return the geodetic positions of ENU points, shape (n, 3), metres; much faster than one by one."""
        east_m, north_m, up_m = np.asarray(positions_enu_m, dtype=np.float64).reshape(-1, 3).T
        origin = self.origin
        rows = pymap3d.enu2geodetic(
            east_m, north_m, up_m, origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m
        )
        return [GeodeticPosition(*map(float, row)) for row in zip(*rows, strict=True)]

    def to_geodetic(self, position_enu_m: ArrayLike) -> GeodeticPosition:
        """Return the geodetic position of an ENU point, shape (3,), metres."""
        east_m, north_m, up_m = np.asarray(position_enu_m, dtype=np.float64)
        origin = self.origin
        latitude_deg, longitude_deg, altitude_m = pymap3d.enu2geodetic(
            east_m, north_m, up_m, origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m
        )
        return GeodeticPosition(float(latitude_deg), float(longitude_deg), float(altitude_m))
