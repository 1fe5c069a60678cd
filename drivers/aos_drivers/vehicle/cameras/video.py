"""Frames from a vehicle's video stream, with poses interpolated at their times."""

from __future__ import annotations

import asyncio

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError
from aos_drivers.frames.poses.mount import Carrier, camera_pose
from aos_drivers.frames.settings import CameraSettings
from aos_drivers.frames.stream.receiver import StreamFrame, VideoReceiver
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess, capture_error
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture


class VideoSource:
    """Source that takes the first frame of a stream that was exposed after the request."""

    def __init__(self, vehicle: VehicleAccess, tools: CaptureTools, settings: CameraSettings) -> None:
        self._vehicle = vehicle
        self._record = vehicle.record
        self._clock = tools.clock
        self._settings = settings
        limits = tools.fetcher.limits
        self._receiver = VideoReceiver(
            self._address, tools.clock, settings, limits.max_pixels, vehicle.changes.announce
        )
        tools.start(self._receiver.run())

    async def capture(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        frame: StreamFrame | None = None
        try:
            frame = await self._next_frame(deadline_s)
            return await self._collect(frame, deadline_s)
        except CaptureError as error:
            number = None if frame is None else frame.number
            raise capture_error(self._record.vehicle_id, number, error) from error

    async def _next_frame(self, deadline_s: float) -> StreamFrame:
        asked_at_s = self._clock.now_s()
        await self._vehicle.changes.wait_for(lambda: self._receiver.first_since(asked_at_s) is not None, deadline_s)
        frame = self._receiver.first_since(asked_at_s)
        if frame is None:
            raise LateFrameError(self._receiver.problem or "no frame of the stream was exposed in time")
        return frame

    async def _collect(self, frame: StreamFrame, deadline_s: float) -> Capture:
        settings, clock, payload = self._settings, self._clock, self._record.payload
        settings.check_lens()
        offset_s = payload.clock.offset_s(self._record.clock.offset_s)
        if offset_s is None:
            raise FrameRefusedError("the vehicle has not reported its time: the pose of the frame is unknown")
        boot_s = frame.time.at_s + offset_s + settings.clock_offset_s
        with_gimbal = settings.mount.carrier is Carrier.GIMBAL
        await self._vehicle.changes.wait_for(
            lambda: payload.track.covers(boot_s, with_gimbal=with_gimbal),
            min(deadline_s, clock.now_s() + settings.max_pose_age_s),
        )
        position, R_cam2enu = camera_pose(payload.track, settings.mount, boot_s, settings.max_pose_age_s)
        image, bands = await asyncio.to_thread(frame.image)
        return Capture(
            vehicle_id=self._record.vehicle_id,
            image_index=frame.number,
            utc_s=clock.utc_s() - (clock.now_s() - frame.time.at_s),
            image=image,
            bands=bands,
            position=position,
            R_cam2enu=settings.calibrated(R_cam2enu),
            camera=settings.camera(image.shape[1], image.shape[0]),
            time_sigma_s=frame.time.sigma_s,
        )

    def _address(self) -> str:
        """Return the stream's address; called in the receiver's thread, where reading the record is safe."""
        host = self._vehicle.host_of(self._record.target.component_id)
        return self._settings.place.url_of(self._record.vehicle_id, host)
