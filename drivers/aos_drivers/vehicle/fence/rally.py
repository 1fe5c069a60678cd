"""Number of rally points that a vehicle stores (https://mavlink.io/en/services/mission.html)."""

from __future__ import annotations

import math

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.exchange import longer_pause_s
from aos_drivers.vehicle.fence.transfer import REPEAT_S

_RALLY = mavlink.MAV_MISSION_TYPE_RALLY


class RallyCount:
    """Request for the number of rally points.

    A vehicle that does not support them has none. Any other receipt is for something else, or of a vehicle that is
    busy: it is asked again.
    """

    name = "report its rally points"

    def __init__(self, target: Target, our_system_id: int) -> None:
        self._target = target
        self._our_system_id = our_system_id
        self._pause_s = REPEAT_S
        self._is_ended = False
        self.count: int | None = None
        """Number of rally points; None before the answer."""
        self.due_s = -math.inf

    @property
    def is_done(self) -> bool:
        """Whether the answer has arrived, and its receipt is confirmed."""
        return self._is_ended

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return the request, or the confirmation that ends the transfer."""
        target = self._target.system_id, self._target.component_id
        if self.count is not None:
            self._is_ended = True
            return [mavlink.MAVLink_mission_ack_message(*target, mavlink.MAV_MISSION_ACCEPTED, _RALLY)]
        if now_s < self.due_s:
            return []
        self.due_s = now_s + self._pause_s
        self._pause_s = longer_pause_s(self._pause_s)
        return [mavlink.MAVLink_mission_request_list_message(*target, _RALLY)]

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process the number, or a refusal."""
        is_ours = getattr(message, "mission_type", None) == _RALLY and message.target_system in (0, self._our_system_id)
        if not is_ours or self.count is not None:
            return
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_COUNT:
            self.count, self.due_s = message.count, -math.inf
        elif (
            message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_ACK
            and message.type == mavlink.MAV_MISSION_UNSUPPORTED
        ):
            self.count, self._is_ended = 0, True
