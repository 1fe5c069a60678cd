"""Positions, attitudes and focal lengths of photographs, in the tags of different manufacturers."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL.TiffImagePlugin import IFDRational

from aos_gcs import extras
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geotags.exif import exif_tags
from aos_gcs.geotags.photo import Geotag, geotag, read_geotag
from aos_gcs.geotags.sensors import Sensor, sensor_of
from aos_gcs.geotags.xmp import parse_xmp
from tests.fakes.photographs import exif_block, write_photograph, xmp_packet

WIDTH, HEIGHT = 80, 60
DIAGONAL_PX = math.hypot(WIDTH, HEIGHT)

DJI = {
    "drone-dji:GpsLatitude": "48.3069",
    "drone-dji:GpsLongitude": "14.2858",
    "drone-dji:AbsoluteAltitude": "+312.40",
    "drone-dji:RelativeAltitude": "+35.10",
    "drone-dji:GimbalYawDegree": "+120.00",
    "drone-dji:GimbalPitchDegree": "-90.00",
    "drone-dji:GimbalRollDegree": "+0.00",
    "drone-dji:FlightYawDegree": "+118.30",
}


def tag_of(xmp: bytes, **exif: Any) -> Geotag:
    return geotag(exif_tags(exif_block(**exif), WIDTH), parse_xmp(xmp) if xmp else {}, WIDTH, HEIGHT)


def test_what_dji_writes() -> None:
    tag = tag_of(xmp_packet(DJI))
    assert (tag.latitude_deg, tag.longitude_deg) == (48.3069, 14.2858)
    assert (tag.altitude_amsl_m, tag.relative_altitude_m) == (312.4, 35.1)
    np.testing.assert_allclose(tag.R_cam2enu, nadir_pose((0, 0, 0), math.radians(120.0)).R_cam2enu, atol=1e-12)


def test_the_optical_axis_follows_pitch_and_yaw() -> None:
    xmp = xmp_packet(DJI | {"drone-dji:GimbalYawDegree": "90", "drone-dji:GimbalPitchDegree": "-30"})
    right, down, forward = tag_of(xmp).R_cam2enu.T
    np.testing.assert_allclose(forward, [math.cos(math.radians(30)), 0.0, -0.5], atol=1e-12)
    np.testing.assert_allclose(right, [0.0, -1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(down, np.cross(forward, right), atol=1e-12)


@given(yaw=st.floats(-180, 180), pitch=st.floats(-90, 30), roll=st.floats(-45, 45))
def test_gimbal_angles_give_rotations(yaw: float, pitch: float, roll: float) -> None:
    angles = {"GimbalYawDegree": yaw, "GimbalPitchDegree": pitch, "GimbalRollDegree": roll}
    R = geotag(
        exif_tags(exif_block(48.0, 14.0), WIDTH), {name: repr(value) for name, value in angles.items()}, WIDTH, HEIGHT
    ).R_cam2enu
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    # Roll turns about the optical axis, which pitch alone raises.
    assert R[2, 2] == pytest.approx(math.sin(math.radians(pitch)), abs=1e-12)


OTHERS = {
    "Autel": xmp_packet(
        {
            "drone:GpsLatitude": 48.0,
            "drone:GpsLongtitude": 14.0,
            "drone:GimbalYawDegree": 30.0,
            "drone:GimbalPitchDegree": -90.0,
            "drone:GimbalRollDegree": 0.0,
        }
    ),
    "no gimbal yaw": xmp_packet(
        {
            "drone-dji:GpsLatitude": 48.0,
            "drone-dji:GpsLongitude": 14.0,
            "drone-dji:FlightYawDegree": 30.0,
            "drone-dji:GimbalPitchDegree": -90.0,
        }
    ),
    "Parrot": xmp_packet(
        {},
        "<drone-parrot:CameraYawDegree>30</drone-parrot:CameraYawDegree>"
        "<drone-parrot:CameraPitchDegree>-90</drone-parrot:CameraPitchDegree>"
        "<drone-parrot:CameraRollDegree>0</drone-parrot:CameraRollDegree>",
    ),
    "Teal": xmp_packet(
        {"exif:GPSLatitude": "48,0.0N", "exif:GPSLongitude": "14,0.0E"},
        "<exif:CameraYaw>359000000/1000000</exif:CameraYaw><exif:CameraPitch>-144000/1600</exif:CameraPitch>"
        "<exif:CameraRoll>0</exif:CameraRoll><exif:PlatformYaw>31</exif:PlatformYaw>"
        "<exif:PlatformPitch>0</exif:PlatformPitch><exif:PlatformRoll>0</exif:PlatformRoll>",
    ),
    "Skydio": xmp_packet(
        {"drone-skydio:Latitude": 48.0, "drone-skydio:Longitude": 14.0},
        '<drone-skydio:CameraOrientationNED drone-skydio:Roll="0" drone-skydio:Pitch="-90" drone-skydio:Yaw="30"/>',
    ),
    "Skydio, structure": xmp_packet(
        {},
        "<drone-skydio:Latitude>48</drone-skydio:Latitude><drone-skydio:Longitude>14</drone-skydio:Longitude>"
        '<drone-skydio:CameraOrientationNED rdf:parseType="Resource"><drone-skydio:Yaw>30</drone-skydio:Yaw>'
        "<drone-skydio:Pitch>-90</drone-skydio:Pitch><drone-skydio:Roll>0</drone-skydio:Roll>"
        "</drone-skydio:CameraOrientationNED>",
    ),
    "Pix4D": xmp_packet({"Camera:Yaw": 30.0, "Camera:Pitch": 0.0, "Camera:Roll": 0.0}),
    "Autel, from the horizon": xmp_packet({"Camera:Yaw": 30.0, "Camera:Pitch": -90.0, "Camera:Roll": 0.0}),
}


@pytest.mark.parametrize("xmp", OTHERS.values(), ids=OTHERS.keys())
def test_other_names_for_the_same_pose(xmp: bytes) -> None:
    tag = tag_of(xmp, latitude_deg=48.0, longitude_deg=14.0)
    assert (tag.latitude_deg, tag.longitude_deg) == pytest.approx((48.0, 14.0))
    np.testing.assert_allclose(tag.R_cam2enu, nadir_pose((0, 0, 0), math.radians(30.0)).R_cam2enu, atol=1e-12)


def test_pitch_of_pix4d_counts_from_nadir() -> None:
    R = tag_of(xmp_packet({"Camera:Yaw": 0, "Camera:Pitch": 30}), latitude_deg=1.0, longitude_deg=1.0).R_cam2enu
    np.testing.assert_allclose(R[:, 2], [0.0, 0.5, -math.cos(math.radians(30))], atol=1e-12)


def test_a_camera_turns_with_the_platform_that_its_angles_are_of() -> None:
    angles = {"exif:CameraYaw": 10, "exif:CameraPitch": -60, "exif:CameraRoll": 0}
    platform = {"exif:PlatformYaw": 80, "exif:PlatformPitch": 0, "exif:PlatformRoll": 0}
    position = {"latitude_deg": 1.0, "longitude_deg": 1.0}
    down, east = tag_of(xmp_packet(angles | platform), **position).R_cam2enu[:, [1, 2]].T
    np.testing.assert_allclose(east, [0.5, 0.0, -math.sin(math.radians(60))], atol=1e-12)
    assert down[2] == pytest.approx(-0.5)
    nose_up = tag_of(xmp_packet(angles | platform | {"exif:CameraYaw": 0, "exif:PlatformPitch": 15}), **position)
    assert nose_up.R_cam2enu[2, 2] == pytest.approx(-math.sin(math.radians(45)))
    with pytest.raises(InputDataError, match="GimbalYawDegree"):
        tag_of(xmp_packet(angles), **position)


@given(latitude=st.floats(-89.9, 89.9), longitude=st.floats(-179.9, 179.9), altitude=st.floats(-400, 8000))
def test_exif_positions(latitude: float, longitude: float, altitude: float) -> None:
    tags = exif_tags(exif_block(latitude, longitude, altitude), WIDTH)
    assert tags.latitude_deg == pytest.approx(latitude, abs=1e-10)
    assert tags.longitude_deg == pytest.approx(longitude, abs=1e-10)
    assert tags.altitude_amsl_m == pytest.approx(altitude, abs=6e-4)


FOCAL_LENGTHS: dict[str, tuple[dict[str, object], dict[int, Any], float | None]] = {
    "35 mm film": ({}, {0xA405: 24}, 24.0 / math.hypot(36, 24) * DIAGONAL_PX),
    "sensor": ({}, {0x920A: IFDRational(45, 10), 0xA20E: IFDRational(WIDTH, 6), 0xA210: 4}, 4.5 / 6.0 * WIDTH),
    "calibrated": ({"drone-dji:CalibratedFocalLength": "77.5"}, {0xA405: 24}, 77.5),
    "calibrated, zoomed": ({"drone-dji:CalibratedFocalLength": "77.5"}, {0xA404: 2.0}, 155.0),
    "calibrated, reduced": ({"drone-dji:CalibratedFocalLength": "775"}, {0xA002: WIDTH * 10}, 77.5),
    "calibrated in micrometres": (
        {"drone-dji:CalibratedFocalLength": "9100.000000", "drone-dji:CalibratedOpticalCenterX": "0.000000"},
        {0xA405: 40},
        40.0 / math.hypot(36, 24) * DIAGONAL_PX,
    ),
    "field of view": ({"exif:CameraHorizontalFOV": "90000000/1000000"}, {0xA405: 24}, WIDTH / 2),
    "no field of view": ({"exif:CameraHorizontalFOV": "0/0"}, {0xA405: 24}, 24.0 / math.hypot(36, 24) * DIAGONAL_PX),
    "calibrated for the camera beside it": (
        {"drone-dji:CalibratedFocalLength": "4892", "drone-dji:CalibratedOpticalCenterX": f"{WIDTH * 3}"},
        {},
        None,
    ),
    "unknown": ({}, {0x920A: IFDRational(45, 10)}, None),
    "zero": ({}, {0xA405: 0, 0x920A: IFDRational(0, 0)}, None),
}


@pytest.mark.parametrize(("xmp", "camera", "expected_px"), FOCAL_LENGTHS.values(), ids=FOCAL_LENGTHS.keys())
def test_focal_lengths(xmp: dict[str, object], camera: dict[int, Any], expected_px: float | None) -> None:
    tag = tag_of(xmp_packet(DJI | xmp), camera=camera)
    assert tag.focal_px == (None if expected_px is None else pytest.approx(expected_px))
    if expected_px is None:
        with pytest.raises(InputDataError, match="CalibratedFocalLength of its own, FocalLengthIn35mmFilm"):
            tag.camera()
    else:
        assert tag.camera().fx_px == pytest.approx(expected_px)
    assert tag.camera(math.radians(60)).horizontal_fov_rad == pytest.approx(math.radians(60))


FACTORY = {
    "drone-dji:DewarpData": "2018-09-04;78.5,78.4,1.5,-2.5,-0.268652,0.114663,0.0000153,-0.0000461,-0.0350261",
    "drone-dji:DewarpFlag": "0",
    "drone-dji:CalibratedFocalLength": "77.5",
}


def test_the_factorys_calibration_is_used_where_the_picture_is_not_corrected_by_it() -> None:
    camera = tag_of(xmp_packet(DJI | FACTORY)).camera()
    assert (camera.fx_px, camera.fy_px) == (78.5, 78.4)
    assert (camera.cx_px, camera.cy_px) == ((WIDTH - 1) / 2 + 1.5, (HEIGHT - 1) / 2 - 2.5)
    assert camera.distortion is not None
    assert camera.distortion.coefficients == (-0.268652, 0.114663, 0.0000153, -0.0000461, -0.0350261)
    assert tag_of(xmp_packet(DJI | FACTORY)).camera(math.radians(60)).distortion is None


@pytest.mark.parametrize(
    ("xmp", "camera"),
    [
        ({"drone-dji:DewarpFlag": "1"}, {}),
        ({"drone-dji:CalibratedOpticalCenterX": f"{2 * WIDTH}"}, {0xA405: 24}),
        ({"drone-dji:DewarpData": "2018-09-04;78.5,78.4,1.5,-2.5,-0.27"}, {}),
        ({"drone-dji:DewarpData": "2018-09-04;78.5,78.4,1.5,-2.5,nan,0.1,0,0,0"}, {}),
        ({"drone-dji:DewarpData": "2018-09-04;0,0,0,0,0,0,0,0,0"}, {}),
        ({"drone-dji:DewarpData": "2018-09-04;78.5,78.4,400,-2.5,0,0,0,0,0"}, {}),
        ({"drone-dji:DewarpData": "none"}, {}),
        ({}, {0xA002: 2 * WIDTH}),
    ],
)
def test_a_calibration_that_does_not_apply_is_left(xmp: dict[str, object], camera: dict[int, Any]) -> None:
    tag = tag_of(xmp_packet(DJI | FACTORY | xmp), camera=camera)
    assert tag.factory is None
    assert tag.camera().distortion is None


def test_the_time_of_exposure_may_be_told_to_the_microsecond() -> None:
    """A Mavic 3T tells it so; its EXIF has a time of an unknown zone."""
    tag = tag_of(xmp_packet(DJI | {"drone-dji:UTCAtExposure": "2022:07:23 07:12:22.872778"}))
    assert tag.utc_s == pytest.approx(1658560342.872778, abs=1e-6)
    assert tag_of(xmp_packet(DJI | {"drone-dji:UTCAtExposure": "soon"})).utc_s is None


NO_PLACE = DJI | {"drone-dji:GpsLatitude": "0.0", "drone-dji:GpsLongitude": "0.0"}
NO_ANGLE = {name: value for name, value in DJI.items() if "GimbalPitch" not in name}

USELESS: dict[str, tuple[bytes, dict[str, Any], str]] = {
    "nothing": (b"", {}, "no GPSLatitude and GPSLongitude"),
    "no attitude": (b"", {"latitude_deg": 48.0, "longitude_deg": 14.0}, "no GimbalYawDegree and GimbalPitchDegree"),
    "no pitch": (xmp_packet(NO_ANGLE), {}, "no GimbalYawDegree and GimbalPitchDegree"),
    "a gimbal that does not report": (
        xmp_packet(DJI | dict.fromkeys(("drone-dji:GimbalYawDegree", "drone-dji:GimbalPitchDegree"), "0.00")),
        {},
        "GimbalYawDegree, GimbalPitchDegree, GimbalRollDegree are all 0: the gimbal has not reported its angles",
    ),
    "no number": (xmp_packet(DJI | {"drone-dji:GimbalPitchDegree": "nan"}), {}, "no GimbalYawDegree and"),
    "no fix": (xmp_packet(NO_PLACE), {}, "is not on the earth: it had no fix"),
    "off the globe": (xmp_packet(DJI | {"drone-dji:GpsLatitude": "148"}), {}, "is not on the earth"),
    "mirrored": (xmp_packet(DJI), {"orientation": 5}, "its Orientation tag, 5, says that it is mirrored"),
    "broken XMP": (xmp_packet(DJI)[:-40], {}, "its XMP is not valid XML"),
    "entities": (
        b'<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><x:xmpmeta xmlns:x="adobe:ns:meta/">&b;</x:xmpmeta>',
        {},
        "its XMP is not valid XML",
    ),
}


@pytest.mark.parametrize(("xmp", "exif", "reason"), USELESS.values(), ids=USELESS.keys())
def test_what_is_missing_is_named(xmp: bytes, exif: dict[str, Any], reason: str) -> None:
    with pytest.raises(InputDataError, match=reason):
        tag_of(xmp, **exif)


@pytest.mark.parametrize(
    ("tags", "name", "expected"),
    [
        ({"drone-dji:ImageSource": "InfraredCamera"}, "DJI_0001_W.jpg", Sensor.THERMAL),
        ({"drone-dji:Model": "M3T"}, "DJI_0001_W.jpg", Sensor.WIDE),
        ({"drone-skydio:CameraSource": "INFRARED"}, "S1008521.jpg", Sensor.THERMAL),
        ({"drone-skydio:CameraSource": "MAIN_VISIBLE"}, "S1008520.jpg", Sensor.WIDE),
        ({"exif:Model": "Boson 640"}, "img_00015.jpg", Sensor.THERMAL),
        ({"exif:Model": "Hadron 640R EO"}, "img_00015.jpg", Sensor.WIDE),
        ({"exif:Model": "EVO II"}, "MAX_0001.jpg", None),
    ],
)
def test_sensors(tags: dict[str, object], name: str, expected: Sensor | None) -> None:
    assert sensor_of(parse_xmp(xmp_packet(tags)), name) is expected


def test_photographs_are_read_from_files(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    write_photograph(path, np.zeros((HEIGHT, WIDTH), np.uint8), exif_block(camera={0xA405: 24}), xmp_packet(DJI))
    tag = read_geotag(path)
    assert (tag.width_px, tag.height_px) == (WIDTH, HEIGHT)
    assert tag.latitude_deg == 48.3069
    assert tag.focal_px == pytest.approx(24.0 / math.hypot(36, 24) * DIAGONAL_PX)


@pytest.mark.parametrize("content", [b"", b"text", b"\xff\xd8\xff\xe1\x00\x08Exif\x00\x00", b"\xff\xd8\xff\xd9"])
def test_files_that_are_no_images_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(content)
    with pytest.raises(InputDataError, match="not a readable image"):
        read_geotag(path)


def test_a_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(extras.importlib, "import_module", absent)
    with pytest.raises(ConfigurationError, match=r"needs PIL.*pip install 'aos-gcs\[geo\]'"):
        read_geotag(tmp_path / "photo.jpg")


NOON_UTC_S = 1_795_176_000.25
"""2026-11-20 12:00:00.25 UTC."""


@pytest.mark.parametrize(
    ("camera", "gps", "expected"),
    [
        ({0x9003: "2026:11:20 14:00:00", 0x9011: "+02:00", 0x9291: "25"}, {}, NOON_UTC_S),
        ({0x9003: "2026:11:20 14:00:00"}, {29: "2026:11:20", 7: (12, 0, 0.25)}, NOON_UTC_S),
        ({0x9003: "2026:11:20 14:00:00", 0x9291: "25"}, {}, None),
        ({0x9003: "0000:00:00 00:00:00", 0x9011: "+02:00"}, {29: "yesterday", 7: (12, 0, 0)}, None),
        ({}, {29: "2026:11:20", 7: (12, 0)}, None),
    ],
)
def test_the_time_is_known_where_its_zone_is(
    camera: dict[int, Any], gps: dict[int, Any], expected: float | None
) -> None:
    class Tags:
        def get(self, _tag: int) -> None:
            return None

        def get_ifd(self, tag: int) -> dict[int, Any]:
            return camera if tag == 0x8769 else gps

    assert exif_tags(Tags(), WIDTH).utc_s == (None if expected is None else pytest.approx(expected))


def test_a_packet_of_the_zenmuse_xt_s_is_read() -> None:
    """The packet declares a namespace twice, and its last instruction is cut off."""
    namespace = b'xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/"'
    packet = xmp_packet(DJI).replace(namespace, namespace + b"\n" + namespace)
    assert parse_xmp(packet[:-1] + b"\0\0") == parse_xmp(xmp_packet(DJI))


def test_a_packet_that_gdal_has_copied_is_read() -> None:
    assert parse_xmp(b"xml:XMP=" + xmp_packet(DJI)) == parse_xmp(xmp_packet(DJI))


def test_values_that_no_aircraft_has_are_refused() -> None:
    """A single photograph is left out by them; the others are used."""
    with pytest.raises(InputDataError, match="nested too deeply"):
        parse_xmp(xmp_packet(DJI, "<a>" * 9000 + "</a>" * 9000))
    for name in ("AbsoluteAltitude", "RelativeAltitude"):
        with pytest.raises(InputDataError, match=rf"its {name}, 1e\+308 m, is not a plausible altitude"):
            tag_of(xmp_packet(DJI | {f"drone-dji:{name}": "1e308"}))
    sigmas = {f"drone-dji:RtkStd{axis}": "1e300" for axis in ("Lat", "Lon", "Hgt")}
    assert tag_of(xmp_packet(DJI | sigmas)).position_sigma_m is None
