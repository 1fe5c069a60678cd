"""Assembly of a capture from the camera's report of one exposure, the same for both drivers."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.fetching import ImageFetcher
from aos_drivers.frames.poses.clocks import utc_s_of
from aos_drivers.frames.poses.plausibility import check_quaternion
from aos_drivers.frames.settings import CameraPlan
from aos_drivers.vehicle.commands import Send
from aos_drivers.vehicle.position_report import position_from_e7
from aos_drivers.vehicle.record import VehicleRecord
from aos_drivers.vehicle.waiting import Changes
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import AmslM
from aos_gcs.geometry.poses import R_cam2enu_from_mavlink
from aos_gcs.ports import Capture, Clock, Notice


@dataclass(frozen=True, slots=True)
class CaptureTools:
    """Tools that captures of all vehicles share."""

    clock: Clock
    fetcher: ImageFetcher
    cameras: CameraPlan
    notify: Callable[[Notice], None]
    start: Callable[[Coroutine[object, object, None]], None]
    """Runs work in the background for as long as the driver is open."""


@dataclass(frozen=True, slots=True)
class VehicleAccess:
    """Access to one vehicle: its record, and how to send to it."""

    record: VehicleRecord
    send: Send
    changes: Changes
    host_of: Callable[[int], str]
    """Host of a component; empty on a serial link, or before anything was heard."""


@dataclass(frozen=True, slots=True)
class Exposure:
    """One exposure, as the camera reports it."""

    image_index: int
    is_success: bool
    utc_s: float | None
    position: GeodeticPosition | None
    """Projection centre at exposure."""
    q_wxyz: Sequence[float]
    """MAVLink's camera (forward, right, down) to NED."""
    file_url: str
    fov_rad: float | None
    """Full horizontal field of view; None if the camera does not report its lens."""


def exposure_of(message: mavlink.MAVLink_camera_image_captured_message, fov_rad: float | None) -> Exposure:
    """Return the exposure that a camera component reports; ``fov_rad`` is the field of view that it has reported."""
    return Exposure(
        image_index=message.image_index,
        is_success=message.capture_result == 1,
        utc_s=utc_s_of(message.time_utc),
        position=position_from_e7(message.lat, message.lon, AmslM(message.alt / 1000)),
        q_wxyz=message.q,
        file_url=message.file_url,
        fov_rad=fov_rad,
    )


async def collect_capture(
    vehicle_id: int, exposure: Exposure, host: str, tools: CaptureTools, deadline_s: float
) -> Capture:
    """Fetch the image of an exposure from ``host``, the camera's own, and join it with its pose.

    Raises:
        CaptureError: the exposure failed or lacks its pose or lens, or the image does not arrive whole.
    """
    index = exposure.image_index
    if not exposure.is_success:
        raise capture_error(vehicle_id, index, CaptureError("the camera reports that the exposure failed"))
    if exposure.position is None:
        raise capture_error(vehicle_id, index, CaptureError("the camera gives no position"))
    try:
        settings = tools.cameras.of(vehicle_id)
        R_cam2enu = settings.calibrated(_orientation(exposure.q_wxyz))
        settings.check_lens(exposure.fov_rad)
        image, bands = await tools.fetcher.fetch(exposure.file_url, host, deadline_s)
        camera = settings.camera(image.shape[1], image.shape[0], exposure.fov_rad)
    except CaptureError as error:
        raise capture_error(vehicle_id, index, error) from error
    return Capture(
        vehicle_id=vehicle_id,
        image_index=index,
        utc_s=exposure.utc_s if exposure.utc_s is not None else tools.clock.utc_s(),
        image=image,
        bands=bands,
        position=exposure.position,
        R_cam2enu=R_cam2enu,
        camera=camera,
    )


def capture_error(vehicle_id: int, index: int | None, reason: CaptureError) -> CaptureError:
    """Return the error, of the same kind, of an image that did not arrive; ``index`` is None where it is not known."""
    which = f"image {index}" if index is not None else "image"
    return type(reason)(f"no {which} from vehicle {vehicle_id}: {reason}")


def _orientation(q_wxyz: Sequence[float]) -> NDArray[np.float64]:
    quaternion = np.asarray(q_wxyz, dtype=np.float64)
    if not np.isfinite(quaternion).all() or not quaternion.any():
        raise CaptureError("the camera gives no orientation")
    check_quaternion(quaternion)
    return R_cam2enu_from_mavlink(quaternion)
