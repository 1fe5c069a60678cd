"""Geotagged pictures and the folder for ADIAT: what is written is read back by others."""

from __future__ import annotations

import asyncio
import errno
import io
import json
import math
import os
import shutil
import subprocess
from ast import literal_eval
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from defusedxml import ElementTree
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from aos_gcs.exports.adiat import FILE_NAME, AdiatImage, InterestArea, adiat_document
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geotags.attitude import R_cam2enu_of_gimbal
from aos_gcs.geotags.photo import read_geotag
from aos_gcs.geotags.writing import PhotoTag, tagged_jpeg
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, FindingStatus
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.command_line import exit_status
from tests.fakes.handed_over import FOUND, snapshot_of
from tests.fakes.mission import ORIGIN
from tests.fakes.viewed_step import CAMERA, CAMERAS_EAST_M, FLYING_HEIGHT_M, record_viewed_step

PICTURE = np.full((48, 64, 3), 90, dtype=np.uint8)
SPOT = replace(
    FOUND,
    position_enu_m=(0.0, 0.0, 0.0),
    step=1,
    status=FindingStatus.CONFIRMED,
    operator="Robin",
    ellipse=ErrorEllipse(1.0, 0.5, math.radians(30.0)),
    person_confidence=0.9,
    comment="<b>left</b> of the path \x00",
)
MARKED = replace(
    SPOT, finding_id=2, track_id=None, step=0, position_enu_m=(20.0, 5.0, 0.0), ellipse=ErrorEllipse(90.0, 9.0, 0.0)
)
REJECTED = replace(SPOT, finding_id=3, status=FindingStatus.REJECTED, position_enu_m=(1.0, -2.0, 0.0))


def tag_at(latitude_deg: float = -33.5, longitude_deg: float = 14.3, altitude_m: float = 312.4) -> PhotoTag:
    position = GeodeticPosition(latitude_deg, longitude_deg, altitude_m)
    return PhotoTag(position, 35.25, R_cam2enu_of_gimbal(120.0, -80.0, 5.0), 71.5, "Frame", 1_777_800_000.123, 0.4)


@given(
    st.floats(-89.9, 89.9).filter(lambda angle: abs(angle) > 1e-6),
    st.floats(-180.0, 180.0),
    st.floats(-400.0, 8000.0),
    st.tuples(st.floats(-180.0, 180.0), st.floats(-90.0, 90.0), st.floats(-180.0, 180.0)),
)
@settings(max_examples=40, deadline=None)
def test_a_geotag_is_read_back(
    latitude_deg: float, longitude_deg: float, altitude_m: float, angles_deg: tuple[float, float, float]
) -> None:
    R_cam2enu = R_cam2enu_of_gimbal(*angles_deg)
    tag = replace(tag_at(latitude_deg, longitude_deg, altitude_m), R_cam2enu=R_cam2enu)
    read = read_geotag(io.BytesIO(tagged_jpeg(PICTURE, tag)))
    assert read.latitude_deg == pytest.approx(latitude_deg, abs=1e-8)
    assert read.longitude_deg == pytest.approx(longitude_deg, abs=1e-8)
    assert read.altitude_amsl_m == pytest.approx(altitude_m, abs=1e-3)
    assert (read.relative_altitude_m, read.focal_px, read.width_px) == (35.25, pytest.approx(71.5), 64)
    assert read.utc_s == pytest.approx(tag.utc_s, abs=1e-3)
    np.testing.assert_allclose(read.R_cam2enu, R_cam2enu, atol=1e-5)


def test_exif_alone_says_the_same() -> None:
    with Image.open(io.BytesIO(tagged_jpeg(PICTURE, tag_at()))) as image:
        exif = image.getexif()
    places = exif.get_ifd(0x8825)
    degrees, minutes, seconds = map(float, places[2])
    assert (places[1], places[3]) == ("S", "E")
    assert degrees + minutes / 60.0 + seconds / 3600.0 == pytest.approx(33.5, abs=1e-9)
    assert float(places[6]) == pytest.approx(312.4)
    assert float(places[31]) == pytest.approx(0.4)
    assert exif[0x010F] == "aos-gcs"
    camera = exif.get_ifd(0x8769)
    per_width = float(camera[0x920A]) / (64 / float(camera[0xA20E]) * 10.0)
    assert per_width == pytest.approx(71.5 / 64, rel=1e-4)


@pytest.mark.skipif(shutil.which("exiftool") is None, reason="exiftool is not installed")
def test_exiftool_finds_nothing_wrong(tmp_path: Path) -> None:
    (tmp_path / "picture.jpg").write_bytes(tagged_jpeg(PICTURE, tag_at()))
    command = ["exiftool", "-json", "-n", "-validate", "-GPSLatitude", "-FOV", str(tmp_path / "picture.jpg")]
    (told,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)  # noqa: S603 - a fixed command
    assert told["Validate"] == "0 0 0"
    assert told["GPSLatitude"] == pytest.approx(-33.5, abs=1e-8)
    assert told["FOV"] == pytest.approx(math.degrees(2 * math.atan(32 / 71.5)), rel=0.03)


# --- ADIAT_Data.xml


def test_areas_have_their_ellipses_and_any_comment() -> None:
    area = InterestArea((100.0, 50.0), 40.0, 20.0, math.radians(90.0), 'a "<b>"\x00 &', 0.25, True, False)
    root = ElementTree.fromstring(
        adiat_document([AdiatImage("findings/1.jpg", (area,), True), AdiatImage("frames/2.jpg")])
    )
    shown, other = root.findall("images/image")
    assert (shown.get("hidden"), other.get("path"), len(other)) == ("True", "frames/2.jpg", 0)
    attributes = shown[0].attrib
    assert literal_eval(attributes["center"]) == (100, 50)
    assert (int(attributes["radius"]), attributes["flagged"], float(attributes["confidence"])) == (40, "True", 25.0)
    assert attributes["user_comment"] == 'a "<b>"\ufffd &'
    contour = np.array(literal_eval(attributes["contour"]))
    # The major axis heads east, to the right.
    assert tuple(np.ptp(contour, axis=0)) == (80, 40)
    assert tuple(contour[0]) == (140, 50)


# --- command


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = asyncio.run(record_viewed_step(tmp_path_factory.mktemp("missions")))
    asyncio.run(_with_findings(folder, (SPOT, MARKED, REJECTED)))
    return folder


async def _with_findings(folder: Path, findings: tuple[Finding, ...]) -> None:
    with MissionReader(folder) as reader:
        (event,) = reader.events()
    shown = replace(snapshot_of(event), findings=findings)
    async with MissionRecorder.reopen(folder, 1, notify=lambda _: None) as recorder:
        await recorder.record_event(replace(event, seq=2, data=shown))


def run(*arguments: object) -> int:
    return exit_status(["export", *arguments])


@pytest.fixture(scope="module")
def exported(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("out") / "adiat"
    assert run(folder, "--adiat", out) == 0
    return out


def test_every_finding_is_an_area_in_the_middle_of_a_picture_at_its_place(exported: Path) -> None:
    frame = LocalFrame(ORIGIN)
    images = ElementTree.parse(exported / FILE_NAME).getroot().findall("images/image")
    areas = {image.attrib["path"]: image[0].attrib for image in images if len(image)}
    expected = {"001_thermal.jpg": SPOT, "002_no_picture.jpg": MARKED, "003_thermal.jpg": REJECTED}
    assert {Path(path).name for path in areas} == set(expected)
    for path, area in areas.items():
        finding, tag = expected[Path(path).name], read_geotag(exported / path)
        east_m, north_m, _ = frame.to_enu(GeodeticPosition(tag.latitude_deg, tag.longitude_deg, 0.0))
        assert (east_m, north_m) == pytest.approx(finding.position_enu_m[:2], abs=0.01)
        u, v = literal_eval(area["center"])
        assert (u, v) == pytest.approx(((tag.width_px - 1) / 2, (tag.height_px - 1) / 2), abs=0.5)
        np.testing.assert_allclose(tag.R_cam2enu, nadir_pose((0, 0, 0)).R_cam2enu, atol=1e-6)
        assert int(area["radius"]) <= tag.width_px / 2
        assert area["user_comment"].startswith(f"Finding {finding.finding_id}: ")
    assert all((exported / image.attrib["path"]).is_file() for image in images)
    hidden = {Path(image.attrib["path"]).name for image in images if image.get("hidden") == "True"}
    assert hidden == {"003_thermal.jpg", "003_integral.jpg"}


def test_the_area_is_the_ellipse_in_its_size_and_direction(exported: Path) -> None:
    images = ElementTree.parse(exported / FILE_NAME).getroot().findall("images/image")
    area = next(image[0] for image in images if image.get("path") == "findings/001_thermal.jpg")
    with Image.open(exported / "findings/001_thermal.jpg") as picture:
        pixels_per_m = picture.width / 12.0
    contour = np.array(literal_eval(area.attrib["contour"])) - literal_eval(area.attrib["center"])
    major_px = 2.4477 * pixels_per_m
    assert np.linalg.norm(contour, axis=1).max() == pytest.approx(major_px, abs=1.5)
    # The major axis heads 30 degrees from the upper edge to the right; v is down.
    assert tuple(contour[0]) == pytest.approx((0.5 * major_px, -math.cos(math.radians(30.0)) * major_px), abs=1.5)


def test_frames_have_the_poses_of_their_cameras(exported: Path) -> None:
    frame = LocalFrame(ORIGIN)
    paths = sorted((exported / "frames").glob("*_colour.jpg"))
    assert len(paths) == len(CAMERAS_EAST_M) == len(list((exported / "frames").glob("*_thermal.jpg")))
    for path, camera_east_m in zip(paths, CAMERAS_EAST_M, strict=True):
        tag = read_geotag(path)
        place = GeodeticPosition(tag.latitude_deg, tag.longitude_deg, tag.altitude_amsl_m or 0.0)
        assert tuple(frame.to_enu(place)) == pytest.approx((camera_east_m, 0.0, FLYING_HEIGHT_M), abs=0.01)
        assert tag.relative_altitude_m == pytest.approx(FLYING_HEIGHT_M, abs=0.01)
        assert tag.camera().fx_px == pytest.approx(CAMERA.fx_px, rel=1e-5)
    assert {path.name for path in (exported / "integrals").iterdir()} == {"00001_integral.jpg", "00001_thermal.jpg"}


def test_a_folder_that_holds_something_is_left_alone(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine").write_text("mine")
    assert run(folder, "--adiat", tmp_path) == 2
    assert "is not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


def test_a_full_disk_leaves_nothing(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(_path: Path, _content: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    assert run(folder, "--adiat", tmp_path / "out") == 2
    assert "No space left on device" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ["geojson", "kml", "gpx"])
def test_findings_are_written_as_files(folder: Path, tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"findings.{suffix}"
    assert run(folder, "--findings", out) == 0
    assert out.read_text(encoding="utf-8").count("Finding ") == 3


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (lambda _: [], "Nothing to write"),
        (lambda path: ["--findings", path / "findings.shp"], "--findings: .shp is not among"),
        (lambda path: ["--adiat", path / "missing" / "file" / "x"], "Cannot write"),
        (lambda path: ["--findings", path / "f.kml", "--adiat", "/proc"], "is not empty"),
        (lambda path: ["--findings", path / "f.kml", "--wall", path / "missing" / "w.mp4"], "does not exist"),
        (lambda path: ["--findings", path / "f.kml", "--wall", path / "w.mp4", "--tiles", "77.thermal"], "77.thermal"),
        (lambda path: ["--findings", path / "w.mp4", "--wall", path / "w.mp4"], "named for two results"),
    ],
)
def test_what_cannot_be_written_is_refused(
    folder: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: Callable[[Path], list[object]],
    reason: str,
) -> None:
    assert run(folder, *arguments(tmp_path)) == 2
    assert reason in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_folder_for_adiat_that_holds_another_result_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(folder, "--adiat", tmp_path, "--findings", tmp_path / "findings.kml") == 2
    assert "another result lies in it" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_where_the_last_result_cannot_be_made_none_is_written(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_path: Path, _content: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    assert run(folder, "--findings", tmp_path / "findings.kml", "--adiat", tmp_path / "out") == 2
    assert not list(tmp_path.iterdir())
