"""Frames of a MAVLink camera component that names a URL (https://mavlink.io/en/services/camera.html)."""

from __future__ import annotations

from typing import TypeAlias

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.vehicle.autopilots.base import Target, command_long
from aos_drivers.vehicle.cameras.component_record import CameraRecord
from aos_drivers.vehicle.cameras.exposure import (
    CaptureTools,
    VehicleAccess,
    capture_error,
    collect_capture,
    exposure_of,
)
from aos_drivers.vehicle.cameras.shutter import LostReportError, Shutter, request_reports
from aos_drivers.vehicle.transaction import ACK_TIMEOUT_S
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture

CapturedMessage: TypeAlias = mavlink.MAVLink_camera_image_captured_message


class ComponentSource:
    """Source that commands the camera component of one vehicle and fetches the images that it names."""

    def __init__(self, vehicle: VehicleAccess, tools: CaptureTools) -> None:
        self._vehicle = vehicle
        self._record = vehicle.record
        self._tools = tools
        self._shutter = Shutter(vehicle, tools.clock)

    async def capture(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        camera = self._record.camera
        if camera is None:
            raise capture_error(self._record.vehicle_id, None, CaptureError("no camera detected"))
        message = await self._expose(camera, deadline_s)
        exposure = exposure_of(message, camera.horizontal_fov_rad)
        host = self._vehicle.host_of(camera.component_id)
        return await collect_capture(self._record.vehicle_id, exposure, host, self._tools, deadline_s)

    async def _expose(self, camera: CameraRecord, deadline_s: float) -> CapturedMessage:
        """Command one exposure and return the message about it."""
        awaited_index, before = camera.next_index, camera.known_indices()
        target, sequence = Target(self._record.vehicle_id, camera.component_id), float(camera.next_sequence())
        command = command_long(target, mavlink.MAV_CMD_IMAGE_START_CAPTURE, 0.0, 0.0, 1.0, sequence)
        try:
            return await self._shutter.trigger(
                command,
                lambda _: camera.find_capture(awaited_index, before),
                lambda: request_reports(self._vehicle, camera, awaited_index),
                deadline_s,
                ack_timeout_s=ACK_TIMEOUT_S,  # its sequence number makes a repeated command harmless
            )
        except CaptureError as error:
            if isinstance(error, LostReportError) and awaited_index is not None:
                camera.give_up(awaited_index)
            raise capture_error(self._record.vehicle_id, awaited_index, error) from error
