"""Captures of one vehicle, from the source that its camera has."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import replace
from typing import Protocol

from aos_drivers.frames.poses.plausibility import check_pose
from aos_drivers.frames.settings import SourceKind
from aos_drivers.frames.steady_bands import SteadyBands
from aos_drivers.vehicle.cameras.exposure import CaptureTools, VehicleAccess, capture_error
from aos_drivers.vehicle.cameras.interval import open_interval
from aos_drivers.vehicle.cameras.photos import PhotoSource
from aos_drivers.vehicle.cameras.reported import ReportedSource
from aos_drivers.vehicle.cameras.video import VideoSource
from aos_gcs.errors import CaptureError, NoIntervalError
from aos_gcs.ports import Capture, DriverContext, IntervalCaptures, Notice, Severity


class FrameSource(Protocol):
    """Source of a vehicle's frames."""

    async def capture(self, deadline_s: float) -> Capture:
        """Expose one image, or wait for the next, and return it; see ``Vehicle.capture``."""
        ...


class CaptureRunner:
    """Captures and counts the frames of one vehicle.

    Policy: one call at a time, be it for a single frame or an interval; a second one fails at once.
    """

    def __init__(self, vehicle: VehicleAccess, tools: CaptureTools, source: FrameSource) -> None:
        self._vehicle = vehicle
        self._record = vehicle.record
        self._tools = tools
        self._source = source
        self._bands = SteadyBands()
        self._is_busy = False

    async def run(self, deadline_s: float) -> Capture:
        """See ``Vehicle.capture``."""
        with self._alone():
            return await self._count(self._source.capture(deadline_s))

    @asynccontextmanager
    async def interval(self, period_s: float, deadline_s: float) -> AsyncIterator[IntervalCaptures]:
        """See ``Vehicle.interval``."""
        if self._tools.cameras.of(self._record.vehicle_id).source is not SourceKind.COMPONENT:
            raise NoIntervalError("only a MAVLink camera component has it")
        with self._alone():
            async with open_interval(self._vehicle, self._tools, period_s, deadline_s) as images:

                async def take(deadline_s: float) -> Capture:
                    self._refuse_ambiguous()
                    return await self._count(images.next(deadline_s))

                yield _Counted(take)

    @contextmanager
    def _alone(self) -> Iterator[None]:
        self._refuse_ambiguous()
        if self._is_busy:
            raise CaptureError(f"vehicle {self._record.vehicle_id} is already taking an image")
        self._is_busy = True
        try:
            yield
        finally:
            self._is_busy = False

    def _refuse_ambiguous(self) -> None:
        record = self._record
        if record.is_ambiguous(self._tools.clock.now_s()):
            raise CaptureError(f"two vehicles use system id {record.vehicle_id}: change the id of one of them")

    async def _count(self, taking: Awaitable[Capture]) -> Capture:
        record = self._record
        try:
            capture = await taking
            self._check(capture)
        except NoIntervalError:
            raise
        except CaptureError as error:
            if record.frames.count_missed(error):
                self._tools.notify(Notice(Severity.WARNING, str(error), record.vehicle_id))
            raise
        if record.frames.count_used():
            self._tools.notify(Notice(Severity.INFO, "its camera delivers images", record.vehicle_id))
        image, bands = self._bands.settle(capture.image, capture.bands)
        return replace(capture, image=image, bands=bands)

    def _check(self, capture: Capture) -> None:
        limit_m = self._tools.cameras.of(capture.vehicle_id).max_pose_offset_m
        try:
            check_pose(capture.position, capture.R_cam2enu, self._record.payload.track, limit_m)
        except CaptureError as error:
            raise capture_error(capture.vehicle_id, capture.image_index, error) from error


class _Counted:
    """See ``aos_gcs.ports.IntervalCaptures``."""

    def __init__(self, take: Callable[[float], Awaitable[Capture]]) -> None:
        self._take = take

    async def next(self, deadline_s: float) -> Capture:
        return await self._take(deadline_s)


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
