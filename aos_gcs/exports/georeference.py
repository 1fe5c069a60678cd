"""Georeference: place of a map's world on the earth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame

WGS84_MEAN_RADIUS_M = 6_371_008.8


class Georeference(Protocol):
    """Places a Cartesian world."""

    def crs(self, height_m: float) -> str:
        """Return the coordinate system, as PROJ or WKT text, whose eastings and northings are x and y.

        Args:
            height_m: z of what the map shows.
        """

    def latitude_longitude_deg(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float]:
        """Return the WGS84 latitude and longitude of a point, degrees."""


@dataclass(frozen=True, slots=True)
class LocalGeoreference:
    """The world is east-north-up about an origin.

    Its map is a transverse Mercator projection about the origin, scaled so that metres are those on the surface shown:
    it departs from the tangential plane by the cube of the distance over six times the square of the earth's radius,
    less than a centimetre 10 km away. A zone of UTM would turn and stretch the map.
    """

    origin: GeodeticPosition

    def crs(self, height_m: float) -> str:
        """See :class:`Georeference`."""
        scale = 1.0 + (self.origin.altitude_amsl_m + height_m) / WGS84_MEAN_RADIUS_M
        return (
            f"+proj=tmerc +lat_0={self.origin.latitude_deg!r} +lon_0={self.origin.longitude_deg!r} +k={scale!r} "
            "+x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"
        )

    def latitude_longitude_deg(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float]:
        """See :class:`Georeference`."""
        position = LocalFrame(self.origin).to_geodetic((x_m, y_m, z_m))
        return position.latitude_deg, position.longitude_deg


@dataclass(frozen=True, slots=True)
class ProjectedGeoreference:
    """The world's x and y are eastings and northings of a coordinate system."""

    wkt: str

    def crs(self, height_m: float) -> str:  # noqa: ARG002 - a projection has its own scale
        """See :class:`Georeference`."""
        return self.wkt

    def latitude_longitude_deg(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float]:  # noqa: ARG002
        """See :class:`Georeference`."""
        pyproj: Any = load_extra("pyproj", "geo", "Converting coordinates")
        longitude, latitude = pyproj.Transformer.from_crs(self.wkt, "EPSG:4326", always_xy=True).transform(x_m, y_m)
        return float(latitude), float(longitude)
