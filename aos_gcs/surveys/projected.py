"""Recordings whose poses are in a projected coordinate system, such as a zone of UTM."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL, AmslM
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.rotations import R_from_rotation_vector
from aos_gcs.surveys.model import Survey, SurveyImage

_NORTHWARD_M = 100.0
"""Length by which the direction of the grid's north is measured."""

_MAX_OUTSIDE_DEG = 6.0
"""Distance from its area up to which a system is used: flights near the edge of a zone often take the next one."""


@dataclass(frozen=True, slots=True)
class ProjectedSystem:
    """A coordinate system of eastings and northings in metres."""

    name: str
    """Name as given, such as ``EPSG:32633``."""
    _to_geodetic: Any
    _from_geodetic: Any
    _area_deg: tuple[float, float, float, float] | None
    """West, south, east and north of the area that the system is made for; None where it is not known."""

    @classmethod
    def of(cls, name: str) -> ProjectedSystem:
        """Return the system of a name.

        Raises:
            ConfigurationError: it is unknown, or not a projection with eastings and northings in metres.
        """
        pyproj: Any = load_extra("pyproj", "geo", "--crs")
        try:
            crs = pyproj.CRS.from_user_input(name)
        except pyproj.exceptions.CRSError as error:
            raise ConfigurationError(f"--crs {name!r} is unknown: give a code such as EPSG:32633.") from error
        axes = [(axis.direction, axis.unit_name) for axis in crs.axis_info[:2]]
        if not crs.is_projected or sorted(axes) != [("east", "metre"), ("north", "metre")]:
            raise ConfigurationError(
                f"--crs {name}: {crs.name} has no eastings and northings in metres; give a projected coordinate "
                "system, such as the zone of UTM."
            )
        return cls(
            name,
            pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True),
            pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True),
            None if crs.area_of_use is None else crs.area_of_use.bounds,
        )

    def remark(self, place: GeodeticPosition) -> str | None:
        """Return a remark on a place that lies beside the area of the system; None for one within it.

        Raises:
            InputDataError: it lies too far away, so that the system or the place must be another.
        """
        if self._area_deg is None:
            return None
        west, south, east, north = self._area_deg
        width_deg = (east - west) % 360.0 or 360.0
        behind_deg = (place.longitude_deg - west) % 360.0
        across_deg = 0.0 if behind_deg <= width_deg else min(behind_deg - width_deg, 360.0 - behind_deg)
        along_deg = max(south - place.latitude_deg, place.latitude_deg - north, 0.0)
        if max(across_deg, along_deg) == 0.0:
            return None
        text = (
            f"The recording lies at {place.latitude_deg:.5f}, {place.longitude_deg:.5f}, beside the area of "
            f"{self.name} (latitudes {south:g} to {north:g}, longitudes {west:g} to {east:g}): check --crs."
        )
        if max(across_deg, along_deg) > _MAX_OUTSIDE_DEG:
            raise InputDataError(text)
        return text

    def position(self, east_m: float, north_m: float, altitude_m: AmslM) -> GeodeticPosition:
        """Return a position; its coordinates are not finite where the system does not hold."""
        longitude_deg, latitude_deg = self._to_geodetic.transform(east_m, north_m)
        return GeodeticPosition(float(latitude_deg), float(longitude_deg), altitude_m)

    def east_north_m(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """Return easting and northing."""
        east_m, north_m = self._from_geodetic.transform(longitude_deg, latitude_deg)
        return float(east_m), float(north_m)


def placed(survey: Survey, system: ProjectedSystem) -> Survey:
    """Return a survey in the east-north-up world about its first image, at altitude 0: heights stay altitudes.

    Args:
        survey: survey whose poses have eastings, northings and altitudes.
        system: their coordinate system.

    Raises:
        InputDataError: they do not lie where the system holds.
    """
    first = survey.images[0]
    east_m, north_m, _ = map(float, first.pose.position_enu_m)
    origin = system.position(east_m, north_m, SEA_LEVEL)
    if not (math.isfinite(origin.latitude_deg) and math.isfinite(origin.longitude_deg)):
        raise _out_of_range(first, system)
    # Beyond its zone a projection still gives numbers, which come back as others.
    back_m = system.east_north_m(origin.latitude_deg, origin.longitude_deg)
    if not all(math.isfinite(value) for value in back_m) or math.dist(back_m, (east_m, north_m)) > 1.0:
        raise _out_of_range(first, system)
    frame = LocalFrame(origin)
    return replace(survey, images=_turned(survey.images, system, frame), origin=origin)


def _turned(images: Sequence[SurveyImage], system: ProjectedSystem, frame: LocalFrame) -> tuple[SurveyImage, ...]:
    turned = []
    for image in images:
        east_m, north_m, up_m = map(float, image.pose.position_enu_m)
        position = system.position(east_m, north_m, AmslM(up_m))
        if not (math.isfinite(position.latitude_deg) and math.isfinite(position.longitude_deg)):
            raise _out_of_range(image, system)
        place_m = frame.to_enu(position)
        northward_m = frame.to_enu(system.position(east_m, north_m + _NORTHWARD_M, AmslM(up_m))) - place_m
        # The grid's north lies clockwise of the true one by the convergence of meridians.
        convergence_rad = math.atan2(float(northward_m[0]), float(northward_m[1]))
        R_grid2enu = R_from_rotation_vector(np.array([0.0, 0.0, -convergence_rad]))
        turned.append(replace(image, pose=Pose(place_m, R_grid2enu @ image.pose.R_cam2enu)))
    return tuple(turned)


def _out_of_range(image: SurveyImage, system: ProjectedSystem) -> InputDataError:
    east_m, north_m, _ = image.pose.position_enu_m
    return InputDataError(
        f"The pose of {image.path.name} lies at {east_m:.0f} m east, {north_m:.0f} m north, which is not a place in "
        f"{system.name}: check --crs."
    )
