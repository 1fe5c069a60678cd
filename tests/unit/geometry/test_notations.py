"""Degrees, minutes and seconds, UTM and MGRS."""

import re

import mgrs
import pymap3d
import pytest
import utm
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.geometry.notations import dms, mgrs_text, utm_text

LATITUDES = st.floats(-79.9, 83.9)
LONGITUDES = st.floats(-180.0, 179.999)


def distance_m(latitude_deg: float, longitude_deg: float, other_deg: tuple[float, float]) -> float:
    east_m, north_m, _ = pymap3d.geodetic2enu(*other_deg, 0.0, latitude_deg, longitude_deg, 0.0)
    return float((east_m**2 + north_m**2) ** 0.5)


def from_dms(text: str) -> tuple[float, float]:
    angles = []
    for degrees, minutes, seconds, hemisphere in re.findall(r"(\d+)°(\d\d)'(\d\d\.\d\d)\"([NSEW])", text):
        size = int(degrees) + int(minutes) / 60 + float(seconds) / 3600
        angles.append(-size if hemisphere in "SW" else size)
    return angles[0], angles[1]


@given(LATITUDES, LONGITUDES)
def test_every_notation_leads_back_to_the_place(latitude_deg: float, longitude_deg: float) -> None:
    assert distance_m(latitude_deg, longitude_deg, from_dms(dms(latitude_deg, longitude_deg))) < 0.3
    zone, east_m, north_m = str(utm_text(latitude_deg, longitude_deg)).split()
    back_deg = utm.to_latlon(float(east_m), float(north_m), int(zone[:-1]), zone[-1], strict=False)
    assert distance_m(latitude_deg, longitude_deg, back_deg) < 1.0
    code = mgrs_text(latitude_deg, longitude_deg).replace(" ", "")
    assert distance_m(latitude_deg, longitude_deg, mgrs.MGRS().toLatLon(code)) < 1.5


def test_a_known_place_reads_as_on_a_map() -> None:
    assert dms(47.5, -8.25) == "47°30'00.00\"N 8°15'00.00\"W"
    assert utm_text(47.0, 9.0) == "32T 500000 5205164"
    assert mgrs_text(47.0, 9.0) == "32T NT 00000 05164"


@pytest.mark.parametrize("angle_deg", [59.9999999 / 60, 0.99999999])
def test_seconds_never_reach_sixty(angle_deg: float) -> None:
    assert "60" not in dms(angle_deg, angle_deg)


def test_near_the_poles_there_is_no_utm() -> None:
    assert utm_text(85.0, 10.0) is None
    assert mgrs_text(85.0, 10.0).startswith("Z ")
