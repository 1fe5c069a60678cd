"""Heights above mean sea level, the ellipsoid, home and the ground are different types."""

from __future__ import annotations

import typing
from pathlib import Path

import pymap3d
import pytest
from mypy import api as mypy

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame, frame_scale_error
from aos_gcs.geometry.heights import AboveHomeM, AmslM, above_home_m, amsl_above_home_m, amsl_m, ellipsoidal_m

ROOT = Path(__file__).parents[3]
UNDULATION_M = 48.0
MIXED_UP = """
from aos_gcs.geometry.heights import AboveGroundM, AboveHomeM, AmslM, EllipsoidalM
from aos_gcs.geometry.heights import amsl_above_home_m, amsl_m, ellipsoidal_m

def right(altitude: AmslM, height: EllipsoidalM, above_home: AboveHomeM, above_ground: AboveGroundM) -> None:
    ellipsoidal_m(altitude, 48.0)
    ellipsoidal_m(AmslM(altitude + 1.0), 48.0)
    amsl_m(height, 48.0)
    amsl_above_home_m(altitude, above_home)

def wrong(altitude: AmslM, height: EllipsoidalM, above_home: AboveHomeM, above_ground: AboveGroundM) -> None:
    ellipsoidal_m(height, 48.0)
    ellipsoidal_m(above_home, 48.0)
    ellipsoidal_m(altitude + 1.0, 48.0)
    amsl_m(altitude, 48.0)
    amsl_above_home_m(altitude, above_ground)
    amsl_above_home_m(altitude, 30.0)
"""


def test_the_type_checker_refuses_every_mix_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MYPYPATH", str(ROOT))
    file = tmp_path / "mixed_up.py"
    file.write_text(MIXED_UP)
    told, _, _ = mypy.run(["--strict", "--config-file=", f"--cache-dir={tmp_path}", str(file)])
    lines = MIXED_UP.splitlines()
    refused = [lines[int(line.split(":")[1]) - 1] for line in told.splitlines() if "[arg-type]" in line]
    assert refused == MIXED_UP.partition("def wrong")[2].splitlines()[1:], told
    assert f"Found {len(refused)} errors" in told


def test_positions_are_above_mean_sea_level() -> None:
    assert typing.get_type_hints(GeodeticPosition)["altitude_amsl_m"] is AmslM


def test_heights_above_the_ellipsoid_are_converted_by_the_geometry_only() -> None:
    sources = [file for folder in ("aos_gcs", "drivers", "sim") for file in (ROOT / folder).rglob("*.py")]
    makers = {file.relative_to(ROOT).as_posix() for file in sources if "EllipsoidalM(" in file.read_text("utf-8")}
    # The marks of others state it where they enter, as Cursor on Target counts heights.
    assert makers == {
        "aos_gcs/geometry/heights.py",
        "aos_gcs/geometry/geodesy.py",
        "aos_gcs/sharing/tak/marks.py",
    }


def test_conversions_lead_back() -> None:
    altitude_m = AmslM(260.0)
    assert ellipsoidal_m(altitude_m, UNDULATION_M) == 308.0
    assert amsl_m(ellipsoidal_m(altitude_m, UNDULATION_M), UNDULATION_M) == altitude_m
    assert amsl_above_home_m(altitude_m, AboveHomeM(35.0)) == 295.0
    assert above_home_m(AmslM(295.0), altitude_m) == 35.0


@pytest.mark.parametrize(("undulation_m", "millionths"), [(48.0, 7.5), (-106.0, -16.6), (85.0, 13.3)])
def test_the_geoid_changes_the_scale_of_a_frame_and_nothing_else(undulation_m: float, millionths: float) -> None:
    origin = GeodeticPosition(48.3, 14.3, AmslM(260.0))
    for east_m, north_m, up_m in ((1000.0, 0.0, 0.0), (0.0, 1000.0, 60.0), (-3000.0, 2000.0, 120.0)):
        position = LocalFrame(origin).to_geodetic((east_m, north_m, up_m))
        true_m = pymap3d.geodetic2enu(
            position.latitude_deg,
            position.longitude_deg,
            ellipsoidal_m(position.altitude_amsl_m, undulation_m),
            origin.latitude_deg,
            origin.longitude_deg,
            ellipsoidal_m(origin.altitude_amsl_m, undulation_m),
        )
        assert frame_scale_error(undulation_m) == pytest.approx(1e-6 * millionths, abs=1e-7)
        scaled_m = [along_m * (1.0 + 1e-6 * millionths) for along_m in (east_m, north_m)]
        assert list(map(float, true_m)) == pytest.approx([*scaled_m, up_m], abs=3e-4)
