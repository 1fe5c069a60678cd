"""Rates in the old way, by groups of messages (REQUEST_DATA_STREAM), as ArduPilot still takes them from MAVProxy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_sim.vehicle.streams import OFF

GROUPS: Mapping[int, tuple[int, ...]] = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
    ),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (mavlink.MAVLINK_MSG_ID_ATTITUDE,),
    mavlink.MAV_DATA_STREAM_EXTRA2: (mavlink.MAVLINK_MSG_ID_VFR_HUD,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
    ),
}
"""ArduCopter's groups, as far as the simulated one has their messages."""


def requested_intervals_us(request: mavlink.MAVLink_request_data_stream_message) -> Iterator[tuple[int, int]]:
    """Yield message ids with the intervals in microseconds that a request asks for."""
    starts = request.start_stop == 1 and request.req_message_rate > 0
    interval_us = round(1e6 / request.req_message_rate) if starts else OFF
    everything = request.req_stream_id == mavlink.MAV_DATA_STREAM_ALL
    for group, message_ids in GROUPS.items():
        if everything or group == request.req_stream_id:
            for message_id in message_ids:
                yield message_id, interval_us
