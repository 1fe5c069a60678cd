from __future__ import annotations

import asyncio
import math

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.images import Image
from aos_drivers.frames.settings import CameraPlan, CameraSettings
from aos_drivers.vehicle.cameras.component_record import CameraRecord
from aos_gcs.errors import CaptureError
from aos_gcs.geometry.poses import nadir_pose
from tests.fakes.camera_vehicle import REQUEST, START, URL, CameraVehicle, RecordedFetcher, settle
from tests.fakes.mavlink_fleet import open_network

pytestmark = pytest.mark.looptime


async def test_an_image_comes_with_pose_time_and_camera() -> None:
    vehicle, fetcher = CameraVehicle(), RecordedFetcher()
    async with open_network(vehicle, fetcher=fetcher) as network:
        await settle(network)
        capture = await network.vehicle().capture(10.0)
    assert (capture.vehicle_id, capture.image_index, capture.utc_s) == (1, 7, 1_700_000_000.5)
    assert capture.position.altitude_amsl_m == 335.0
    assert capture.R_cam2enu == pytest.approx(nadir_pose([0, 0, 0]).R_cam2enu, abs=1e-6)
    assert (capture.camera.width_px, capture.camera.height_px) == (32, 24)
    assert capture.camera.horizontal_fov_rad == pytest.approx(2 * math.atan(0.5))
    assert fetcher.asked == [(URL, "10.0.0.1")]


async def test_a_black_frame_of_a_colour_camera_has_its_three_bands() -> None:
    """The fetcher reads three equal channels as one."""

    class Colours(RecordedFetcher):
        async def fetch(self, url: str, host: str, deadline_s: float) -> tuple[Image, tuple[str, ...]]:
            if self.asked:
                return await super().fetch(url, host, deadline_s)
            self.asked.append((url, host))
            return np.zeros((24, 32, 3), np.uint8), ("red", "green", "blue")

    async with open_network(CameraVehicle(), fetcher=Colours()) as network:
        await settle(network)
        captures = [await network.vehicle().capture(10.0) for _ in range(2)]
    assert [(capture.bands, capture.image.shape) for capture in captures] == [
        (("red", "green", "blue"), (24, 32, 3))
    ] * 2


async def test_a_lost_message_about_the_image_is_asked_for_again() -> None:
    vehicle = CameraVehicle()
    vehicle.lost = 1
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        assert (await network.vehicle().capture(10.0)).image_index == 7
    assert len(vehicle.sent(START)) == 1


async def test_a_repeated_command_keeps_its_sequence_number_so_that_one_image_is_taken() -> None:
    vehicle = CameraVehicle()
    answers = iter([mavlink.MAV_RESULT_TEMPORARILY_REJECTED])
    original = vehicle._on_capture

    def busy_once(message: mavlink.MAVLink_message) -> bytes:
        vehicle.result = next(answers, mavlink.MAV_RESULT_ACCEPTED)
        return original(message)

    vehicle._on_capture = busy_once  # type: ignore[method-assign]
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        first = await network.vehicle().capture(10.0)
        second = await network.vehicle().capture(10.0)
    assert (first.image_index, second.image_index) == (7, 8)
    assert [message.param4 for message in vehicle.sent(START)] == [1, 1, 2]


async def test_the_image_of_a_failed_capture_is_not_taken_for_the_next() -> None:
    vehicle = CameraVehicle()
    vehicle.lost = 1
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        with pytest.raises(CaptureError, match="image 7 from vehicle 1"):
            await network.vehicle().capture(network.clock.now_s() + 0.5)
        second = asyncio.create_task(network.vehicle().capture(10.0))
        await network.clock.sleep(0.01)
        network.deliver(vehicle.captured(7), next(iter(network.vehicles)))
        assert (await second).image_index == 8


@pytest.mark.parametrize(
    ("attribute", "value", "words"),
    [
        ("q", (0.0, 0.0, 0.0, 0.0), "no orientation"),
        ("q", (math.nan, 0.0, 0.0, 0.0), "no orientation"),
        ("q", (2.0, 0.0, 0.0, 0.0), "not a rotation: the norm of its quaternion is 2"),
        ("position_e7", (0, 0), "no position"),
        ("position_e7", (480100000, 140000000), r"11\d\d m from where the vehicle was.*max_pose_offset_m"),
        ("capture_result", 0, "exposure failed"),
        ("result", mavlink.MAV_RESULT_DENIED, "denied"),
        ("focal_mm", math.nan, "camera.fov_deg"),
    ],
)
async def test_what_makes_an_image_useless_is_named(attribute: str, value: object, words: str) -> None:
    vehicle = CameraVehicle()
    setattr(vehicle, attribute, value)
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        with pytest.raises(CaptureError, match=words):
            await network.vehicle().capture(10.0)


async def test_frames_and_those_that_are_not_used_are_counted_by_their_reasons() -> None:
    vehicle = CameraVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        await network.vehicle().capture(10.0)
        for attribute, value in (("position_e7", (480100000, 140000000)), ("capture_result", 0)):
            setattr(vehicle, attribute, value)
            with pytest.raises(CaptureError):
                await network.vehicle().capture(20.0)
        vehicle.capture_result, vehicle.lost = 1, 99
        with pytest.raises(CaptureError):
            await network.vehicle().capture(network.clock.now_s() + 0.5)
        camera = network.vehicle().state.camera
        told = [notice.text for notice in network.notices if "no image" in notice.text]
    assert camera is not None
    assert (camera.source, camera.frames, camera.refused, camera.failed, camera.late) == ("component", 1, 1, 1, 1)
    assert "did not arrive" in camera.problem
    assert len(told) == 3


async def test_the_field_of_view_can_be_set_by_the_user() -> None:
    vehicle = CameraVehicle()
    vehicle.focal_mm = 0.0
    async with open_network(
        vehicle, fetcher=RecordedFetcher(), cameras=CameraPlan(CameraSettings(fov_rad=0.8))
    ) as network:
        await settle(network)
        assert (await network.vehicle().capture(10.0)).camera.horizontal_fov_rad == pytest.approx(0.8)


async def test_one_capture_at_a_time_and_free_again_afterwards() -> None:
    vehicle = CameraVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        first = asyncio.create_task(network.vehicle().capture(10.0))
        await asyncio.sleep(0)
        with pytest.raises(CaptureError, match="already"):
            await network.vehicle().capture(10.0)
        first.cancel()
        await asyncio.gather(first, return_exceptions=True)
        await network.vehicle().capture(10.0)


async def test_a_mute_camera_fails_at_the_deadline_and_a_missing_one_at_once() -> None:
    vehicle = CameraVehicle()
    vehicle._on_capture = lambda _message: b""  # type: ignore[method-assign]
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        network.vehicle()._record.camera = None
        with pytest.raises(CaptureError, match="no camera"):
            await network.vehicle().capture(5.0)
        await settle(network)
        with pytest.raises(CaptureError, match="does not respond"):
            await network.vehicle().capture(5.0)
        assert network.clock.now_s() == pytest.approx(5.0, abs=0.01)


async def test_a_camera_that_is_found_later_takes_back_that_there_is_none() -> None:
    async with open_network(CameraVehicle(), fetcher=RecordedFetcher()) as network:
        network.vehicle()._record.camera = None
        for _ in range(3):
            with pytest.raises(CaptureError, match="no camera"):
                await network.vehicle().capture(5.0)
        await settle(network)
        for _ in range(2):
            await network.vehicle().capture(network.clock.now_s() + 10.0)
        told = [notice.text for notice in network.notices if "camera" in notice.text]
        assert told == [*["no image from vehicle 1: no camera detected"] * 2, "its camera delivers images"]
        assert network.vehicle().state.camera.problem == ""


def gap_requests(vehicle: CameraVehicle) -> list[tuple[float, float]]:
    """Return the parameters 2 and 3 of what was asked of lost messages about images."""
    return [
        (message.param2, message.param3)
        for message in vehicle.sent(REQUEST)
        if int(message.param1) == mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED
    ]


async def test_gaps_in_the_indices_are_asked_for_as_ranges_until_they_are_closed() -> None:
    vehicle = CameraVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        peer = next(iter(network.vehicles))
        for index in (7, 9, 13):  # a camera that takes images for somebody else, too
            vehicle.image_index = index + 1
            network.deliver(vehicle.captured(index), peer)
        await network.clock.sleep(0.5)
        assert gap_requests(vehicle) == [(8.0, 0.0)]
        await network.clock.sleep(2.0)
        assert gap_requests(vehicle)[1:] == [(10.0, 12.0), (11.0, 12.0)]
        network.deliver(vehicle.captured(12), peer)
        await network.clock.sleep(10.0)
        asked = gap_requests(vehicle)
        assert network.vehicle()._record.camera.poll_gaps(network.clock.now_s()) is None
        await network.clock.sleep(10.0)
    assert gap_requests(vehicle) == asked


@pytest.mark.parametrize("is_known", [True, False])
@pytest.mark.parametrize("wrong", [2**31 - 1, 100_000, -5])
async def test_one_message_with_a_wrong_index_does_not_blind_a_camera(wrong: int, is_known: bool) -> None:
    camera = CameraRecord(100)
    if is_known:
        camera.update(image(7), 0.0)
    camera.update(image(wrong), 0.0)
    for index in (8, 9, 10):
        camera.update(image(index), 0.0)
    found = camera.find_capture(camera.next_index - 1 if camera.next_index else None, frozenset())
    assert camera.next_index == 11
    assert found is not None
    assert found.image_index == 10


async def test_a_camera_that_restarts_is_followed_from_its_second_image_on() -> None:
    camera = CameraRecord(100)
    for index in (700, 701, 0, 1, 2):
        camera.update(image(index), 0.0)
    assert camera.next_index == 3


def image(index: int) -> mavlink.MAVLink_message:
    return mavlink.MAVLink_camera_image_captured_message(0, 0, 0, 0, 0, 0, 0, [1, 0, 0, 0], index, 1, b"")


async def test_a_gap_that_stays_is_given_up() -> None:
    vehicle = CameraVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        vehicle.image_index = 8  # of what it knows: the messages of 8 to 10 are lost for good
        network.deliver(vehicle.captured(11), next(iter(network.vehicles)))
        await network.clock.sleep(60.0)
    assert gap_requests(vehicle) == [(7.0, 10.0), *[(8.0, 10.0)] * 3]
