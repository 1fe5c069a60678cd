"""Geotagged photographs as the frames of a vehicle, in virtual time."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aos_drivers.frames.errors import FrameRefusedError, LateFrameError
from aos_drivers.frames.files.fetching import ImageLimits
from aos_drivers.frames.settings import CameraPlan, CameraSettings, ImagePlace, SourceKind
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.poses import nadir_pose
from tests.fakes.mavlink_fleet import open_network
from tests.fakes.mavlink_vehicle import HOME
from tests.fakes.photographs import exif_block, write_photograph, xmp_packet
from tests.fakes.shutter_vehicle import NoDownloads, ShutterVehicle, deadline_s, open_camera

pytest.importorskip("PIL", reason="needs the extra geo")
pytestmark = pytest.mark.looptime

XMP = {
    "drone-dji:GpsLatitude": HOME.latitude_deg,
    "drone-dji:GpsLongitude": HOME.longitude_deg,
    "drone-dji:AbsoluteAltitude": "+391.70",
    "drone-dji:RelativeAltitude": "+30.50",
    "drone-dji:GimbalYawDegree": "+120.00",
    "drone-dji:GimbalPitchDegree": "-90.00",
    "drone-dji:CalibratedFocalLength": "40.0",
}


def settings_of(folder: Path, **changes: object) -> CameraSettings:
    values = {"source": SourceKind.PHOTOS, "place": ImagePlace(folder=str(folder)), "max_pose_offset_m": 100.0}
    return CameraSettings(**(values | changes))  # type: ignore[arg-type]


def photographer(
    folder: Path, xmp: dict[str, object], camera: dict[int, object] | None = None
) -> Callable[[int], None]:
    image = np.full((30, 40, 3), 120, np.uint8)

    def take(shot: int) -> None:
        write_photograph(folder / f"DJI_{shot:04d}.JPG", image, exif_block(camera=camera), xmp_packet(xmp))

    return take


async def test_a_photograph_brings_its_pose_and_its_lens(tmp_path: Path) -> None:
    photographer(tmp_path, XMP | {"drone-dji:GimbalYawDegree": "0"})(1)  # of another flight
    taken_at = {0x9003: "2099:11:20 14:00:00", 0x9011: "+02:00"}
    vehicle = ShutterVehicle(photographer(tmp_path, XMP, taken_at))
    async with open_camera(vehicle, settings_of(tmp_path)) as network:
        await network.clock.sleep(0.2)
        capture = await network.vehicle().capture(deadline_s(network))
        state = network.vehicle().state.camera
    assert capture.image.shape == (30, 40, 1)  # one band, as its three channels are equal
    assert capture.R_cam2enu == pytest.approx(nadir_pose([0, 0, 0], math.radians(120.0)).R_cam2enu, abs=1e-9)
    # Not the 391.7 m that the photograph tells: home's altitude is the vehicle's own.
    assert capture.position.altitude_amsl_m == pytest.approx(HOME.altitude_amsl_m + 30.5)
    assert capture.camera.fx_px == pytest.approx(40.0)
    assert capture.utc_s == 4_098_859_200.0
    assert state is not None
    assert (state.source, state.frames) == ("photos", 1)


@pytest.mark.parametrize(
    ("xmp", "camera", "error", "words"),
    [
        (
            XMP,
            {0x9003: "2020:01:01 00:00:00", 0x9011: "+00:00"},
            FrameRefusedError,
            r"before it was requested.*match_t",
        ),
        (XMP | {"drone-dji:GpsLatitude": 47.0}, None, FrameRefusedError, "m from where the vehicle was"),
        ({"drone-dji:GimbalPitchDegree": "-90"}, None, CaptureError, "tags cannot be used: it has no GPSLatitude"),
        ({key: XMP[key] for key in XMP if "Focal" not in key}, None, CaptureError, r"camera\.fov_deg"),
        ({key: XMP[key] for key in XMP if "Altitude" not in key}, None, CaptureError, "contain no altitude"),
    ],
)
async def test_photographs_that_cannot_be_used_are_named(
    tmp_path: Path, xmp: dict[str, object], camera: dict[int, object], error: type[CaptureError], words: str
) -> None:
    async with open_camera(ShutterVehicle(photographer(tmp_path, xmp, camera)), settings_of(tmp_path)) as network:
        await network.clock.sleep(0.1)
        with pytest.raises(error, match=words):
            await network.vehicle().capture(deadline_s(network))


async def test_a_late_photograph_of_the_request_before_is_passed_over(tmp_path: Path) -> None:
    def take(shot: int) -> None:
        is_late = shot == 42
        taken_at = {0x9003: "2020:01:01 00:00:00" if is_late else "2099:11:20 14:00:00", 0x9011: "+00:00"}
        later = asyncio.get_running_loop().call_later
        later(1.5 if is_late else 1.0, photographer(tmp_path, XMP, taken_at), shot)

    async with open_camera(ShutterVehicle(take), settings_of(tmp_path)) as network:
        with pytest.raises(LateFrameError):
            await network.vehicle().capture(deadline_s(network, 1.0))
        assert (await network.vehicle().capture(deadline_s(network))).utc_s == 4_098_866_400.0


async def test_each_vehicle_has_its_own_source() -> None:
    cameras = CameraPlan(CameraSettings(), {2: settings_of(Path("/nowhere"))})
    first, second = ShutterVehicle(lambda _: None), ShutterVehicle(lambda _: None)
    second.system_id, second.encoder = 2, type(second.encoder)(2, 1)
    async with open_network(first, second, fetcher=NoDownloads(ImageLimits()), cameras=cameras) as network:
        with pytest.raises(CaptureError, match="no image from vehicle 1: no camera detected"):
            await network.vehicle(1).capture(1.0)
        with pytest.raises(CaptureError, match="/nowhere cannot be read"):
            await network.vehicle(2).capture(1.0)
