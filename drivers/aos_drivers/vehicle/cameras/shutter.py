"""Commanding one exposure and waiting for the report of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import LateFrameError
from aos_drivers.vehicle.autopilots.base import Target, command_long
from aos_drivers.vehicle.cameras.component_record import CameraRecord
from aos_drivers.vehicle.cameras.exposure import VehicleAccess
from aos_drivers.vehicle.transaction import Answer, CommandMessage, CommandTransaction, result_text
from aos_drivers.vehicle.waiting import CLOCK_RESOLUTION_S
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Clock

MESSAGE_PAUSE_S = 1.0
"""Time without the message about an image after which it is requested again."""

EXPOSURE_ACK_TIMEOUT_S = 3.0
"""Time before an unanswered command is sent again, if a repetition exposes a second image: autopilots cannot tell."""

T = TypeVar("T")


class LostReportError(LateFrameError):
    """An image was exposed, but its report did not arrive."""


class Shutter:
    """Shutter of a camera of one vehicle, or of the camera that its autopilot triggers."""

    def __init__(self, vehicle: VehicleAccess, clock: Clock) -> None:
        self._vehicle = vehicle
        self._clock = clock

    async def trigger(
        self,
        command: CommandMessage,
        find: Callable[[Answer], T | None],
        ask_again: Callable[[], None],
        deadline_s: float,
        *,
        ack_timeout_s: float = EXPOSURE_ACK_TIMEOUT_S,
    ) -> T:
        """Send the command until it is answered, and return what ``find`` finds.

        Args:
            command: command for one exposure.
            find: looks for the message about the image; called with the answer to the command.
            ask_again: requests that message; called every second once the command has been accepted.
            deadline_s: time at which to give up.
            ack_timeout_s: time without an answer after which the command is sent again.

        Raises:
            LostReportError: the command was accepted, but nothing was found by the deadline.
            LateFrameError: the command was not answered.
            CaptureError: it was refused.
        """
        transaction = CommandTransaction(command, ack_timeout_s=ack_timeout_s)
        asked_at_s = math.inf

        def has_changed() -> bool:
            is_accepted = transaction.answer is Answer.ACCEPTED and math.isinf(asked_at_s)
            return find(transaction.answer) is not None or transaction.answer is Answer.REFUSED or is_accepted

        self._vehicle.record.transactions[transaction] = None
        try:
            while (found := find(transaction.answer)) is None:
                now_s = self._clock.now_s() + CLOCK_RESOLUTION_S
                if transaction.answer is Answer.REFUSED:
                    raise CaptureError(f"the camera refuses: {result_text(transaction.result)}")
                if now_s >= deadline_s:
                    raise _timeout_error(transaction)
                if transaction.answer is Answer.ACCEPTED and (math.isinf(asked_at_s) or now_s >= asked_at_s):
                    if not math.isinf(asked_at_s):
                        ask_again()
                    asked_at_s = now_s + MESSAGE_PAUSE_S
                message = transaction.poll(now_s)
                if message is not None:
                    self._vehicle.send(self._vehicle.record.vehicle_id, command.target_component, message)
                await self._vehicle.changes.wait_for(has_changed, min(deadline_s, transaction.due_s, asked_at_s))
        finally:
            self._vehicle.record.transactions.pop(transaction)
        return found

    async def wait(self, find: Callable[[], T | None], deadline_s: float) -> T:
        """Wait for a camera that takes its images automatically, and return what ``find`` finds.

        Raises:
            LateFrameError: nothing was found by the deadline.
        """
        await self._vehicle.changes.wait_for(lambda: find() is not None, deadline_s)
        found = find()
        if found is None:
            raise LateFrameError("no exposure was reported: check that the camera takes images automatically")
        return found


def request_reports(vehicle: VehicleAccess, camera: CameraRecord, index: int | None) -> None:
    """Request from a camera component what it does, and the message about the image ``index`` if that is known."""
    requests = [(mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS, 0)]
    if index is not None:
        requests.append((mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, index))
    for message_id, param2 in requests:
        target = Target(vehicle.record.vehicle_id, camera.component_id)
        request = command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(message_id), float(param2))
        vehicle.send(target.system_id, target.component_id, request)


def _timeout_error(transaction: CommandTransaction) -> LateFrameError:
    if transaction.answer is not Answer.ACCEPTED:
        return LateFrameError("the camera does not respond")
    return LostReportError("it was exposed, but the message with its pose and address did not arrive")
