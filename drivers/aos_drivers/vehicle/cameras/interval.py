"""Images that a camera component takes by itself, the same for both drivers.

The camera is started with IMAGE_START_CAPTURE and tells of each image by itself
(https://mavlink.io/en/services/camera.html#still-image-capture). Lost messages are requested by their gap, and, where
none comes any more, by the camera's own status: whether it was stopped, or has restarted, shows there.
"""

from __future__ import annotations

import asyncio
import math
from collections import OrderedDict, deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import LateFrameError
from aos_drivers.vehicle.autopilots.base import Target, command_long
from aos_drivers.vehicle.cameras.component_record import CameraRecord, CaptureStatus
from aos_drivers.vehicle.cameras.exposure import (
    CaptureTools,
    VehicleAccess,
    capture_error,
    collect_capture,
    exposure_of,
)
from aos_drivers.vehicle.cameras.shutter import Shutter, request_reports
from aos_drivers.vehicle.transaction import ACK_TIMEOUT_S, Answer
from aos_drivers.vehicle.waiting import CLOCK_RESOLUTION_S
from aos_gcs.errors import CaptureError, NoIntervalError
from aos_gcs.ports import Capture, Notice, Severity

MAX_FETCHES = 4
"""Images of one camera that are fetched at a time."""
KEPT_WAITING = 4
"""Exposures that may wait for that. Policy: the oldest is left out, as late."""
KEPT_RESULTS = 8
"""Images that may wait to be taken. Policy: the oldest is dropped."""
FETCH_S = 6.0
"""Time from the message about an image until it has to be there whole."""
QUIET_S = 1.0
"""Least time without a message about an image after which the camera is asked what it does, every ``ASK_S``."""
_QUIET_PERIODS = 2.0
ASK_S = 0.5
FIRST_S = 2.0
"""Least time in which a camera has to tell of its first image, or to answer what it does, ..."""
_FIRST_ASKS = 2
FIRST_WITH_STATUS_S = 10.0
"""... and the one that says that it takes images by itself."""
RESTART_S = 3.0
"""Time in which a camera that has restarted has to accept the command."""
STOP_S = 1.0
"""Time in which a camera has to confirm that it was stopped: the command and one repetition. Whoever ends the interval
waits for it, and may have vehicles to stop."""
_BOOT_MARGIN_S = 2.0
_KEPT_SEEN = 256
_OLD_IMAGES = 64
"""Images before the first one of the interval whose messages may still come, requested again."""

_CapturedMessage: TypeAlias = mavlink.MAVLink_camera_image_captured_message


class CameraInterval:
    """Images of one camera that takes them by itself (``aos_gcs.ports.IntervalCaptures``).

    Made by :func:`open_interval`. What happens to the camera is noticed while somebody waits for its next image.
    """

    def __init__(self, vehicle: VehicleAccess, camera: CameraRecord, tools: CaptureTools, period_s: float) -> None:
        self._vehicle = vehicle
        self._vehicle_id = vehicle.record.vehicle_id
        self._camera = camera
        self._tools = tools
        self._clock = tools.clock
        self._period_s = period_s
        self._quiet_s = max(QUIET_S, _QUIET_PERIODS * period_s)
        self._shutter = Shutter(vehicle, tools.clock)
        self._may_run = False
        """Whether the camera may take images by itself by our command."""
        self._arrivals = camera.arrivals
        self._first_index = camera.next_index
        """Index of the interval's first image, where it is known."""
        self._seen: OrderedDict[tuple[int, int, int], None] = OrderedDict()
        """Images whose messages have come: index and both times."""
        self._heard_at_s = -math.inf
        """Time of the latest message about an image, or of the start."""
        self._first_due_s = math.inf
        """Time by which the first image has to be told of; infinite once one was."""
        self._asked_at_s = -math.inf
        self._due_s = -math.inf
        """Time at which to look at the camera again."""
        self._booted_at_s: float | None = None
        self._fetching: set[asyncio.Task[Capture]] = set()
        self._waiting: deque[_CapturedMessage] = deque()
        self._results: deque[Capture | BaseException] = deque(maxlen=KEPT_RESULTS)

    async def start(self, deadline_s: float) -> None:
        """Start the camera.

        Raises:
            NoIntervalError: it refuses.
            CaptureError: it does not answer.
        """
        before = self._camera.arrivals

        def is_started(answer: Answer) -> bool | None:
            # Where the answer was lost, a repeated command is refused: the images themselves tell.
            return answer is Answer.ACCEPTED or self._camera.arrivals > before or None

        command = command_long(self._target, mavlink.MAV_CMD_IMAGE_START_CAPTURE, 0.0, self._period_s, 0.0, 0.0)
        self._may_run = True
        try:
            await self._shutter.trigger(command, is_started, lambda: None, deadline_s, ack_timeout_s=ACK_TIMEOUT_S)
        except LateFrameError as error:
            raise capture_error(self._vehicle_id, None, error) from error
        except CaptureError as error:
            self._may_run = False
            raise NoIntervalError(str(error)) from error
        self._heard_at_s = self._clock.now_s()
        self._first_due_s = self._heard_at_s + max(FIRST_S, self._quiet_s + _FIRST_ASKS * ASK_S)
        self._booted_at_s = _booted_at_s(self._camera.status)

    async def next(self, deadline_s: float) -> Capture:
        """See ``aos_gcs.ports.IntervalCaptures``."""
        while True:
            self._take_messages()
            if self._results:
                break
            now_s = self._clock.now_s() + CLOCK_RESOLUTION_S
            if now_s >= deadline_s:
                raise capture_error(self._vehicle_id, None, LateFrameError("the camera tells of no further image"))
            if now_s >= self._due_s:
                await self._look_at_camera(now_s)
            await self._vehicle.changes.wait_for(self._has_news, min(deadline_s, self._due_s))
        result = self._results.popleft()
        if isinstance(result, BaseException):
            raise result
        return result

    async def end(self) -> None:
        """Stop the camera, and forget the images on their way."""
        self._waiting.clear()
        for task in self._fetching:
            task.cancel()
        if not self._may_run:
            return
        command = command_long(self._target, mavlink.MAV_CMD_IMAGE_STOP_CAPTURE, 0.0)
        deadline_s = self._clock.now_s() + STOP_S
        try:
            await self._shutter.trigger(
                command,
                lambda answer: answer is Answer.ACCEPTED or None,
                lambda: None,
                deadline_s,
                ack_timeout_s=ACK_TIMEOUT_S,
            )
        except CaptureError as error:
            self._notify(f"interval capture of its camera may go on: {error}")

    @property
    def _target(self) -> Target:
        return Target(self._vehicle_id, self._camera.component_id)

    def _notify(self, text: str) -> None:
        self._tools.notify(Notice(Severity.WARNING, text, self._vehicle_id))

    def _has_news(self) -> bool:
        return bool(self._results) or self._camera.arrivals > self._arrivals

    # --- the camera --------------------------------------------------------------------------------------------------

    async def _look_at_camera(self, now_s: float) -> None:
        """Ask a camera that tells of no images what it does, and act on its answer.

        Raises:
            NoIntervalError: it takes no images by itself.
            CaptureError: it has restarted, and could not be started again.
        """
        self._due_s = self._heard_at_s + self._quiet_s
        if now_s < self._due_s:
            return
        status = self._camera.status
        is_fresh = status is not None and status.heard_at_s > self._heard_at_s
        if status is not None and is_fresh and not status.takes_interval:
            await self._start_again(status, now_s)
            return
        if now_s >= self._first_due_s + is_fresh * (FIRST_WITH_STATUS_S - FIRST_S):
            raise NoIntervalError("the camera has accepted it and takes no image", may_pass=True)
        if now_s >= self._asked_at_s + ASK_S:
            self._asked_at_s = now_s
            request_reports(self._vehicle, self._camera, self._camera.next_index)
        self._due_s = self._asked_at_s + ASK_S

    async def _start_again(self, status: CaptureStatus, now_s: float) -> None:
        """Start a camera that has restarted; where somebody has stopped it, leave it to them."""
        before_s, booted_at_s = self._booted_at_s, _booted_at_s(status)
        if before_s is None or booted_at_s is None or booted_at_s < before_s + _BOOT_MARGIN_S:
            raise NoIntervalError("another station has stopped it")
        await self.start(now_s + RESTART_S)
        self._first_index = None
        self._seen.clear()
        self._due_s = self._heard_at_s + self._quiet_s
        self._notify("its camera has restarted: interval capture goes on")

    # --- images ------------------------------------------------------------------------------------------------------

    def _take_messages(self) -> None:
        messages = self._camera.arrived_since(self._arrivals)
        self._arrivals = self._camera.arrivals
        for message in messages:
            image = (message.image_index, message.time_utc, message.time_boot_ms)
            if image in self._seen or self._is_old(message.image_index):
                continue
            self._seen[image] = None
            if len(self._seen) > _KEPT_SEEN:
                self._seen.popitem(last=False)
            self._heard_at_s, self._first_due_s = self._clock.now_s(), math.inf
            self._fetch_soon(message)

    def _is_old(self, index: int) -> bool:
        return self._first_index is not None and 0 < self._first_index - index <= _OLD_IMAGES

    def _fetch_soon(self, message: _CapturedMessage) -> None:
        self._waiting.append(message)
        if len(self._fetching) < MAX_FETCHES:
            self._fetch(self._waiting.popleft())
        elif len(self._waiting) > KEPT_WAITING:
            reason = LateFrameError("images come faster than they can be fetched")
            self._results.append(capture_error(self._vehicle_id, self._waiting.popleft().image_index, reason))

    def _fetch(self, message: _CapturedMessage) -> None:
        exposure = exposure_of(message, self._camera.horizontal_fov_rad)
        host = self._vehicle.host_of(self._camera.component_id)
        deadline_s = self._clock.now_s() + FETCH_S
        task = asyncio.create_task(collect_capture(self._vehicle_id, exposure, host, self._tools, deadline_s))
        self._fetching.add(task)
        task.add_done_callback(self._take_result)

    def _take_result(self, task: asyncio.Task[Capture]) -> None:
        self._fetching.discard(task)
        if task.cancelled():
            return
        error = task.exception()
        self._results.append(task.result() if error is None else error)
        if self._waiting:
            self._fetch(self._waiting.popleft())
        self._vehicle.changes.announce()


@asynccontextmanager
async def open_interval(
    vehicle: VehicleAccess, tools: CaptureTools, period_s: float, deadline_s: float
) -> AsyncIterator[CameraInterval]:
    """Have the camera component of a vehicle take images by itself for as long as the context is entered.

    Raises:
        NoIntervalError: it cannot, or refuses.
        CaptureError: there is none, or it does not answer by ``deadline_s``.
    """
    camera = vehicle.record.camera
    if camera is None:
        raise capture_error(vehicle.record.vehicle_id, None, CaptureError("no camera detected"))
    if not camera.may_take_images:
        raise NoIntervalError("the camera reports that it takes no images")
    interval = CameraInterval(vehicle, camera, tools, period_s)
    try:
        await interval.start(deadline_s)
        yield interval
    finally:
        await interval.end()


def _booted_at_s(status: CaptureStatus | None) -> float | None:
    """Return the time at which a camera was booted; None where it does not tell."""
    if status is None or status.boot_s <= 0.0:
        return None
    return status.heard_at_s - status.boot_s
