"""Uploading and downloading a geofence with MAVLink's mission protocol (https://mavlink.io/en/services/mission.html)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target
from aos_drivers.vehicle.exchange import longer_pause_s
from aos_drivers.vehicle.fence.items import FENCE
from aos_gcs.errors import CommandRefusedError

REPEAT_S = 1.0
"""First pause before a message without an answer is sent again."""
RESTART_S = 5.0
"""Time without a request after which the upload starts over; the vehicle itself requests a lost item again."""
MAX_ITEMS = 1000
"""Largest credible number of items."""
_REQUESTS = frozenset({mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT, mavlink.MAVLINK_MSG_ID_MISSION_REQUEST})


class FenceUpload:
    """Upload of the items one by one, in the order in which the vehicle requests them."""

    name = "accept the geofence"

    def __init__(
        self, target: Target, items: Sequence[mavlink.MAVLink_mission_item_int_message], our_system_id: int
    ) -> None:
        self._target = target
        self._items = list(items)
        self._our_system_id = our_system_id
        self._next: int | None = None
        """Item that was requested last; None before the first request."""
        self._is_requested = False
        self._pause_s = REPEAT_S
        self._result: int | None = None
        self.due_s = -math.inf

    @property
    def is_done(self) -> bool:
        """Whether the vehicle has accepted all items."""
        return bool(self._result == mavlink.MAV_MISSION_ACCEPTED)

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return the number of items, or the requested item.

        Raises:
            CommandRefusedError: the vehicle does not accept it.
        """
        if self._result is not None and not self.is_done:
            raise CommandRefusedError(
                f"vehicle {self._target.system_id} refuses a geofence of {len(self._items)} points: "
                f"{_result_text(self._result)}"
            )
        if now_s < self.due_s:
            return []
        if self._is_requested and self._next is not None:
            # Never sent without a request: a repeated item is answered as out of sequence.
            self._is_requested = False
            self.due_s = now_s + RESTART_S
            return [self._items[self._next]]
        self._next = None
        self.due_s = now_s + self._pause_s
        self._pause_s = longer_pause_s(self._pause_s)
        system_id, component_id = self._target.system_id, self._target.component_id
        return [mavlink.MAVLink_mission_count_message(system_id, component_id, len(self._items), FENCE)]

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process a request for an item, or the result."""
        if not _is_for(message, self._our_system_id):
            return
        if message.get_msgId() in _REQUESTS and message.seq < len(self._items):
            self._next, self._is_requested = message.seq, True
            self._pause_s = REPEAT_S
            self.due_s = -math.inf
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_ACK:
            self._on_result(message.type)

    def _on_result(self, result: int) -> None:
        is_early = result == mavlink.MAV_MISSION_ACCEPTED and self._next != len(self._items) - 1
        if is_early or result == mavlink.MAV_MISSION_INVALID_SEQUENCE:
            return
        if result == mavlink.MAV_MISSION_OPERATION_CANCELLED:
            # It has given up waiting for an item that was lost.
            self._next, self._is_requested = None, False
        else:
            self._result = result
        self.due_s = -math.inf


class FenceDownload:
    """Download: first the number of items, then one item after the other."""

    name = "report its geofence"

    def __init__(self, target: Target, our_system_id: int) -> None:
        self._target = target
        self._our_system_id = our_system_id
        self._count: int | None = None
        self._problem = ""
        self._pause_s = REPEAT_S
        self._is_confirmed = False
        self.items: list[mavlink.MAVLink_mission_item_int_message] = []
        """Items in order; complete when done."""
        self.due_s = -math.inf

    @property
    def is_done(self) -> bool:
        """Whether all items have arrived, and their receipt is confirmed."""
        return self._is_confirmed

    def poll(self, now_s: float) -> list[mavlink.MAVLink_message]:
        """Return the next request, or the confirmation.

        Raises:
            CommandRefusedError: the vehicle does not report them.
        """
        if self._problem:
            raise CommandRefusedError(f"vehicle {self._target.system_id} does not report its geofence: {self._problem}")
        if now_s < self.due_s:
            return []
        self.due_s = now_s + self._pause_s
        self._pause_s = longer_pause_s(self._pause_s)
        target = (self._target.system_id, self._target.component_id)
        if self._count is None:
            return [mavlink.MAVLink_mission_request_list_message(*target, FENCE)]
        if len(self.items) < self._count:
            return [mavlink.MAVLink_mission_request_int_message(*target, len(self.items), FENCE)]
        self._is_confirmed = True
        return [mavlink.MAVLink_mission_ack_message(*target, mavlink.MAV_MISSION_ACCEPTED, FENCE)]

    def on_message(self, message: mavlink.MAVLink_message) -> None:
        """Process the number of items, an item or a refusal."""
        if not _is_for(message, self._our_system_id):
            return
        match message.get_msgId():
            case mavlink.MAVLINK_MSG_ID_MISSION_COUNT if self._count is None:
                self._count = message.count
                if message.count > MAX_ITEMS:
                    self._problem = f"{message.count} points are more than any autopilot can store"
            case mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT if self._count and message.seq == len(self.items):
                self.items.append(message)
            case mavlink.MAVLINK_MSG_ID_MISSION_ACK if message.type != mavlink.MAV_MISSION_ACCEPTED:
                self._problem = _result_text(message.type)
            case _:
                return
        self._pause_s = REPEAT_S
        self.due_s = -math.inf


def _is_for(message: mavlink.MAVLink_message, our_system_id: int) -> bool:
    """Whether a message belongs to a transfer of a fence with us; 0 means all stations."""
    is_about_fences = getattr(message, "mission_type", None) == FENCE
    return is_about_fences and message.target_system in (0, our_system_id)


def _result_text(result: int) -> str:
    entry = mavlink.enums["MAV_MISSION_RESULT"].get(result)
    name = str(entry.name).removeprefix("MAV_MISSION_") if entry is not None else f"result {result}"
    return name.lower().replace("_", " ")
