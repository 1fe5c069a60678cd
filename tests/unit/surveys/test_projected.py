"""Recordings in a projected coordinate system."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pymap3d
import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import intersect_plane
from aos_gcs.surveys.model import Survey, SurveyImage
from aos_gcs.surveys.projected import ProjectedSystem, placed

UTM_33N = "EPSG:32633"
CAMERA = CameraModel.from_fov(64, 48, math.radians(60.0))


def survey_at(*places_m: tuple[float, float, float]) -> Survey:
    images = tuple(SurveyImage(Path(f"{i}.png"), nadir_pose(place), CAMERA) for i, place in enumerate(places_m))
    return Survey(images, ("grey",), None, {})


def test_pixels_lie_at_the_same_latitude_and_longitude() -> None:
    # 2.1 degrees west of the zone's meridian its grid is turned by 1.5 degrees and shrunk by 0.04 %.
    system = ProjectedSystem.of(UTM_33N)
    east_m, north_m = system.east_north_m(48.3, 12.9)
    survey = survey_at((east_m, north_m, 340.0), (east_m + 40.0, north_m + 900.0, 340.0))
    turned = placed(survey, system)
    assert turned.origin is not None
    corner = [[10.0, 40.0]]
    for before, after in zip(survey.images, turned.images, strict=True):
        x_m, y_m, _ = intersect_plane(corner, CAMERA, before.pose, 300.0)[0]
        enu_m = intersect_plane(corner, CAMERA, after.pose, float(after.pose.position_enu_m[2]) - 40.0)[0]
        latitude, longitude, altitude_m = pymap3d.enu2geodetic(
            *enu_m, turned.origin.latitude_deg, turned.origin.longitude_deg, turned.origin.altitude_amsl_m
        )
        assert system.east_north_m(float(latitude), float(longitude)) == pytest.approx((x_m, y_m), abs=0.05)
        assert altitude_m == pytest.approx(300.0, abs=0.02)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("EPSG:1", "is unknown"),
        ("33N", "is unknown"),
        ("EPSG:4326", "no eastings and northings in metres"),
        ("EPSG:2230", "no eastings and northings in metres"),
    ],
)
def test_systems_that_have_no_metres_are_refused(name: str, reason: str) -> None:
    with pytest.raises(ConfigurationError, match=reason):
        ProjectedSystem.of(name)


@pytest.mark.parametrize("place_m", [(-1e7, -3e7, 30.0), (math.nan, 5.3e6, 30.0), (9e7, 5.3e6, 30.0)])
def test_places_beyond_the_system_are_refused(place_m: tuple[float, float, float]) -> None:
    with pytest.raises(InputDataError, match="not a place in EPSG:32633: check --crs"):
        placed(survey_at(place_m), ProjectedSystem.of(UTM_33N))


def test_orientation_turns_with_the_grid() -> None:
    system = ProjectedSystem.of(UTM_33N)
    east_m, north_m = system.east_north_m(48.3, 12.9)
    (image,) = placed(survey_at((east_m, north_m, 340.0)), system).images
    convergence_deg = math.degrees(math.atan2(*map(float, -image.pose.R_cam2enu[:2, 1])))
    # West of its meridian a grid's north lies west of the true one, by the longitude times the sine of the latitude.
    assert convergence_deg == pytest.approx(-2.1 * math.sin(math.radians(48.3)), abs=0.01)
    assert np.linalg.det(image.pose.R_cam2enu) == pytest.approx(1.0)


def test_places_beside_the_area_of_a_system_are_told() -> None:
    def place(latitude_deg: float, longitude_deg: float) -> GeodeticPosition:
        return GeodeticPosition(latitude_deg, longitude_deg, 300.0)

    system = ProjectedSystem.of(UTM_33N)
    assert system.remark(place(48.3, 14.3)) is None
    assert system.remark(place(84.0, 12.0)) is None
    assert "longitudes 12 to 18): check --crs" in str(system.remark(place(48.3, 11.5)))
    for latitude_deg, longitude_deg in ((48.3, 5.9), (48.3, 24.1), (-6.1, 15.0), (48.3, -165.0)):
        with pytest.raises(InputDataError, match="beside the area of EPSG:32633"):
            system.remark(place(latitude_deg, longitude_deg))
    # The area of the Pacific goes across the date line.
    assert ProjectedSystem.of("EPSG:3832").remark(place(-18.0, -179.0)) is None
