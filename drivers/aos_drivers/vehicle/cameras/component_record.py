"""A vehicle's camera component (https://mavlink.io/en/services/camera.html), without I/O."""

from __future__ import annotations

import math
from collections import OrderedDict, deque
from dataclasses import dataclass

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.cameras.image_index import ImageIndex

CAMERA_IDS = range(mavlink.MAV_COMP_ID_CAMERA, mavlink.MAV_COMP_ID_CAMERA6 + 1)
"""Component ids of cameras."""
_KEPT_CAPTURES = 16
_KEPT_ARRIVALS = 64
_KEPT_GAPS = 64
_GAP_PAUSE_S = 1.0
_GAP_ATTEMPTS = 4
_REBOOT_MARGIN_MS = 2000
_INTERVAL_SET = frozenset({2, 3})
"""CAMERA_CAPTURE_STATUS.image_status of a camera that takes images by itself: between two of them, or at one."""


@dataclass(frozen=True, slots=True)
class CaptureStatus:
    """A camera's latest report on what it does."""

    heard_at_s: float
    boot_s: float
    """Time since the camera's boot, by itself."""
    takes_interval: bool
    """Whether it takes images by itself."""


class CameraRecord:
    """Information from a camera about itself and its images.

    Keeps the messages of the latest sixteen images, of the latest 64 indices those whose messages were lost, and the
    latest 64 messages about images in the order of their arrival.
    """

    def __init__(self, component_id: int) -> None:
        self.component_id = component_id
        self.information: mavlink.MAVLink_camera_information_message | None = None
        self.status: CaptureStatus | None = None
        self.arrivals = 0
        """Number of credible messages about images, repeated ones included."""
        self._arrived: deque[mavlink.MAVLink_camera_image_captured_message] = deque(maxlen=_KEPT_ARRIVALS)
        self._index = ImageIndex()
        self._captures: OrderedDict[int, mavlink.MAVLink_camera_image_captured_message] = OrderedDict()
        self._gaps: dict[int, int] = {}
        """Number of requests for the message of each index."""
        self._gaps_due_s = -math.inf
        self._boot_ms = 0
        self._sequence = 0

    @property
    def next_index(self) -> int | None:
        """Index that the next image should have; None while unknown."""
        return self._index.next

    @property
    def horizontal_fov_rad(self) -> float | None:
        """Full horizontal field of view; None if the camera does not report its lens."""
        if self.information is None:
            return None
        return fov_from_lens(self.information.focal_length, self.information.sensor_size_h)

    @property
    def may_take_images(self) -> bool:
        """Whether the camera does not exclude that it takes images."""
        return self.information is None or bool(self.information.flags & mavlink.CAMERA_CAP_FLAGS_CAPTURE_IMAGE)

    def next_sequence(self) -> int:
        """Return the number that distinguishes a new capture command from a repeated one."""
        self._sequence += 1
        return self._sequence

    def update(self, message: mavlink.MAVLink_message, now_s: float) -> None:
        """Update from a message of the camera component."""
        if message.get_msgId() == mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            self._see_time(message.time_boot_ms)
            self.information = message
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS:
            self._see_time(message.time_boot_ms)
            self._index.take_count(message.image_count)
            self.status = CaptureStatus(now_s, message.time_boot_ms / 1e3, message.image_status in _INTERVAL_SET)
        elif message.get_msgId() == mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED:
            self._take_image(message)

    def _take_image(self, message: mavlink.MAVLink_camera_image_captured_message) -> None:
        expected = self.next_index
        if not self._index.take(message.image_index):
            return
        self._gaps.pop(message.image_index, None)
        if expected is not None:
            self._note_gap(expected, message.image_index)
        self._arrived.append(message)
        self.arrivals += 1
        self._captures[message.image_index] = message
        while len(self._captures) > _KEPT_CAPTURES:
            self._captures.popitem(last=False)

    def poll_gaps(self, now_s: float) -> tuple[int, int] | None:
        """Return the first and the last index of a run of lost messages when it is time to request them."""
        if not self._gaps or now_s < self._gaps_due_s:
            return None
        self._gaps_due_s = now_s + _GAP_PAUSE_S
        first = last = min(self._gaps)
        while last + 1 in self._gaps:
            last += 1
        for index in range(first, last + 1):
            self._gaps[index] += 1
            if self._gaps[index] >= _GAP_ATTEMPTS:
                del self._gaps[index]
        return first, last

    def give_up(self, index: int) -> None:
        """Do not take the image of ``index``, which was exposed and never arrived, for that of a later command."""
        self._index.skip(index)

    def known_indices(self) -> frozenset[int]:
        """Return the indices of the images whose messages are kept."""
        return frozenset(self._captures)

    def arrived_since(self, arrivals: int) -> list[mavlink.MAVLink_camera_image_captured_message]:
        """Return the messages about images since there were as many ``arrivals``, as far as they are kept."""
        new = min(self.arrivals - arrivals, len(self._arrived))
        return list(self._arrived)[len(self._arrived) - new :]

    def find_capture(
        self, awaited_index: int | None, before: frozenset[int]
    ) -> mavlink.MAVLink_camera_image_captured_message | None:
        """Return the newest image that was not there ``before``, from ``awaited_index`` on where that is known."""
        for index, message in reversed(self._captures.items()):
            if index not in before and (awaited_index is None or index >= awaited_index):
                return message
        return None

    def _note_gap(self, expected: int, until_index: int) -> None:
        """Mark the messages from the expected index up to ``until_index`` as missing."""
        for index in range(max(expected, until_index - _KEPT_GAPS), until_index):
            self._gaps.setdefault(index, 0)
        while len(self._gaps) > _KEPT_GAPS:
            del self._gaps[min(self._gaps)]

    def _see_time(self, time_boot_ms: int) -> None:
        if time_boot_ms + _REBOOT_MARGIN_MS < self._boot_ms:
            self._index = ImageIndex()
            self._captures.clear()
            self._gaps.clear()
        self._boot_ms = time_boot_ms


def camera_rank(component_id: int) -> tuple[bool, int]:
    """Return by what one of several cameras is chosen, the least first.

    Autopilots introduce the cameras that they trigger, too, such as to another station, and have no images of them.
    """
    return component_id not in CAMERA_IDS, component_id


def fov_from_lens(focal_mm: float, width_mm: float) -> float | None:
    """Return the full field of view of a focal length and a sensor's width, or None where they are unknown."""
    if not (math.isfinite(focal_mm) and math.isfinite(width_mm) and focal_mm > 0 and width_mm > 0):
        return None
    return 2 * math.atan(width_mm / 2 / focal_mm)
