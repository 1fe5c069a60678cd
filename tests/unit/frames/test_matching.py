"""Files that are the image of an exposure, and what a server's listing or a driver's option table says."""

from __future__ import annotations

import contextlib
import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_drivers.frames.errors import FrameRefusedError
from aos_drivers.frames.files.companion import parse_listing
from aos_drivers.frames.files.matching import FileStamp, WantedImage, choose, is_image_name, newest
from aos_drivers.frames.poses.mount import Carrier
from aos_drivers.frames.settings import SourceKind
from aos_drivers.options import DriverOptions
from aos_gcs.errors import CaptureError, ConfigurationError

OLD = {"00007.jpg": FileStamp(10, 100.0), "00008.jpg": FileStamp(11, 101.0)}


def test_a_file_of_another_flight_with_the_same_index_is_not_taken() -> None:
    wanted = WantedImage(OLD, index=8, file_name="{index:05d}.jpg")
    assert choose(OLD, wanted) is None
    rewritten = OLD | {"00008.jpg": FileStamp(11, 200.0)}
    assert choose(rewritten, wanted) == "00008.jpg"
    assert choose(OLD | {"00009.jpg": FileStamp(9, 200.0)}, wanted) is None


def test_without_an_index_in_the_name_the_only_new_file_is_taken() -> None:
    wanted = WantedImage(OLD, index=3, utc_s=500.0)
    assert choose(OLD, wanted) is None
    assert choose(OLD | {"DSC1.JPG": FileStamp(9, 300.0)}, wanted) == "DSC1.JPG"


def test_of_several_new_files_the_one_of_the_right_time_is_taken_or_none() -> None:
    new = {"a.jpg": FileStamp(9, 300.1), "b.jpg": FileStamp(9, 305.0), "c.jpg": FileStamp(9, None)}
    assert choose(OLD | new, WantedImage(OLD, utc_s=304.8)) == "b.jpg"
    with pytest.raises(FrameRefusedError, match=r"3 new files.*2 of them.*file_name"):
        choose(OLD | new, WantedImage(OLD, utc_s=303.0, tolerance_s=5.0))
    with pytest.raises(FrameRefusedError, match="0 of them"):
        choose(OLD | new, WantedImage(OLD, utc_s=None))


def test_files_of_earlier_exposures_that_are_missing_come_first() -> None:
    first, second = {"a.jpg": FileStamp(9, 305.0)}, {"b.jpg": FileStamp(9, 306.0)}
    wanted = WantedImage(OLD, utc_s=0.0, earlier=1)
    assert choose(OLD | first, wanted) is None
    assert choose(OLD | second | first, wanted) == "b.jpg"
    with pytest.raises(FrameRefusedError, match="2 new files"):
        choose(OLD | first | {"b.jpg": FileStamp(9, 305.0)}, wanted)


def test_the_newest_is_that_written_last() -> None:
    new = {"b.jpg": FileStamp(9, 305.0), "a.jpg": FileStamp(9, 306.0)}
    assert newest(OLD | new, WantedImage(OLD)) == "a.jpg"
    assert newest(OLD, WantedImage(OLD)) is None


@pytest.mark.parametrize(
    "name",
    ["", ".hidden.jpg", "a.jpg.part", "a.tmp", "../a.jpg", "sub/a.jpg", "a\\b.jpg", "/etc/passwd", "a\0.jpg", "jpg"],
)
def test_what_is_no_image_of_this_folder_is_left_out(name: str) -> None:
    assert not is_image_name(name)


HTML = """<html><body><a href="../">up</a><a href="00001.jpg">x</a><a href='DSC%2001.JPG'>y</a>
<a href="http://evil/a.jpg">z</a><a href="/etc/b.jpg">w</a><a href="./c.png">v</a><a>no</a><a href="?C=M">s</a>"""


def test_listings_of_common_servers_are_read() -> None:
    assert set(parse_listing(HTML.encode())) == {"00001.jpg", "DSC 01.JPG", "c.png"}
    nginx = [
        {"name": "a.jpg", "type": "file", "mtime": "Fri, 20 Nov 2026 10:00:02 GMT", "size": 5},
        {"name": "sub", "type": "directory", "mtime": "Fri, 20 Nov 2026 10:00:02 GMT"},
    ]
    assert parse_listing(json.dumps(nginx).encode()) == {"a.jpg": FileStamp(5, 1_795_168_802.0)}
    assert set(parse_listing(b'["a.jpg", "b.txt"]')) == {"a.jpg"}


@pytest.mark.parametrize("data", [b"[1]", b'[{"size": 1}]', b"[", b'[{"name": "a.jpg", "mtime": "yesterday"}]'])
def test_listings_that_make_no_sense_are_named(data: bytes) -> None:
    with pytest.raises(CaptureError, match="listing"):
        parse_listing(data)


@given(st.binary(max_size=300))
def test_any_bytes_are_a_listing_or_a_clear_error(data: bytes) -> None:
    with contextlib.suppress(CaptureError):
        assert all(is_image_name(name) for name in parse_listing(data))


# --- settings --------------------------------------------------------------------------------------------------------


def test_a_vehicles_own_table_changes_single_fields_of_the_common_one() -> None:
    cameras = DriverOptions.parse(
        {
            "camera": {"source": "reported", "folder": "/data/{vehicle_id}", "fov_deg": 60.0, "pose_hz": 20},
            "cameras": {"3": {"source": "video", "url": "rtsp://{host}:8554/main", "carrier": "gimbal", "fov_deg": 30}},
        }
    ).cameras
    with_error = cameras.of(3)
    assert (cameras.of(1).source, cameras.of(1).pose_hz) == (SourceKind.REPORTED, 20.0)
    assert str(cameras.of(7).place.folder_of(7)) == "/data/7"
    assert (with_error.source, with_error.mount.carrier) == (SourceKind.VIDEO, Carrier.GIMBAL)
    assert with_error.fov_rad == pytest.approx(math.radians(30.0))
    assert with_error.mount.yaw_pitch_roll_rad == (0.0, 0.0, 0.0)


def test_a_vehicles_own_field_of_view_replaces_the_common_calibration(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(CALIBRATION))
    cameras = DriverOptions.parse(
        {"camera": {"calibration": str(tmp_path / "camera.json")}, "cameras": {"3": {"fov_deg": 30}}}
    ).cameras
    calibration = cameras.of(1).calibration
    assert calibration is not None
    assert cameras.of(1).clock_offset_s == 0.08
    camera = cameras.of(1).camera(64, 48)
    assert (camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px) == (60.0, 61.0, 33.0, 22.0)
    assert (cameras.of(3).calibration, cameras.of(3).clock_offset_s) == (None, 0.0)
    with pytest.raises(CaptureError, match="which is another shape"):
        cameras.of(1).camera(60, 60)


def test_a_doubtful_calibration_is_used_with_a_warning(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "camera.json"
    options = {"camera": {"calibration": str(path)}}
    path.write_text(json.dumps(CALIBRATION))
    DriverOptions.parse(options)
    assert not caplog.messages
    path.write_text(json.dumps(CALIBRATION | {"doubts": ["Far from the given values: yaw."]}))
    assert DriverOptions.parse(options).cameras.of(1).calibration is not None
    (message,) = caplog.messages
    assert message.startswith("link.options.camera.calibration: The calibration")
    assert message.endswith("is doubtful and was written with --force: Far from the given values: yaw.")


CALIBRATION = {
    "image_width": 64,
    "image_height": 48,
    "camera_matrix": [[60, 0, 33], [0, 61, 22], [0, 0, 1]],
    "boresight_deg": [0, 2, 0],
    "clock_offset_s": 0.08,
}
FOLDER = {"source": "reported", "folder": "/data"}


@pytest.mark.parametrize(
    ("camera", "words"),
    [
        ({"sauce": 1}, r"link\.options\.camera\.sauce is unknown: use .*source"),
        ({"source": "gimbal"}, r"camera\.source must be one of component, reported, photos, video"),
        ({"source": "reported"}, "needs one of folder and url"),
        (FOLDER | {"url": "http://{host}/"}, "needs one of folder and url"),
        ({"source": "reported", "url": "file:///data"}, r"camera\.url must be an address of http"),
        ({"folder": "/data"}, r"camera\.folder has no meaning.*source"),
        ({"source": "photos", "url": "http://{host}/{index}.jpg"}, r"camera\.url must be that of a listing"),
        ({"source": "video", "url": "http://{host}/"}, r"camera\.url must be a stream"),
        ({"source": "video", "url": "/etc/passwd"}, r"camera\.url must be a stream"),
        (FOLDER | {"folder": "/data/{index}"}, r"camera\.folder: .*cannot be filled in: use \{vehicle_id\}"),
        (FOLDER | {"file_name": "{index.real}.jpg"}, "file_name"),
        (FOLDER | {"file_name": "{index!r:>1000000000}.jpg"}, "file_name"),
        (FOLDER | {"file_name": "image.jpg"}, r"camera\.file_name must be a name with \{index\}"),
        (FOLDER | {"carrier": "balloon"}, r"camera\.carrier must be one of body, level, gimbal"),
        (
            FOLDER | {"calibration": "/absent.json"},
            r"camera\.calibration: The camera file /absent\.json cannot be read",
        ),
        (FOLDER | {"calibration": "c", "fov_deg": 50}, "calibration and fov_deg exclude each other"),
        (FOLDER | {"mount_deg": [0, -90]}, r"camera\.mount_deg must be three numbers"),
        (FOLDER | {"lever_arm_m": [0, 0, 100]}, "lever_arm_m must be three numbers of at most 10"),
        (FOLDER | {"trigger": "yes"}, r"camera\.trigger must be true or false"),
        (FOLDER | {"index_offset": 1.5}, r"camera\.index_offset must be a whole number"),
        (FOLDER | {"max_pose_age_s": 0}, r"camera\.max_pose_age_s must be a number of 0\.01 to 10"),
        ("reported", r"link\.options\.camera must be a table"),
    ],
)
def test_options_that_cannot_be_are_named_with_the_remedy(camera: object, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        DriverOptions.parse({"camera": camera})


@pytest.mark.parametrize("cameras", [{"first": {}}, {"0": {}}, {"300": {}}, {"3": "video"}, {"3": {"sauce": 1}}])
def test_tables_of_vehicles_are_named_by_system_ids(cameras: object) -> None:
    with pytest.raises(ConfigurationError, match=r"link\.options\.cameras\."):
        DriverOptions.parse({"cameras": cameras})
