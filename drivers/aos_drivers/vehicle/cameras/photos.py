"""Frames that are geotagged photographs, in a folder or behind a companion computer's web server."""

from __future__ import annotations

from functools import partial
from typing import Literal

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError
from aos_drivers.frames.files.matching import Listing, WantedImage, newest
from aos_drivers.frames.files.photos import Photograph, check_moment, position_of, read_photograph
from aos_drivers.frames.files.stores import ImageFinder
from aos_drivers.frames.settings import CameraSettings
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess, capture_error
from aos_drivers.vehicle.cameras.shutter import Shutter
from aos_drivers.vehicle.transaction import Answer
from aos_gcs.errors import CaptureError, InputDataError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geotags.photo import Geotag
from aos_gcs.ports import Capture


class PhotoSource:
    """Source that triggers the autopilot's camera, unless it fires automatically, and takes the next photograph."""

    def __init__(self, vehicle: VehicleAccess, tools: CaptureTools, settings: CameraSettings) -> None:
        self._vehicle = vehicle
        self._record = vehicle.record
        self._clock = tools.clock
        self._settings = settings
        self._shutter = Shutter(vehicle, tools.clock)
        self._finder = ImageFinder(settings.place, vehicle.record.vehicle_id, tools.clock, tools.fetcher)
        self._read = partial(read_photograph, max_pixels=tools.fetcher.limits.max_pixels)
        self._taken = 0

    async def capture(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        host = self._vehicle.host_of(self._record.target.component_id)
        try:
            before = await self._finder.before(host, deadline_s)
            asked_at_utc_s = self._clock.utc_s()
            if self._settings.is_triggered:
                command = self._record.autopilot.shutter_command(self._record.target)
                await self._shutter.trigger(command, _when_accepted, lambda: None, deadline_s)
            return await self._collect(before, asked_at_utc_s, host, deadline_s)
        except CaptureError as error:
            raise capture_error(self._record.vehicle_id, None, error) from error

    async def _collect(self, before: Listing, asked_at_utc_s: float, host: str, deadline_s: float) -> Capture:
        photograph = await self._find(before, asked_at_utc_s, host, deadline_s)
        tag = photograph.tag
        self._taken += 1
        return Capture(
            vehicle_id=self._record.vehicle_id,
            image_index=self._taken - 1,
            utc_s=self._clock.utc_s() if tag.utc_s is None else tag.utc_s,
            image=photograph.image,
            bands=photograph.bands,
            position=position_of(tag, self._record.telemetry.home),
            R_cam2enu=self._settings.calibrated(tag.R_cam2enu),
            camera=self._camera(tag),
        )

    async def _find(self, before: Listing, asked_at_utc_s: float, host: str, deadline_s: float) -> Photograph:
        """Return the first photograph from after the request; those from before it may come late, and are passed over.

        Raises:
            FrameRefusedError: only such came.
            CaptureError: see ``ImageFinder.find``.
        """
        passed_over, too_old = dict(before), None

        def pick(now: Listing, wanted: WantedImage) -> str | None:
            name = newest(now, wanted)
            if name is not None:
                passed_over[name] = now[name]
            return name

        while True:
            wanted = WantedImage(dict(passed_over))
            try:
                found = await self._finder.find(wanted, self._read, host=host, deadline_s=deadline_s, pick=pick)
            except LateFrameError as error:
                raise too_old or error from error
            try:
                check_moment(found[0].tag, asked_at_utc_s, self._settings.match_tolerance_s)
            except FrameRefusedError as error:
                too_old = error
            else:
                return found[0]

    def _camera(self, tag: Geotag) -> CameraModel:
        if self._settings.calibration is not None:
            return self._settings.camera(tag.width_px, tag.height_px)
        try:
            return tag.camera(self._settings.fov_rad)
        except InputDataError as error:
            raise CaptureError(f"its lens is not known, {error}: set the option camera.fov_deg") from error


def _when_accepted(answer: Answer) -> Literal[True] | None:
    return True if answer is Answer.ACCEPTED else None
