"""Captures of one vehicle, from the source that its camera has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from aos_drivers.frames.poses.plausibility import check_pose
from aos_drivers.frames.settings import SourceKind
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess, capture_error
from aos_drivers.vehicle.cameras.photos import PhotoSource
from aos_drivers.vehicle.cameras.reported import ReportedSource
from aos_drivers.vehicle.cameras.video import VideoSource
from aos_drivers.vehicle.record import VehicleRecord
from aos_gcs.errors import CaptureError
from aos_gcs.ports import Capture, DriverContext, Notice, Severity


class FrameSource(Protocol):
    """Source of a vehicle's frames."""

    async def capture(self, deadline_s: float) -> Capture:
        """Expose one image, or wait for the next, and return it; see ``Vehicle.capture``."""
        ...


class CaptureRunner:
    """Captures and counts the frames of one vehicle. Policy: one at a time, a second call fails at once."""

    def __init__(self, record: VehicleRecord, tools: CaptureTools, source: FrameSource) -> None:
        self._record = record
        self._tools = tools
        self._source = source
        self._is_busy = False

    async def run(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        record = self._record
        if record.is_ambiguous(self._tools.clock.now_s()):
            raise CaptureError(f"two vehicles use system id {record.vehicle_id}: change the id of one of them")
        if self._is_busy:
            raise CaptureError(f"vehicle {record.vehicle_id} is already taking an image")
        self._is_busy = True
        try:
            capture = await self._source.capture(deadline_s)
            self._check(capture)
        except CaptureError as error:
            if record.frames.count_missed(error):
                self._tools.notify(Notice(Severity.WARNING, str(error), record.vehicle_id))
            raise
        finally:
            self._is_busy = False
        if record.frames.count_used():
            self._tools.notify(Notice(Severity.INFO, "its camera delivers images", record.vehicle_id))
        return capture

    def _check(self, capture: Capture) -> None:
        limit_m = self._tools.cameras.of(capture.vehicle_id).max_pose_offset_m
        try:
            check_pose(capture.position, capture.R_cam2enu, self._record.payload.track, limit_m)
        except CaptureError as error:
            raise capture_error(capture.vehicle_id, capture.image_index, error) from error


def report_receiver(context: DriverContext, error: BaseException) -> None:
    """Report a receiver of streams that has failed permanently; everything else continues."""
    context.notify(
        Notice(Severity.CRITICAL, f"a camera's stream is no longer received: {error!r}; restart the service")
    )


def make_source(
    vehicle: VehicleAccess, tools: CaptureTools, make_component_source: Callable[[], FrameSource]
) -> FrameSource:
    """Return the source that the settings name; that of a camera component is the driver's own."""
    settings = tools.cameras.of(vehicle.record.vehicle_id)
    match settings.source:
        case SourceKind.COMPONENT:
            return make_component_source()
        case SourceKind.REPORTED:
            return ReportedSource(vehicle, tools, settings)
        case SourceKind.PHOTOS:
            return PhotoSource(vehicle, tools, settings)
        case SourceKind.VIDEO:
            return VideoSource(vehicle, tools, settings)
