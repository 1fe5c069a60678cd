"""The simulated camera component and its image file."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import R_cam2enu_from_mavlink, nadir_pose
from aos_sim.camera.component import MAX_PENDING
from aos_sim.camera.image import encode_tiff
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.errors.sensor import RenderedFrame

ACCEPTED, DENIED, BUSY = (
    mavlink.MAV_RESULT_ACCEPTED,
    mavlink.MAV_RESULT_DENIED,
    mavlink.MAV_RESULT_TEMPORARILY_REJECTED,
)
START, STOP, REQUEST = (
    mavlink.MAV_CMD_IMAGE_START_CAPTURE,
    mavlink.MAV_CMD_IMAGE_STOP_CAPTURE,
    mavlink.MAV_CMD_REQUEST_MESSAGE,
)
CAMERA = 100


@pytest.fixture
def bench(make_bench):
    return make_bench("arducopter")


def develop_all(bench):
    for exposure in bench.camera.take_exposures():
        bench.camera.image_ready(exposure, bench.vehicle.view(), f"http://127.0.0.1:1/7/{exposure.index}.tiff")
    bench.advance(0.02)


def captured_indices(bench):
    return [m.image_index for m in bench.sent if m.get_type() == "CAMERA_IMAGE_CAPTURED"]


def test_the_pose_is_that_of_the_exposure(bench):
    bench.advance(1.0)
    exposed_at = bench.now
    assert bench.long(START, 0, 0, 1, 1, component=CAMERA) == [ACCEPTED]
    bench.advance(2.0)
    assert captured_indices(bench) == [], "the image is not ready yet"
    develop_all(bench)
    captured = bench.last("CAMERA_IMAGE_CAPTURED")
    assert captured.time_boot_ms == exposed_at.boot_ms
    assert captured.time_utc == exposed_at.utc_us
    assert captured.file_url == "http://127.0.0.1:1/7/0.tiff"
    assert (captured.lat, captured.lon, captured.alt) == (483000000, 143000000, 260000)
    expected = nadir_pose((0, 0, 0), bench.kinematics.heading_rad).R_cam2enu
    np.testing.assert_allclose(R_cam2enu_from_mavlink(captured.q), expected, atol=1e-6)
    assert captured.get_srcComponent() == CAMERA


def test_the_heading_of_the_vehicle_turns_the_image(bench):
    bench.long(START, 0, 0, 1, component=CAMERA)
    develop_all(bench)
    R_cam2enu = R_cam2enu_from_mavlink(bench.last("CAMERA_IMAGE_CAPTURED").q)
    up_in_image_enu = R_cam2enu @ [0.0, -1.0, 0.0]
    assert math.atan2(up_in_image_enu[0], up_in_image_enu[1]) == pytest.approx(0.2)
    assert R_cam2enu @ [0.0, 0.0, 1.0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-6)


def test_a_failed_exposure_is_told_and_is_no_image(bench):
    for sequence in (1, 2):
        bench.long(START, 0, 0, 1, sequence, component=CAMERA)
    lost, kept = bench.camera.take_exposures()
    bench.camera.image_failed(lost)
    bench.camera.image_ready(kept, bench.vehicle.view(), "http://127.0.0.1:1/7/1.tiff")
    bench.advance(0.02)
    told = [(m.image_index, m.capture_result) for m in bench.sent if m.get_type() == "CAMERA_IMAGE_CAPTURED"]
    assert told == [(0, 0), (1, 1)]
    assert bench.camera.image_count == 1


def test_lost_announcement_can_be_asked_for_again(bench):
    for sequence in (1, 2, 3):
        bench.long(START, 0, 0, 1, sequence, component=CAMERA)
    develop_all(bench)
    assert captured_indices(bench) == [0, 1, 2]
    bench.sent.clear()
    assert bench.long(REQUEST, mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, 1, component=CAMERA) == [ACCEPTED]
    assert captured_indices(bench) == [1]
    assert bench.long(REQUEST, mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, 3, component=CAMERA) == [DENIED]


@pytest.mark.parametrize(
    ("first", "last", "announced"),
    [(1, 3, [1, 2, 3]), (2, -1, [2, 3]), (-1, 0, [0, 1, 2, 3]), (3, 0, [3]), (3, 9, [3])],
)
def test_lost_announcements_can_be_asked_for_as_a_range(bench, first, last, announced):
    for sequence in (1, 2, 3, 4):
        bench.long(START, 0, 0, 1, sequence, component=CAMERA)
    develop_all(bench)
    bench.sent.clear()
    message_id = mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED
    assert bench.long(REQUEST, message_id, first, last, component=CAMERA) == [ACCEPTED]
    assert captured_indices(bench) == announced


def test_an_interval_leaves_images_out_while_two_are_being_developed(bench):
    bench.long(START, 0, 0.2, 0, component=CAMERA)
    bench.advance(3.0)
    assert [exposure.index for exposure in bench.camera.take_exposures()] == [0, 1]


def test_retransmitted_command_takes_one_image(bench):
    assert bench.long(START, 0, 0, 1, 5, component=CAMERA) == [ACCEPTED]
    assert bench.long(START, 0, 0, 1, 5, component=CAMERA) == [ACCEPTED]
    assert len(bench.camera.take_exposures()) == 1
    bench.advance(6.0)
    bench.long(START, 0, 0, 1, 5, component=CAMERA)
    assert len(bench.camera.take_exposures()) == 1, "long after, the same number is a new command"


def test_camera_is_busy_while_too_many_images_wait(bench):
    for sequence in range(1, MAX_PENDING + 1):
        assert bench.long(START, 0, 0, 1, sequence, component=CAMERA) == [ACCEPTED]
    assert bench.long(START, 0, 0, 1, 99, component=CAMERA) == [BUSY]
    develop_all(bench)
    assert bench.long(START, 0, 0, 1, 99, component=CAMERA) == [ACCEPTED], "the refused one may be sent again"


def test_interval_takes_its_number_of_images(bench):
    assert bench.long(START, 0, 0.5, 3, component=CAMERA) == [ACCEPTED]
    for _ in range(40):
        bench.advance(0.1)
        develop_all(bench)
    assert captured_indices(bench) == [0, 1, 2]
    times = [m.time_boot_ms for m in bench.sent if m.get_type() == "CAMERA_IMAGE_CAPTURED"]
    assert np.diff(times).tolist() == [500, 500]


def test_endless_interval_stops_on_command(bench):
    bench.long(START, 0, 0.2, 0, component=CAMERA)
    bench.advance(0.5)
    status = bench.send(
        mavlink.MAVLink_command_long_message(7, CAMERA, mavlink.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS, 0, *[1.0] * 7)
    )
    assert next(m for m in status if m.get_type() == "CAMERA_CAPTURE_STATUS").image_status == 3
    assert bench.long(START, 0, 0.2, 0, component=CAMERA) == [ACCEPTED], "the same command again"
    assert bench.long(START, 0, 0.3, 0, component=CAMERA) == [BUSY]
    assert bench.long(START, 0, 0, 1, 9, component=CAMERA) == [BUSY], "no single image meanwhile"
    assert bench.long(STOP, component=CAMERA) == [ACCEPTED]
    develop_all(bench)
    taken = len(captured_indices(bench))
    bench.advance(2.0)
    develop_all(bench)
    assert len(captured_indices(bench)) == taken > 0
    assert bench.long(START, 0, 0, 0, component=CAMERA) == [DENIED], "an interval needs a period"


def test_information_agrees_with_the_field_of_view(bench):
    for command, params in (
        (REQUEST, (mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION,)),
        (mavlink.MAV_CMD_REQUEST_CAMERA_INFORMATION, (1,)),
    ):
        assert bench.long(command, *params, component=CAMERA) == [ACCEPTED]
        information = bench.last("CAMERA_INFORMATION")
        fov_rad = 2 * math.atan(information.sensor_size_h / 2 / information.focal_length)
        assert fov_rad == pytest.approx(0.9, abs=1e-5)
        assert information.sensor_size_v / information.sensor_size_h == pytest.approx(48 / 64)
        assert (information.resolution_h, information.resolution_v) == (64, 48)


def test_camera_commands_to_all_components_are_answered_once(bench):
    assert bench.long(START, 0, 0, 1, 1, component=0) == [ACCEPTED]
    assert bench.long(START, 0, 0, 1, 1, component=1) == [mavlink.MAV_RESULT_UNSUPPORTED]
    assert bench.long(REQUEST, mavlink.MAVLINK_MSG_ID_SYS_STATUS, component=0) == [ACCEPTED]


def test_tiff_has_colour_and_radiometric_pages():
    rgb = np.zeros((6, 8, 3), np.uint8)
    rgb[..., 0] = 200
    thermal = np.linspace(-20.0, 60.0, 48, dtype=np.float32).reshape(6, 8)
    data = encode_tiff(RenderedFrame(rgb, thermal))
    decoded, (colour, temperature) = cv2.imdecodemulti(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded
    assert colour[0, 0].tolist() == [0, 0, 200], "red, in OpenCV's order"
    assert temperature.dtype == np.uint16
    np.testing.assert_allclose(temperature / 100.0 - 273.15, thermal, atol=0.006)


def test_pattern_is_fixed_to_the_ground():
    camera = CameraModel.from_fov(101, 101, 0.9)
    source = CheckerboardGround()
    pose = nadir_pose((1.0, 1.0, 20.0))
    view = source.view(pose, camera, 0.0)
    assert view[50, 50, 3] == 15.0
    two_metres_px = round(2.0 / 20.0 * camera.fx_px)
    assert view[50, 50 + two_metres_px, 3] == 20.0
