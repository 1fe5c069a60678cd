"""Taking one image with a vehicle's camera."""

from __future__ import annotations

import math
from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.mavlink.camera import CameraRecord
from aos_drivers.mavlink.commands import Send
from aos_drivers.mavlink.exposure import CaptureTools, Exposure, capture_error, collect_capture
from aos_drivers.mavlink.record import VehicleRecord
from aos_drivers.mavlink.telemetry import position_from_e7
from aos_drivers.mavlink.transaction import Answer, CommandTransaction, result_text
from aos_drivers.mavlink.waiting import CLOCK_RESOLUTION_S, Changes
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture

_MESSAGE_PAUSE_S = 1.0
"""After this time without the message about an image, it is asked for again."""

CapturedMessage: TypeAlias = mavlink.MAVLink_camera_image_captured_message


class CaptureRunner:
    """Takes the images of one vehicle. Policy: one at a time, a second call fails at once."""

    def __init__(self, record: VehicleRecord, send: Send, changes: Changes, tools: CaptureTools) -> None:
        self._record = record
        self._send = send
        self._changes = changes
        self._clock = tools.clock
        self._tools = tools
        self._is_busy = False

    async def run(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        camera = self._ready_camera()
        self._is_busy = True
        try:
            message = await self._expose(camera, deadline_s)
            return await self._collect(camera, message, deadline_s)
        finally:
            self._is_busy = False

    def _ready_camera(self) -> CameraRecord:
        record = self._record
        if record.identity.is_ambiguous(self._clock.now_s()):
            raise CaptureError(f"two vehicles use system id {record.vehicle_id}: give one of them another id")
        if record.camera is None:
            raise CaptureError(f"vehicle {record.vehicle_id} has no camera that speaks MAVLink")
        if self._is_busy:
            raise CaptureError(f"vehicle {record.vehicle_id} is already taking an image")
        return record.camera

    async def _expose(self, camera: CameraRecord, deadline_s: float) -> CapturedMessage:
        """Command one exposure and return the message about it."""
        awaited_index, before = camera.next_index, camera.known_indices()
        transaction = self._capture_command(camera)
        request_due_s = math.inf

        def find() -> CapturedMessage | None:
            return camera.find_capture(awaited_index, before)

        def is_news() -> bool:
            is_refused = transaction.answer is Answer.REFUSED
            return (
                find() is not None
                or is_refused
                or (transaction.answer is Answer.ACCEPTED and request_due_s == math.inf)
            )

        self._record.transactions.add(transaction)
        try:
            while (message := find()) is None:
                now_s = self._clock.now_s() + CLOCK_RESOLUTION_S
                if transaction.answer is Answer.REFUSED:
                    raise self._error(awaited_index, f"the camera refuses: {result_text(transaction.result)}")
                if now_s >= deadline_s:
                    self._give_up(camera, transaction, awaited_index)
                if transaction.answer is Answer.ACCEPTED and (request_due_s == math.inf or now_s >= request_due_s):
                    if now_s >= request_due_s:
                        self._request_again(camera, awaited_index)
                    request_due_s = now_s + _MESSAGE_PAUSE_S
                command = transaction.poll(now_s)
                if command is not None:
                    self._send(self._record.vehicle_id, camera.component_id, command)
                await self._changes.wait_for(is_news, min(deadline_s, transaction.due_s, request_due_s))
        finally:
            self._record.transactions.discard(transaction)
        return message

    def _capture_command(self, camera: CameraRecord) -> CommandTransaction:
        return CommandTransaction(
            mavlink.MAVLink_command_long_message(
                self._record.vehicle_id,
                camera.component_id,
                mavlink.MAV_CMD_IMAGE_START_CAPTURE,
                0,
                0.0,
                0.0,
                1.0,
                float(camera.next_sequence()),
                0.0,
                0.0,
                0.0,
            )
        )

    def _request_again(self, camera: CameraRecord, index: int | None) -> None:
        requests = [(mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS, 0)]
        if index is not None:
            requests.append((mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, index))
        for message_id, param2 in requests:
            request = mavlink.MAVLink_command_long_message(
                self._record.vehicle_id,
                camera.component_id,
                mavlink.MAV_CMD_REQUEST_MESSAGE,
                0,
                float(message_id),
                float(param2),
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
            )
            self._send(self._record.vehicle_id, camera.component_id, request)

    def _give_up(self, camera: CameraRecord, transaction: CommandTransaction, awaited_index: int | None) -> None:
        if transaction.answer is not Answer.ACCEPTED:
            raise self._error(awaited_index, "the camera does not answer")
        if awaited_index is not None:
            camera.give_up(awaited_index)
        raise self._error(awaited_index, "it was exposed, but the message with its pose and address did not arrive")

    async def _collect(self, camera: CameraRecord, message: CapturedMessage, deadline_s: float) -> Capture:
        """Fetch the image that ``message`` is about and join it with its pose."""
        exposure = Exposure(
            image_index=message.image_index,
            is_success=message.capture_result == 1,
            utc_s=message.time_utc / 1e6 if message.time_utc else None,
            position=position_from_e7(message.lat, message.lon, message.alt / 1000),
            q_wxyz=message.q,
            file_url=message.file_url,
            fov_rad=camera.horizontal_fov_rad,
        )
        host = self._camera_host(camera)
        return await collect_capture(self._record.vehicle_id, exposure, host, self._tools, deadline_s)

    def _camera_host(self, camera: CameraRecord) -> str:
        address = self._record.address_of(camera.component_id)
        return address.host if address is not None else ""

    def _error(self, index: int | None, reason: str) -> CaptureError:
        return capture_error(self._record.vehicle_id, index, reason)
