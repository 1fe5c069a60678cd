"""The simulated vehicles' fence: uploaded, told again, and kept."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.vehicle.fence import Fence, is_inside
from aos_sim.vehicle.fence_service import ATTEMPTS, MAX_POINTS

FENCE = mavlink.MAV_MISSION_TYPE_FENCE
INSIDE = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
OUTSIDE = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
SQUARE = ((-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0))
NOTCH = ((10.0, 10.0), (20.0, 10.0), (15.0, 20.0))
ARM, TAKEOFF, SET_MODE = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_DO_SET_MODE,
)
MODES = {"arducopter": {"guided": 4, "return": 6}, "px4": {"hold": 4 << 16 | 3 << 24}}


def items_of(bench, *polygons):
    points = [(command, len(ring), corner) for command, ring in polygons for corner in ring]
    items = []
    for seq, (command, count, corner) in enumerate(points):
        place = bench.frame.to_geodetic((*corner, 0.0))
        x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
        items.append(
            mavlink.MAVLink_mission_item_int_message(7, 1, seq, 0, command, 0, 0, count, 0, 0, 0, x, y, 0.0, FENCE)
        )
    return items


def upload(bench, items):
    """Hand items over as they are asked for; return the result."""
    (reply,) = bench.send(mavlink.MAVLink_mission_count_message(7, 1, len(items), FENCE))
    while reply.get_type() == "MISSION_REQUEST_INT":
        (reply,) = bench.send(items[reply.seq])
    return reply.type


@pytest.fixture(params=["arducopter", "px4"])
def bench(request, make_bench):
    return make_bench(request.param)


def test_a_return_point_is_kept_and_bounds_nothing(bench):
    return_point = mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT
    items = items_of(bench, (return_point, ((0.0, 0.0),)), (INSIDE, SQUARE))
    assert upload(bench, items) == mavlink.MAV_MISSION_ACCEPTED
    (count,) = bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, FENCE))
    assert count.count == 5
    assert len(bench.autopilot.fence_service.inclusions_enu_m) == 1


def test_what_was_uploaded_is_told_again(bench):
    items = items_of(bench, (INSIDE, SQUARE), (OUTSIDE, NOTCH))
    assert upload(bench, items) == mavlink.MAV_MISSION_ACCEPTED
    (count,) = bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, FENCE))
    assert (count.get_type(), count.count) == ("MISSION_COUNT", 7)
    told = [bench.send(mavlink.MAVLink_mission_request_int_message(7, 1, seq, FENCE))[0] for seq in range(7)]
    assert [(i.seq, i.command, i.param1, i.x, i.y) for i in told] == [
        (i.seq, i.command, i.param1, i.x, i.y) for i in items
    ]
    (ack,) = bench.send(mavlink.MAVLink_mission_clear_all_message(7, 1, FENCE))
    assert ack.type == mavlink.MAV_MISSION_ACCEPTED
    assert bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, FENCE))[0].count == 0


def test_missions_are_empty_beside_a_fence(bench):
    upload(bench, items_of(bench, (INSIDE, SQUARE)))
    assert bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, 0))[0].count == 0


def test_a_lost_item_is_asked_for_again_and_then_given_up(bench):
    bench.send(mavlink.MAVLink_mission_count_message(7, 1, 4, FENCE))
    bench.sent.clear()
    bench.advance(ATTEMPTS + 1.0)
    requests = [message for message in bench.sent if message.get_type() == "MISSION_REQUEST_INT"]
    assert [request.seq for request in requests] == [0] * (ATTEMPTS - 1)
    assert bench.last("MISSION_ACK").type == mavlink.MAV_MISSION_OPERATION_CANCELLED


@pytest.mark.parametrize(
    ("polygons", "result"),
    [
        ([(INSIDE, SQUARE * (MAX_POINTS // 4 + 1))], mavlink.MAV_MISSION_NO_SPACE),
        ([(INSIDE, SQUARE[:2])], mavlink.MAV_MISSION_INVALID),
        ([(mavlink.MAV_CMD_NAV_WAYPOINT, SQUARE)], mavlink.MAV_MISSION_INVALID),
    ],
)
def test_what_is_no_fence_is_refused_and_the_old_one_kept(bench, polygons, result):
    assert upload(bench, items_of(bench, (INSIDE, SQUARE))) == mavlink.MAV_MISSION_ACCEPTED
    assert upload(bench, items_of(bench, *polygons)) == result
    assert bench.send(mavlink.MAVLink_mission_request_list_message(7, 1, FENCE))[0].count == 4


def test_an_item_out_of_sequence_does_not_end_the_upload(bench):
    items = items_of(bench, (INSIDE, SQUARE))
    bench.send(mavlink.MAVLink_mission_count_message(7, 1, 4, FENCE))
    bench.send(items[0])
    assert bench.send(items[0])[0].type == mavlink.MAV_MISSION_INVALID_SEQUENCE
    for item in items[1:]:
        (reply,) = bench.send(item)
    assert reply.type == mavlink.MAV_MISSION_ACCEPTED


@pytest.fixture(params=["arducopter", "px4"])
def flying(request, make_flying):
    """A vehicle that hovers 20 m above home and hears its ground station."""
    bench = make_flying(request.param)
    bench.heartbeats_from = 254
    return bench


@pytest.mark.parametrize("place", [(0.0, 60.0), (15.0, 13.0)])
def test_targets_beyond_the_polygons_are_not_flown_to(flying, place):
    bench = flying
    upload(bench, items_of(bench, (INSIDE, SQUARE), (OUTSIDE, NOTCH)))
    answer = bench.reposition(*place, 20.0)
    refused, accepted = mavlink.MAV_RESULT_FAILED, mavlink.MAV_RESULT_ACCEPTED
    assert answer == [refused if bench.flavour == "arducopter" else accepted]
    bench.advance(5.0)
    assert bench.distance_to(0.0, 0.0, 20.0) < 1.0
    bench.reposition(0.0, 30.0, 20.0)
    bench.advance_until(lambda: bench.distance_to(0.0, 30.0, 20.0) < 1.0, 20)


def fence_is_healthy(bench) -> bool:
    health = bench.request(mavlink.MAVLINK_MSG_ID_SYS_STATUS).onboard_control_sensors_health
    return bool(health & mavlink.MAV_SYS_STATUS_GEOFENCE)


@pytest.mark.parametrize("flying", ["arducopter"], indirect=True)
def test_a_copter_that_finds_itself_outside_returns(flying):
    bench = flying
    bench.reposition(0.0, 40.0, 20.0)
    bench.advance_until(lambda: bench.distance_to(0.0, 40.0, 20.0) < 1.0, 20)
    assert fence_is_healthy(bench)
    upload(bench, items_of(bench, (INSIDE, ((-50.0, -50.0), (50.0, -50.0), (0.0, 20.0)))))
    bench.advance(1.0)
    assert not fence_is_healthy(bench)
    assert "Polygon fence breached" in bench.texts()
    assert bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).custom_mode == MODES["arducopter"]["return"]


@pytest.mark.parametrize("flying", ["px4"], indirect=True)
def test_a_px4_that_finds_itself_outside_does_what_its_parameter_says(flying):
    bench = flying
    bench.reposition(0.0, 40.0, 20.0)
    bench.advance(1.5)
    upload(bench, items_of(bench, (INSIDE, ((-50.0, -50.0), (50.0, -50.0), (0.0, 1.0)))))
    bench.advance_until(lambda: "Geofence violation: Polygon" in bench.texts(), 5)
    bench.advance(5.0)
    assert bench.distance_to(0.0, 40.0, 20.0) > 5.0
    assert bench.request(mavlink.MAVLINK_MSG_ID_HEARTBEAT).custom_mode == MODES["px4"]["hold"]


@pytest.mark.parametrize("flavour", ["arducopter", "px4"])
def test_factory_settings_are_parameters_of_the_flavour(make_bench, flavour):
    factory = type(make_bench(flavour).autopilot).FACTORY
    assert make_bench(flavour, **factory).autopilot.fence() == Fence()


@given(
    st.floats(-2.0, 2.0),
    st.floats(-2.0, 2.0),
    st.integers(3, 12),
    st.floats(0.1, 1.9),
)
def test_inside_a_regular_polygon_is_inside_its_incircle(east, north, corners, radius):
    ring = [
        (radius * math.cos(2 * math.pi * k / corners), radius * math.sin(2 * math.pi * k / corners))
        for k in range(corners)
    ]
    distance = math.hypot(east, north)
    if distance < radius * math.cos(math.pi / corners) - 1e-9:
        assert is_inside((east, north), ring)
    elif distance > radius + 1e-9:
        assert not is_inside((east, north), ring)
