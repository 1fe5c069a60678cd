"""Time, message intervals, parameters, links and reports of the simulated vehicles."""

from __future__ import annotations

import json

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError
from aos_sim.camera.synthetic import CheckerboardGround
from aos_sim.clock import Pacer, SimTime
from aos_sim.links import LinkAddress, LinkKind
from aos_sim.report import SeparationMonitor, SwarmReport, write_report
from aos_sim.swarm import SimulatedSwarm, SwarmOptions, home_positions_enu_m
from aos_sim.vehicle.streams import StreamSchedule

ACCEPTED, FAILED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_FAILED


def test_ticks_follow_real_time_times_speed():
    pacer = Pacer(speed=10.0)
    assert pacer.due_ticks(100.0) == 0
    assert pacer.due_ticks(100.1001) == 50
    assert pacer.due_ticks(100.1001) == 0
    assert pacer.delay_s(100.1001) == pytest.approx(0.0019, abs=1e-4)


def test_a_stall_slows_time_instead_of_making_a_burst():
    pacer = Pacer(speed=1.0, max_lag_s=0.25)
    pacer.due_ticks(0.0)
    assert pacer.due_ticks(60.0) == 12
    assert pacer.due_ticks(60.1001) == 5


def test_sim_time_counts_whole_microseconds():
    time = SimTime(3, start_utc_us=1_000_000).later(2)
    assert (time.boot_us, time.boot_ms, time.utc_us, time.s) == (100_000, 100, 1_100_000, 0.1)


def test_stream_intervals():
    streams = StreamSchedule({30: 100_000})
    assert sum(30 in streams.due(tick) for tick in range(1, 51)) == 10
    streams.set_interval(30, 1_000_000, tick=50)
    assert sum(30 in streams.due(tick) for tick in range(51, 151)) == 2
    streams.set_interval(30, -1, tick=150)
    assert streams.interval_us(30) == -1
    streams.set_interval(30, 0, tick=150)
    assert streams.interval_us(30) == 100_000
    streams.set_interval(33, 1, tick=150)
    assert streams.interval_us(33) == 20_000, "one tick is the finest"


def test_message_intervals_by_command(make_bench):
    bench = make_bench("arducopter")
    assert bench.long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 33, 200_000) == [ACCEPTED]
    assert bench.long(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 33) == [ACCEPTED]
    assert bench.last("MESSAGE_INTERVAL").interval_us == 200_000
    bench.sent.clear()
    bench.advance(10)
    assert bench.count("GLOBAL_POSITION_INT") == 50
    assert bench.long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 9999, 200_000) == [FAILED]
    assert bench.long(mavlink.MAV_CMD_REQUEST_MESSAGE, 9999) == [FAILED]


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_every_message_can_be_requested(make_bench, flavour):
    bench = make_bench(flavour)
    for message_id in (*bench.autopilot.MESSAGES, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION):
        assert bench.request(message_id).get_msgId() == message_id
    version = bench.last("AUTOPILOT_VERSION")
    assert version.uid == 1234
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT


def test_arducopter_takes_rates_by_group(make_bench):
    bench = make_bench("arducopter")

    def ask(group: int, rate_hz: int, starts: int) -> None:
        bench.send(mavlink.MAVLink_request_data_stream_message(7, 1, group, rate_hz, starts))
        bench.sent.clear()
        bench.advance(1.0)

    ask(mavlink.MAV_DATA_STREAM_POSITION, 4, 1)
    assert bench.count("GLOBAL_POSITION_INT") == 4
    assert bench.count("ATTITUDE") == 0
    ask(mavlink.MAV_DATA_STREAM_ALL, 2, 1)
    assert (bench.count("GLOBAL_POSITION_INT"), bench.count("ATTITUDE"), bench.count("SYS_STATUS")) == (2, 2, 2)
    ask(mavlink.MAV_DATA_STREAM_ALL, 2, 0)
    assert {message.get_type() for message in bench.sent} <= {"HEARTBEAT", "HOME_POSITION"}


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_requests_for_files_are_refused(make_bench, flavour):
    bench = make_bench(flavour)
    open_file = bytes([5, 0, 9, 4, 3, 0, 0, 0, 0, 0, 0, 0]) + b"abc"
    (answer,) = [
        message
        for message in bench.send(
            mavlink.MAVLink_file_transfer_protocol_message(0, 7, 1, list(open_file.ljust(251, b"\0")))
        )
        if message.get_type() == "FILE_TRANSFER_PROTOCOL"
    ]
    assert (answer.target_system, answer.target_component) == (254, 190)
    assert answer.payload[:6] == [6, 0, 9, 129, 1, 4]
    assert answer.payload[12] == 7


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_parameter_list_is_complete_and_spread_over_ticks(make_bench, flavour):
    bench = make_bench(flavour)
    bench.send(mavlink.MAVLink_param_request_list_message(7, 1))
    bench.advance(0.02)
    assert bench.count("PARAM_VALUE") == 10
    bench.advance(1.0)
    values = [message for message in bench.sent if message.get_type() == "PARAM_VALUE"]
    assert [value.param_index for value in values] == list(range(values[0].param_count))
    assert {value.param_id for value in values} == set(bench.autopilot.parameters.names())


def test_single_parameters_are_read_by_name_and_index(make_bench):
    bench = make_bench("arducopter")
    (by_name,) = bench.send(mavlink.MAVLink_param_request_read_message(7, 1, b"FS_GCS_TIMEOUT", -1))
    assert by_name.param_value == 5.0
    (by_index,) = bench.send(mavlink.MAVLink_param_request_read_message(7, 1, b"", by_name.param_index))
    assert by_index.param_id == "FS_GCS_TIMEOUT"
    assert bench.send(mavlink.MAVLink_param_request_read_message(7, 1, b"", 999)) == []
    assert bench.autopilot.parameters["MAV_SYSID"] == 7


def test_timesync_and_empty_mission(make_bench):
    bench = make_bench("arducopter")
    (reply,) = bench.send(mavlink.MAVLink_timesync_message(0, 12345))
    assert (reply.tc1, reply.ts1) == (bench.now.boot_us * 1000, 12345)
    assert bench.send(mavlink.MAVLink_timesync_message(1, 12345)) == []
    (count,) = bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, 0))
    assert (count.count, count.target_system) == (0, 254)


def test_attitude_quaternion_agrees_with_the_angles(make_bench):
    bench = make_bench("arducopter")
    quaternion = bench.request(mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION)
    assert 2 * np.arctan2(quaternion.q4, quaternion.q1) == pytest.approx(0.2, abs=1e-6)


@pytest.mark.parametrize(
    "url",
    ["", "foo", "udp://127.0.0.1:1", "udpout://127.0.0.1", "udpout://:14550", "udpout://h:99999", "udpin://h:1/x"],
)
def test_bad_links_are_named(url):
    with pytest.raises(ConfigurationError, match="udpout, udpin, tcpout, tcpin"):
        LinkAddress.parse(url)


def test_listening_links_take_a_port_for_each_vehicle():
    assert LinkAddress.parse("udpin://0.0.0.0:5760").for_vehicle(3) == LinkAddress(LinkKind.UDP_IN, "0.0.0.0", 5763)  # noqa: S104
    assert LinkAddress.parse("udpout://localhost:14550").for_vehicle(3).port == 14550


@pytest.mark.parametrize(
    "values",
    [
        {"vehicles": 0},
        {"vehicles": 101},
        {"autopilot": "betaflight"},
        {"speed": 0.0},
        {"links": ()},
        {"image_size_px": 1},
        {"fov_rad": 4.0},
        {"first_system_id": 250, "vehicles": 2},
        {"http_port": 70000},
        {"seed": -1},
    ],
)
def test_impossible_options_are_refused(values):
    with pytest.raises(ConfigurationError):
        SwarmOptions(**values)


def test_unknown_parameter_is_refused():
    with pytest.raises(ConfigurationError, match="NO_SUCH"):
        SimulatedSwarm(SwarmOptions(vehicles=1, parameters={"NO_SUCH": 1.0}), CheckerboardGround())


@pytest.mark.parametrize("count", [1, 10, 37, 100])
def test_homes_are_five_metres_apart_within_the_clearing(count):
    homes = home_positions_enu_m(count)
    assert len(np.unique(homes, axis=0)) == count
    assert homes[:, 1].min() >= -20.0
    assert homes[:, 1].max() <= 8.0
    assert np.abs(homes[:, 0]).max() <= 50.0
    if count > 1:
        monitor = SeparationMonitor()
        monitor.update(range(1, count + 1), homes)
        assert monitor.smallest_m == pytest.approx(5.0)


def test_separation_remembers_the_closest_pair(tmp_path):
    monitor = SeparationMonitor()
    monitor.update([4, 5, 6], np.array([[0.0, 0, 0], [10, 0, 0], [10, 0, 3]]))
    monitor.update([4, 5, 6], np.array([[0.0, 0, 0], [10, 0, 0], [10, 0, 30]]))
    assert (monitor.smallest_m, monitor.pair) == (3.0, (5, 6))
    path = tmp_path / "report.json"
    write_report(path, SwarmReport(1.5, monitor.smallest_m, monitor.pair, landed=3, images=2))
    assert json.loads(path.read_text()) == {
        "sim_time_s": 1.5,
        "min_separation_m": 3.0,
        "min_separation_pair": [5, 6],
        "landed": 3,
        "images": 2,
        "min_height_above_ground_m": None,
    }
    assert list(tmp_path.iterdir()) == [path]
