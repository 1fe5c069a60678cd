"""The part of MAVLink's mission protocol that up- and downloads a geofence (https://mavlink.io/en/services/mission.html).

Missions are always empty here. Of rally points there is a number alone: none is flown to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.vehicle.fence import Fence, Ring

MAX_POINTS = 100
"""Real autopilots store 70 to some hundreds, depending on the board."""
REPEAT_S = 1.0
ATTEMPTS = 5
_INSIDE: int = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
_OUTSIDE: int = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION
_RETURN_POINT: int = mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT
_FENCE: int = mavlink.MAV_MISSION_TYPE_FENCE
_FRAMES = frozenset({mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT})
_Item: TypeAlias = mavlink.MAVLink_mission_item_int_message


@dataclass(slots=True)
class _Upload:
    """An upload that is under way."""

    source: tuple[int, int]
    count: int
    due_s: float
    attempts_left: int = ATTEMPTS
    items: list[_Item] = field(default_factory=list)


class FenceService:
    """Stores the polygons and answers for them. A new upload replaces one that is under way, and then the old fence."""

    def __init__(self, frame: LocalFrame, send: Callable[[mavlink.MAVLink_message], None]) -> None:
        self._frame = frame
        self._send = send
        self._items: list[_Item] = []
        self._upload: _Upload | None = None
        self.inclusions_enu_m: tuple[Ring, ...] = ()
        self.exclusions_enu_m: tuple[Ring, ...] = ()
        self.rally_points = 0

    def polygons(self, radius_m: float, ceiling_m: float) -> Fence:
        """Return a fence of the stored polygons and two limits."""
        return Fence(radius_m, ceiling_m, self.inclusions_enu_m, self.exclusions_enu_m)

    # --- messages ----------------------------------------------------------------------------------------------------

    def on_request_list(self, message: mavlink.MAVLink_message) -> None:
        """Tell how many items there are."""
        counts = {_FENCE: len(self._items), mavlink.MAV_MISSION_TYPE_RALLY: self.rally_points}
        count = counts.get(message.mission_type, 0)
        self._send(mavlink.MAVLink_mission_count_message(*_source(message), count, message.mission_type))

    def on_request(self, message: mavlink.MAVLink_message) -> None:
        """Send one item."""
        source = _source(message)
        if message.mission_type != _FENCE or message.seq >= len(self._items):
            self._acknowledge(source, mavlink.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)
            return
        item = self._items[message.seq]
        self._send(
            _Item(
                *source,
                message.seq,
                mavlink.MAV_FRAME_GLOBAL,
                item.command,
                0,
                0,
                item.param1,
                0.0,
                0.0,
                0.0,
                item.x,
                item.y,
                0.0,
                _FENCE,
            )
        )

    def on_count(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Begin an upload."""
        source = _source(message)
        if message.mission_type != _FENCE:
            self._acknowledge(source, mavlink.MAV_MISSION_UNSUPPORTED, message.mission_type)
        elif message.count > MAX_POINTS:
            self._acknowledge(source, mavlink.MAV_MISSION_NO_SPACE)
        elif message.count == 0:
            self._finish(_Upload(source, 0, now_s))
        else:
            self._upload = _Upload(source, message.count, now_s)
            self.update(now_s)

    def on_item(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Take an item and ask for the next one."""
        upload = self._upload
        if upload is None or _source(message) != upload.source or message.mission_type != _FENCE:
            return
        if message.seq != len(upload.items):
            self._acknowledge(upload.source, mavlink.MAV_MISSION_INVALID_SEQUENCE)
            return
        if message.frame not in _FRAMES:
            self._upload = None
            self._acknowledge(upload.source, mavlink.MAV_MISSION_UNSUPPORTED_FRAME)
            return
        upload.items.append(message)
        upload.attempts_left, upload.due_s = ATTEMPTS, now_s
        if len(upload.items) == upload.count:
            self._finish(upload)
        else:
            self.update(now_s)

    def on_clear(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Forget the fence."""
        if message.mission_type in (_FENCE, mavlink.MAV_MISSION_TYPE_ALL):
            self._finish(_Upload(_source(message), 0, now_s))
        else:
            self._acknowledge(_source(message), mavlink.MAV_MISSION_ACCEPTED, message.mission_type)

    def update(self, now_s: float) -> None:
        """Ask again for an item that does not come, and give up after a while."""
        upload = self._upload
        if upload is None or now_s < upload.due_s:
            return
        if upload.attempts_left == 0:
            self._upload = None
            self._acknowledge(upload.source, mavlink.MAV_MISSION_OPERATION_CANCELLED)
            return
        upload.attempts_left -= 1
        upload.due_s = now_s + REPEAT_S
        self._send(mavlink.MAVLink_mission_request_int_message(*upload.source, len(upload.items), _FENCE))

    # --- the fence ---------------------------------------------------------------------------------------------------

    def _finish(self, upload: _Upload) -> None:
        self._upload = None
        try:
            # A return point is for aeroplanes; MAVProxy sends one along, and copters keep it without using it.
            polygons = list(self._polygons([item for item in upload.items if item.command != _RETURN_POINT]))
        except ValueError:
            self._acknowledge(upload.source, mavlink.MAV_MISSION_INVALID)
            return
        self._items = upload.items
        self.inclusions_enu_m = tuple(ring for command, ring in polygons if command == _INSIDE)
        self.exclusions_enu_m = tuple(ring for command, ring in polygons if command == _OUTSIDE)
        self._acknowledge(upload.source, mavlink.MAV_MISSION_ACCEPTED)

    def _polygons(self, items: list[_Item]) -> Iterator[tuple[int, Ring]]:
        start = 0
        while start < len(items):
            command, count = items[start].command, round(items[start].param1)
            chunk = items[start : start + count]
            is_whole = len(chunk) == count >= 3 and all((i.command, round(i.param1)) == (command, count) for i in chunk)
            if command not in (_INSIDE, _OUTSIDE) or not is_whole:
                raise ValueError("no polygons")
            yield command, tuple(self._place(item) for item in chunk)
            start += count

    def _place(self, item: _Item) -> tuple[float, float]:
        origin_amsl_m = self._frame.origin.altitude_amsl_m
        east_m, north_m, _ = self._frame.to_enu(GeodeticPosition(item.x / 1e7, item.y / 1e7, origin_amsl_m))
        return float(east_m), float(north_m)

    def _acknowledge(self, source: tuple[int, int], result: int, mission_type: int = _FENCE) -> None:
        self._send(mavlink.MAVLink_mission_ack_message(*source, result, mission_type))


def _source(message: mavlink.MAVLink_message) -> tuple[int, int]:
    return message.get_srcSystem(), message.get_srcComponent()
