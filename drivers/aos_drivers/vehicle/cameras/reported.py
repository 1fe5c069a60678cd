"""Frames whose exposures the autopilot reports, while their files come from elsewhere.

ArduPilot sends CAMERA_FEEDBACK, PX4 CAMERA_IMAGE_CAPTURED without a URL. A companion computer serves the files or drops
them into a folder.
"""

from __future__ import annotations

from functools import partial

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.images import decode_image
from aos_drivers.frames.files.matching import Listing, WantedImage
from aos_drivers.frames.files.outstanding import OutstandingFiles
from aos_drivers.frames.files.stores import ImageFinder
from aos_drivers.frames.poses.mount import Carrier, camera_pose
from aos_drivers.frames.settings import CameraSettings
from aos_drivers.vehicle.autopilots.base import command_long
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess, capture_error
from aos_drivers.vehicle.cameras.payload import ShutterReport
from aos_drivers.vehicle.cameras.shutter import LostReportError, Shutter
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture


class ReportedSource:
    """Source that triggers the autopilot's camera, waits for its report, and finds the file that belongs to it."""

    def __init__(self, vehicle: VehicleAccess, tools: CaptureTools, settings: CameraSettings) -> None:
        self._vehicle = vehicle
        self._record = vehicle.record
        self._clock = tools.clock
        self._settings = settings
        self._limits = tools.fetcher.limits
        self._shutter = Shutter(vehicle, tools.clock)
        self._finder = ImageFinder(settings.place, vehicle.record.vehicle_id, tools.clock, tools.fetcher)
        # A camera that fires by itself has files on their way at any time.
        is_counted = settings.is_triggered and not settings.place.has_index and settings.place.file_name is None
        self._outstanding = OutstandingFiles() if is_counted else None
        self._last_listing: Listing | None = None
        self._last_name = ""

    async def capture(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        record, host = self._record, self._vehicle.host_of(self._record.target.component_id)
        index: int | None = None
        try:
            before = await self._files_before(host, deadline_s)
            earlier = 0 if self._outstanding is None else self._outstanding.look(before, self._clock.now_s())
            report = await self._expose(deadline_s)
            index = report.index
            if not report.is_success:
                raise CaptureError("the autopilot reports that the exposure failed")
            self._await_file()
            return await self._collect(report, before, earlier, host, deadline_s)
        except CaptureError as error:
            if isinstance(error, LostReportError):
                self._await_file()
            raise capture_error(record.vehicle_id, index, error) from error

    def _await_file(self) -> None:
        if self._outstanding is not None:
            self._outstanding.note_exposure()

    async def _files_before(self, host: str, deadline_s: float) -> Listing:
        """Return the files that cannot be the image, because they were there before.

        Where names hold the index, one that has appeared since the last call can be: that of a command that was sent
        twice.
        """
        listing = await self._finder.before(host, deadline_s)
        if self._settings.place.file_name is None:
            return listing
        last, self._last_listing = self._last_listing, listing
        if last is None:
            return listing
        return {name: stamp for name, stamp in listing.items() if last.get(name) == stamp or name == self._last_name}

    async def _expose(self, deadline_s: float) -> ShutterReport:
        payload, record = self._record.payload, self._record
        before, reports_before = payload.latest_report, payload.reports
        heard_boot_s = payload.track.motions.latest_s

        def find() -> ShutterReport | None:
            report = payload.latest_report
            if report is None or payload.reports == reports_before or (before and report.index == before.index):
                return None
            # A command that was sent twice exposes twice, and the second report may come when the first frame is done:
            # what was exposed before the vehicle's latest telemetry was not commanded after it.
            return report if heard_boot_s is None or report.time.is_since(heard_boot_s) else None

        if not self._settings.is_triggered:
            return await self._shutter.wait(find, deadline_s)
        command = record.autopilot.shutter_command(record.target)
        return await self._shutter.trigger(command, lambda _: find(), self._ask_again, deadline_s)

    def _ask_again(self) -> None:
        """Request the report of the latest exposure, which was lost; PX4 keeps none."""
        target, report_id = self._record.target, self._record.autopilot.shutter_report_id
        request = command_long(target, mavlink.MAV_CMD_REQUEST_MESSAGE, float(report_id))
        self._vehicle.send(target.system_id, target.component_id, request)

    async def _collect(
        self, report: ShutterReport, before: Listing, earlier: int, host: str, deadline_s: float
    ) -> Capture:
        settings, clock, payload = self._settings, self._clock, self._record.payload
        boot_now_s = payload.boot_now_s(clock.now_s(), self._record.clock.offset_s)
        age_s = 0.0 if boot_now_s is None else boot_now_s - report.time.boot_s
        utc_s = clock.utc_s() - age_s
        wanted = WantedImage(
            before,
            report.index + settings.index_offset,
            utc_s,
            settings.match_tolerance_s,
            settings.place.file_name,
            earlier,
        )
        decode = partial(decode_image, max_pixels=self._limits.max_pixels)
        (image, bands), self._last_name = await self._finder.find(wanted, decode, host=host, deadline_s=deadline_s)
        with_gimbal = settings.mount.carrier is Carrier.GIMBAL
        boot_s = report.time.boot_s + settings.clock_offset_s
        # The report has the pose of its own time.
        has_pose = not settings.clock_offset_s and report.R_body2ned is not None and report.position is not None
        if with_gimbal or not has_pose:
            # Reports from both sides of the exposure make its pose better than the latest one before it.
            await self._vehicle.changes.wait_for(
                lambda: payload.track.covers(boot_s, with_gimbal=with_gimbal),
                min(deadline_s, clock.now_s() + settings.max_pose_age_s),
            )
        position, R_cam2enu = camera_pose(
            payload.track,
            settings.mount,
            boot_s,
            settings.max_pose_age_s,
            vehicle=None if settings.clock_offset_s else report.position,
            R_body2ned=None if settings.clock_offset_s else report.R_body2ned,
        )
        return Capture(
            vehicle_id=self._record.vehicle_id,
            image_index=report.index,
            utc_s=utc_s,
            image=image,
            bands=bands,
            position=position,
            R_cam2enu=settings.calibrated(R_cam2enu),
            camera=settings.camera(image.shape[1], image.shape[0]),
            time_sigma_s=report.time.sigma_s,
        )
