"""Cameras beside a vehicle: its pose from its messages, exposures, and whose messages they are."""

from __future__ import annotations

import logging
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import R_cam2enu_from_mavlink, nadir_pose
from aos_sim.attached.camera import POSE_WAIT_S, AttachedCamera
from aos_sim.attached.pose_track import MAX_GAP_S, PoseTrack, TimedPose
from aos_sim.attached.requests import PoseRequests
from aos_sim.attached.senders import SILENT_S, Sender, SenderTable
from aos_sim.attached.service import AttachedOptions
from aos_sim.attached.telemetry import PoseTelemetry
from aos_sim.packets import Packer, Parser
from aos_sim.vehicle.telemetry import body_quaternion

VEHICLE, CAMERA, GCS = 3, 100, 254
ARDUPILOT, PX4 = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_AUTOPILOT_PX4
POSITION, HOME_MESSAGE = mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, mavlink.MAVLINK_MSG_ID_HOME_POSITION
HOME = GeodeticPosition(48.3, 14.3, 260.0)
FRAME = LocalFrame(HOME)


def belief(boot_s: float, east_m: float = 0.0, up_m: float = 0.0, heading_deg: float = 0.0):
    place = FRAME.to_geodetic((east_m, 0.0, up_m))
    return mavlink.MAVLink_global_position_int_message(
        round(boot_s * 1e3),
        round(place.latitude_deg * 1e7),
        round(place.longitude_deg * 1e7),
        round(place.altitude_amsl_m * 1e3),
        round(up_m * 1e3),
        0,
        0,
        0,
        round(heading_deg * 100),
    )


def sim_state(east_m: float, up_m: float, yaw_rad: float):
    place = FRAME.to_geodetic((east_m, 0.0, up_m))
    e7 = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    q = body_quaternion(0.0, 0.0, yaw_rad)
    return mavlink.MAVLink_sim_state_message(
        *q, 0, 0, yaw_rad, *[0.0] * 6, *e7, place.altitude_amsl_m, *[0.0] * 5, lat_int=e7[0], lon_int=e7[1]
    )


def hil_state(east_m: float, up_m: float, yaw_rad: float):
    place = FRAME.to_geodetic((east_m, 0.0, up_m))
    e7 = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    # Tilted on purpose: only the heading counts for a camera in a gimbal.
    q = body_quaternion(0.3, -0.2, yaw_rad)
    return mavlink.MAVLink_hil_state_quaternion_message(
        0, q, 0, 0, 0, *e7, round(place.altitude_amsl_m * 1e3), *[0] * 8
    )


def home_position():
    e7 = round(HOME.latitude_deg * 1e7), round(HOME.longitude_deg * 1e7)
    return mavlink.MAVLink_home_position_message(*e7, round(HOME.altitude_amsl_m * 1e3), 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)


# --- poses -----------------------------------------------------------------------------------------------------------


def pose(at_s: float, east_m: float = 0.0, heading_rad: float = 0.0) -> TimedPose:
    return TimedPose(at_s, FRAME.to_geodetic((east_m, 0.0, 10.0)), heading_rad)


@given(share=st.floats(0.0, 1.0), start_rad=st.floats(0.0, 6.28), turn_rad=st.floats(-3.1, 3.1))
def test_between_two_poses_the_vehicle_moves_and_turns_evenly_the_short_way(share, start_rad, turn_rad):
    track = PoseTrack()
    track.add(pose(5.0, 0.0, start_rad))
    track.add(pose(5.5, 4.0, (start_rad + turn_rad) % (2 * math.pi)))
    between = track.at(5.0 + share * 0.5)
    assert FRAME.to_enu(between.position)[0] == pytest.approx(4.0 * share, abs=1e-3)
    difference = between.heading_rad - (start_rad + share * turn_rad)
    assert math.cos(difference) == pytest.approx(1.0, abs=1e-9)
    assert 0.0 <= between.heading_rad <= 2 * math.pi


def test_no_pose_before_the_first_after_the_last_or_in_a_gap():
    track = PoseTrack()
    for at_s in (1.0, 1.2, 1.2, 1.1, 1.4 + MAX_GAP_S):
        track.add(pose(at_s))
    assert track.at(0.99) is None
    assert track.at(1.1) is not None
    assert track.at(1.3) is None
    assert track.at(1.5 + MAX_GAP_S) is None
    assert track.at(1.0).at_s == 1.0


@pytest.mark.parametrize("truth", [sim_state, hil_state])
def test_the_true_pose_is_kept_apart_from_the_believed_one(truth):
    telemetry = PoseTelemetry()
    for tick in range(5):
        telemetry.hear(belief(100.0 + tick * 0.1, east_m=tick, up_m=20.0, heading_deg=350.0), 7.0 + tick * 0.1)
        telemetry.hear(truth(east_m=tick + 0.5, up_m=21.0, yaw_rad=-0.1), 7.0 + tick * 0.1)
    at = telemetry.pose_at(100.25)
    assert FRAME.to_enu(at.believed.position) == pytest.approx([2.5, 0.0, 20.0], abs=0.02)
    assert FRAME.to_enu(at.true.position) == pytest.approx([3.0, 0.0, 21.0], abs=0.02)
    assert at.believed.relative_altitude_m == pytest.approx(20.0, abs=0.01)
    assert at.believed.heading_rad == pytest.approx(math.radians(350.0))
    assert at.true.heading_rad == pytest.approx(2 * math.pi - 0.1, abs=1e-6)


def test_a_vehicle_without_a_true_pose_is_where_it_believes_to_be():
    telemetry = PoseTelemetry()
    telemetry.hear(belief(1.0, east_m=1.0), 0.0)
    telemetry.hear(belief(1.2, east_m=3.0), 0.2)
    at = telemetry.pose_at(1.1)
    assert at.true.position == at.believed.position


def test_a_true_pose_that_falls_silent_is_not_replaced_by_the_belief():
    telemetry = PoseTelemetry()
    telemetry.hear(belief(1.0), 0.0)
    telemetry.hear(sim_state(0.0, 0.0, 0.0), 0.0)
    for tick in range(1, 40):
        telemetry.hear(belief(1.0 + tick * 0.1), tick * 0.1)
    assert telemetry.pose_at(3.0) is None


def test_a_true_pose_after_a_pause_is_not_taken_to_be_of_the_future():
    telemetry = PoseTelemetry()
    telemetry.hear(belief(1.0), 0.0)
    telemetry.hear(sim_state(0.0, 0.0, 0.0), 0.0)
    telemetry.hear(sim_state(1.0, 0.0, 0.0), 3.0)
    for tick in range(1, 20):
        telemetry.hear(belief(1.0 + tick * 0.1), 3.0)
        telemetry.hear(sim_state(2.0, 0.0, 0.0), 3.0)
    assert telemetry.pose_at(2.0) is not None


def test_positions_that_mean_unknown_are_no_poses():
    telemetry = PoseTelemetry()
    telemetry.hear(mavlink.MAVLink_global_position_int_message(1000, 0, 0, 0, 0, 0, 0, 0, 65535), 0.0)
    assert telemetry.vehicle_time_s(0.0) is None
    telemetry.hear(mavlink.MAVLink_home_position_message(0, 0, 0, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0), 0.0)
    assert telemetry.home is None


def test_a_restart_forgets_the_poses_of_the_time_before():
    telemetry = PoseTelemetry()
    for boot_s in (500.0, 500.1, 2.0, 2.1):
        telemetry.hear(belief(boot_s), boot_s)
    assert telemetry.pose_at(500.05) is None
    assert telemetry.pose_at(2.05) is not None


def test_after_a_restart_the_truth_is_waited_for():
    telemetry = PoseTelemetry()
    telemetry.hear(belief(500.0), 0.0)
    telemetry.hear(sim_state(0.0, 0.0, 0.0), 0.0)
    for boot_s in (2.0, 2.1, 2.2):
        telemetry.hear(belief(boot_s), boot_s)
    assert telemetry.pose_at(2.05) is None


# --- requests --------------------------------------------------------------------------------------------------------


def asked(commands) -> list[int]:
    return [round(command.param1) for command in commands]


@pytest.mark.parametrize(
    ("autopilot", "truth"),
    [(ARDUPILOT, mavlink.MAVLINK_MSG_ID_SIM_STATE), (PX4, mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION)],
)
def test_poses_are_asked_for_until_they_come_and_the_truth_a_few_times(autopilot, truth):
    requests = PoseRequests(VEHICLE, autopilot)
    assert asked(requests.due(0.0)) == [POSITION, HOME_MESSAGE]
    assert requests.due(1.0) == []
    requests.hear(HOME_MESSAGE, 1.5)
    told = []
    for now_s in range(2, 30):
        requests.hear(POSITION, float(now_s))
        told += asked(requests.due(float(now_s)))
    assert told == [truth] * 5
    assert [asked(requests.due(float(now_s))) for now_s in (32, 33, 34)] == [[POSITION], [], [POSITION]]


def test_a_vehicle_that_comes_back_is_asked_for_its_truth_again():
    requests = PoseRequests(VEHICLE, PX4)
    truth = mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
    requests.hear(HOME_MESSAGE, 0.0)
    for start_s in range(0, 200, 20):
        told = []
        for now_s in range(start_s, start_s + 10):
            requests.hear(POSITION, float(now_s))
            told += asked(requests.due(float(now_s)))
            if told:
                requests.hear(truth, float(now_s))
        assert told == [truth]
        assert all(truth not in asked(requests.due(float(now_s))) for now_s in range(start_s + 12, start_s + 20))


# --- the camera ------------------------------------------------------------------------------------------------------


class Bench:
    """A camera beside a vehicle that flies east at 2 m/s, 20 m high, and is really 1 m farther north."""

    def __init__(self) -> None:
        self.camera = AttachedCamera(
            VEHICLE, PX4, CameraModel.from_fov(32, 32, 0.9), start_utc_us=1_700_000_000_000_000
        )
        self.now_s = 0.0
        self.sent: list = []
        self._parser = Parser()
        self._gcs = Packer(GCS, 190)

    def fly(self, seconds: float, telling: bool = True) -> None:
        for _ in range(round(seconds / 0.05)):
            self.now_s += 0.05
            if telling:
                self.camera.hear(belief(90.0 + self.now_s, east_m=2.0 * self.now_s, up_m=20.0), self.now_s)
            self.camera.poll(self.now_s)
            self.sent += self._parser.feed(self.camera.drain())

    def command(self, command: int, *params: float, system: int = VEHICLE, component: int = CAMERA) -> None:
        message = mavlink.MAVLink_command_long_message(
            system, component, command, 0, *params, *[0.0] * (7 - len(params))
        )
        for parsed in Parser().feed(self._gcs.pack(message)):
            self.camera.command(parsed, self.now_s)

    def shoot(self, sequence: int = 1, **target: int) -> None:
        self.command(mavlink.MAV_CMD_IMAGE_START_CAPTURE, 0, 0, 1, sequence, **target)

    def of_kind(self, name: str) -> list:
        return [message for message in self.sent if message.get_type() == name]


def test_an_exposure_has_the_pose_of_its_moment_though_it_becomes_known_later():
    bench = Bench()
    bench.fly(1.0)
    bench.now_s += 0.025
    bench.shoot()
    assert bench.camera.take_shots() == []
    bench.fly(0.1)
    (shot,) = bench.camera.take_shots()
    assert FRAME.to_enu(shot.pose.true.position)[0] == pytest.approx(2.0 * 1.025, abs=0.02)
    bench.fly(2.0)
    bench.camera.deliver(shot, "http://127.0.0.1:1/3/0.tiff")
    bench.fly(0.1)
    (ack,) = bench.of_kind("COMMAND_ACK")
    assert (ack.result, ack.target_system, ack.target_component) == (mavlink.MAV_RESULT_ACCEPTED, GCS, 190)
    (captured,) = bench.of_kind("CAMERA_IMAGE_CAPTURED")
    assert (captured.get_srcSystem(), captured.get_srcComponent()) == (VEHICLE, CAMERA)
    assert captured.capture_result == 1
    assert captured.time_utc == pytest.approx(1_700_000_001_025_000, abs=20_000)
    assert captured.relative_alt == 20_000
    assert captured.file_url == "http://127.0.0.1:1/3/0.tiff"
    assert R_cam2enu_from_mavlink(captured.q) == pytest.approx(nadir_pose((0, 0, 0)).R_cam2enu, abs=1e-6)


def test_an_exposure_without_a_pose_is_refused_once_and_told(caplog):
    # Whatever the program's own logging was set to before.
    caplog.set_level(logging.WARNING, logger="aos_sim.attached.camera")
    bench = Bench()
    bench.fly(1.0)
    bench.fly(0.5, telling=False)
    bench.shoot()
    bench.fly(POSE_WAIT_S + 0.1, telling=False)
    (captured,) = bench.of_kind("CAMERA_IMAGE_CAPTURED")
    assert (captured.image_index, captured.capture_result, captured.file_url) == (0, 0, "")
    bench.fly(1.0)
    assert bench.camera.take_shots() == []
    assert bench.camera.report().refused == 1
    assert "vehicle 3: image 0 is refused" in caplog.text


def test_a_pause_of_the_program_is_no_silence_of_the_vehicle():
    bench = Bench()
    bench.fly(1.0)
    bench.shoot()
    bench.now_s += POSE_WAIT_S + 0.5
    bench.camera.poll(bench.now_s)
    bench.camera.hear(belief(91.5, up_m=20.0), bench.now_s)
    bench.camera.poll(bench.now_s)
    assert len(bench.camera.take_shots()) == 1


def test_a_vehicle_that_was_never_heard_gives_no_image():
    bench = Bench()
    bench.shoot()
    bench.fly(POSE_WAIT_S + 0.1, telling=False)
    assert [message.capture_result for message in bench.of_kind("CAMERA_IMAGE_CAPTURED")] == [0]


def test_commands_for_others_are_not_answered():
    bench = Bench()
    bench.fly(1.0)
    bench.shoot(system=VEHICLE + 1)
    bench.shoot(component=1)
    bench.fly(0.2)
    assert bench.of_kind("COMMAND_ACK") == []
    assert bench.camera.take_shots() == []


def test_a_lost_announcement_is_repeated_on_request():
    bench = Bench()
    bench.fly(1.0)
    for sequence in (1, 2):
        bench.shoot(sequence)
    bench.fly(0.2)
    for shot in bench.camera.take_shots():
        bench.camera.deliver(shot, f"http://127.0.0.1:1/3/{shot.exposure.index}.tiff")
    bench.fly(0.1)
    bench.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, 1)
    bench.fly(0.1)
    assert [message.image_index for message in bench.of_kind("CAMERA_IMAGE_CAPTURED")] == [0, 1, 1]


def test_the_report_tells_how_far_belief_and_truth_were_apart():
    bench = Bench()
    for tick in range(1, 20):
        now_s = bench.now_s = tick * 0.05
        bench.camera.hear(belief(90.0 + now_s, east_m=1.0, up_m=20.0), now_s)
        bench.camera.hear(hil_state(4.0, 24.0, 0.0), now_s)
        if tick == 10:
            bench.shoot()
    bench.camera.poll(bench.now_s)
    (shot,) = bench.camera.take_shots()
    bench.camera.deliver(shot, "http://127.0.0.1:1/3/0.tiff")
    report = bench.camera.report()
    assert report.tells_true_pose
    assert report.max_position_error_m == pytest.approx(5.0, abs=0.03)


# --- senders ---------------------------------------------------------------------------------------------------------

FIRST, SECOND = Sender(0, ("127.0.0.1", 5762)), Sender(1, ("127.0.0.1", 5772))


def test_a_second_sender_of_an_id_makes_it_ambiguous_for_a_while():
    table = SenderTable()
    assert table.hear(1, FIRST, 0.0)
    assert not table.hear(1, SECOND, 1.0)
    assert table.hear(2, SECOND, 1.0)
    assert table.is_ambiguous(1, 1.0)
    assert not table.is_ambiguous(2, 1.0)
    assert table.hear(1, FIRST, 1.0 + SILENT_S)
    assert not table.is_ambiguous(1, 1.0 + SILENT_S)


def test_a_silent_sender_is_followed_by_another_one():
    table = SenderTable()
    table.hear(1, FIRST, 0.0)
    assert table.hear(1, SECOND, SILENT_S + 0.1)
    assert table.sender_of(1) == SECOND
    assert not table.is_ambiguous(1, SILENT_S + 0.2)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"links": ()}, "--link"),
        ({"links": ("udpout://127.0.0.1:14550",)}, "wait to hear a vehicle"),
        ({"links": ("tcpout:5762",)}, "KIND://HOST:PORT"),
        ({"links": ("udpin://127.0.0.1:14540",), "gcs": "udpin://127.0.0.1:14550"}, "--gcs"),
    ],
)
def test_impossible_options_are_refused(values, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        AttachedOptions(**values)
