"""Frames of a MAVLink camera component, with MAVSDK's camera plugin."""

from __future__ import annotations

from mavsdk.plugins.camera import Camera, CameraList, CameraResult, CaptureInfo, Information
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.system import System
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.errors import LateFrameError
from aos_drivers.frames.poses.clocks import utc_s_of
from aos_drivers.mavsdk.core import LoopDispatcher, message_from_direct
from aos_drivers.mavsdk.telemetry import geodetic
from aos_drivers.vehicle.autopilots.base import Target, command_long
from aos_drivers.vehicle.cameras.component_record import fov_from_lens
from aos_drivers.vehicle.cameras.exposure import CaptureTools, Exposure, VehicleAccess, capture_error, collect_capture
from aos_drivers.vehicle.cameras.image_index import CREDIBLE_JUMP, ImageIndex
from aos_drivers.vehicle.cameras.shutter import request_reports
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture

_ASK_AGAIN_S = 1.0
"""Time without the message about an image after which the camera's count of images is requested."""


class ComponentSource:
    """Source that commands the camera component of one vehicle and fetches the images that it names."""

    def __init__(
        self,
        system: System,
        direct: MavlinkDirect,
        vehicle: VehicleAccess,
        tools: CaptureTools,
        dispatcher: LoopDispatcher,
    ) -> None:
        self._vehicle = vehicle
        self._tools = tools
        self._dispatcher = dispatcher
        self._plugin = Camera(system)
        self._information: Information | None = None
        self._newest: CaptureInfo | None = None
        self._index = ImageIndex()
        self._is_exposing = False
        self._plugin.subscribe_camera_list(dispatcher.to_loop(self._take_list))
        self._plugin.subscribe_capture_info(dispatcher.to_loop(self._take_capture))
        direct.subscribe_message("CAMERA_CAPTURE_STATUS", dispatcher.to_loop(self._take_status))

    async def capture(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        vehicle_id, information = self._vehicle.record.vehicle_id, self._information
        if information is None:
            raise capture_error(vehicle_id, None, CaptureError("no camera detected"))
        self._is_exposing = True
        try:
            info = await self._expose(information.component_id, deadline_s)
        finally:
            self._is_exposing = False
        exposure = Exposure(
            image_index=info.index,
            is_success=info.is_success,
            utc_s=utc_s_of(info.time_utc_us),
            position=geodetic(info.position),
            q_wxyz=[getattr(info.attitude_quaternion, axis) for axis in "wxyz"],
            file_url=info.file_url,
            fov_rad=fov_from_lens(information.focal_length_mm, information.horizontal_sensor_size_mm),
        )
        host = self._vehicle.host_of(information.component_id)
        return await collect_capture(vehicle_id, exposure, host, self._tools, deadline_s)

    async def _expose(self, component_id: int, deadline_s: float) -> CaptureInfo:
        """Command one exposure and return the camera's report of it."""
        clock, before = self._tools.clock, self._newest
        results: list[CameraResult] = []
        self._plugin.take_photo_async(
            component_id, self._dispatcher.to_loop(lambda result: self._take(results, result))
        )

        def is_decided() -> bool:
            return self._newest is not before or any(result is not CameraResult.SUCCESS for result in results)

        while not await self._vehicle.changes.wait_for(is_decided, min(deadline_s, clock.now_s() + _ASK_AGAIN_S)):
            if clock.now_s() >= deadline_s:
                problem = "it was exposed, but its pose and address did not arrive" if results else "no answer"
                raise capture_error(self._vehicle.record.vehicle_id, None, LateFrameError(problem))
            if results:
                self._request(component_id, mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS, 0)
        if self._newest is before and await self._takes_interval(deadline_s):
            # MAVSDK does not tell a camera that is busy from one that refuses: the next image comes by itself.
            await self._vehicle.changes.wait_for(lambda: self._newest is not before, deadline_s)
        if self._newest is None or self._newest is before:
            reason = CaptureError(f"the camera refuses: {results[0].name.lower().replace('_', ' ')}")
            raise capture_error(self._vehicle.record.vehicle_id, None, reason)
        return self._newest

    async def _takes_interval(self, deadline_s: float) -> bool:
        """Ask the camera whether it takes images by itself, as for another station, until it answers."""
        camera, clock = self._vehicle.record.camera, self._tools.clock
        if camera is None:
            return False
        asked_at_s = clock.now_s()

        def is_answered() -> bool:
            return camera.status is not None and camera.status.heard_at_s > asked_at_s

        while not is_answered() and clock.now_s() < deadline_s:
            request_reports(self._vehicle, camera, None)
            await self._vehicle.changes.wait_for(is_answered, min(deadline_s, clock.now_s() + _ASK_AGAIN_S))
        return camera.status is not None and is_answered() and camera.status.takes_interval

    def _request(self, component_id: int, message_id: int, index: int) -> None:
        target = Target(self._vehicle.record.vehicle_id, component_id)
        request = command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(message_id), float(index))
        self._vehicle.send(target.system_id, component_id, request)

    def _take(self, results: list[CameraResult], result: CameraResult) -> None:
        if result is not CameraResult.IN_PROGRESS:
            results.append(result)
        self._vehicle.changes.announce()

    def _take_list(self, cameras: CameraList) -> None:
        """Use the camera of the lowest component id."""
        self._information = min(cameras.cameras, key=lambda camera: camera.component_id, default=None)

    def _take_status(self, status: MavlinkMessage) -> None:
        """Request the message about the last image if it was lost; MAVSDK does not."""
        index = message_from_direct(status).image_count - 1
        self._index.take_count(index + 1)
        is_missing = self._newest is None or self._newest.index < index
        if self._is_exposing and index >= 0 and is_missing:
            self._request(status.component_id, mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED, index)

    def _take_capture(self, info: CaptureInfo) -> None:
        """Keep the newest image, ignoring late and repeated messages. A restarted camera counts from 0 again."""
        is_ours = self._information is not None and info.component_id == self._information.component_id
        if not is_ours or not self._index.take(info.index):
            return
        newest = self._newest
        if newest is None or _order(info) > _order(newest) or newest.index - info.index > CREDIBLE_JUMP:
            self._newest = info
            self._vehicle.changes.announce()


def _order(info: CaptureInfo) -> tuple[int, int]:
    return info.time_utc_us, info.index
