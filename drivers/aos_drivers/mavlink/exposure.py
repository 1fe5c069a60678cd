"""From what a camera says about one exposure to the finished capture; the same for every way to hear it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from aos_drivers.frames.fetching import ImageFetcher
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import R_cam2enu_from_mavlink
from aos_gcs.ports import Capture, Clock


@dataclass(frozen=True, slots=True)
class CaptureTools:
    """What captures share across vehicles."""

    clock: Clock
    fetcher: ImageFetcher
    camera_fov_rad: float | None
    """Overrides the field of view that the cameras report."""


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
    """Full horizontal field of view of the lens, where the camera tells it."""


async def collect_capture(
    vehicle_id: int, exposure: Exposure, host: str, tools: CaptureTools, deadline_s: float
) -> Capture:
    """Fetch the image of an exposure from ``host``, the camera's own, and join it with its pose.

    Raises:
        CaptureError: the exposure failed or lacks its pose or lens, or the image does not arrive whole.
    """
    index = exposure.image_index
    if not exposure.is_success:
        raise capture_error(vehicle_id, index, "the camera reports that the exposure failed")
    if exposure.position is None:
        raise capture_error(vehicle_id, index, "the camera gives no position")
    try:
        R_cam2enu = R_cam2enu_from_mavlink(exposure.q_wxyz)
    except ValueError as error:
        raise capture_error(vehicle_id, index, "the camera gives no orientation") from error
    fov_rad = tools.camera_fov_rad or exposure.fov_rad
    if fov_rad is None:
        raise capture_error(vehicle_id, index, "the camera does not report its lens: set the option camera_fov_deg")
    try:
        image, bands = await tools.fetcher.fetch(exposure.file_url, host, deadline_s)
    except CaptureError as error:
        raise capture_error(vehicle_id, index, str(error)) from error
    return Capture(
        vehicle_id=vehicle_id,
        image_index=index,
        utc_s=exposure.utc_s if exposure.utc_s is not None else tools.clock.utc_s(),
        image=image,
        bands=bands,
        position=exposure.position,
        R_cam2enu=R_cam2enu,
        camera=CameraModel.from_fov(image.shape[1], image.shape[0], fov_rad),
    )


def capture_error(vehicle_id: int, index: int | None, reason: str) -> CaptureError:
    """Return the error of an image that did not arrive; ``index`` is None where it was never known."""
    which = f"image {index}" if index is not None else "the image"
    return CaptureError(f"no {which} from vehicle {vehicle_id}: {reason}")
