"""The number of rally points, which a vehicle may return to, is known only when the vehicle has told it."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.fence.rally import RallyCount

OURS, RALLY = 254, mavlink.MAV_MISSION_TYPE_RALLY


def receipt(kind: int) -> mavlink.MAVLink_message:
    return mavlink.MAVLink_mission_ack_message(OURS, 190, kind, RALLY)


def count(number: int, target: int = OURS) -> mavlink.MAVLink_message:
    return mavlink.MAVLink_mission_count_message(target, 190, number, RALLY)


def test_the_number_ends_the_exchange_with_a_receipt() -> None:
    request = RallyCount(Target(1, 1), OURS)
    assert [one.get_type() for one in request.poll(0.0)] == ["MISSION_REQUEST_LIST"]
    request.on_message(count(7, target=253))
    assert request.count is None
    request.on_message(count(2))
    assert (request.count, [one.get_type() for one in request.poll(0.1)]) == (2, ["MISSION_ACK"])
    assert request.is_done


@pytest.mark.parametrize(
    "kind",
    [
        mavlink.MAV_MISSION_ACCEPTED,
        mavlink.MAV_MISSION_ERROR,
        mavlink.MAV_MISSION_DENIED,
        mavlink.MAV_MISSION_OPERATION_CANCELLED,
    ],
)
def test_a_vehicle_that_is_busy_is_asked_again_and_not_taken_for_one_without_rally_points(kind: int) -> None:
    request = RallyCount(Target(1, 1), OURS)
    request.poll(0.0)
    request.on_message(receipt(kind))
    assert (request.count, request.is_done) == (None, False)
    assert [one.get_type() for one in request.poll(60.0)] == ["MISSION_REQUEST_LIST"]
    request.on_message(count(1))
    assert request.count == 1


def test_a_vehicle_that_does_not_support_them_has_none() -> None:
    request = RallyCount(Target(1, 1), OURS)
    request.on_message(receipt(mavlink.MAV_MISSION_UNSUPPORTED))
    assert (request.count, request.is_done) == (0, True)
