"""A camera that takes images by itself: lost messages, restarts, refusals, and who stops it. In virtual time."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_drivers.frames.files.images import Image
from aos_drivers.frames.settings import CameraPlan, CameraSettings, ImagePlace, SourceKind
from aos_drivers.vehicle.cameras.interval import FETCH_S, KEPT_WAITING, MAX_FETCHES
from aos_gcs.errors import CaptureError, NoIntervalError
from aos_gcs.ports import Capture, IntervalCaptures
from tests.fakes.camera_vehicle import REQUEST, START, CameraVehicle, RecordedFetcher, settle
from tests.fakes.mavlink_fleet import TELEMETRY_PERIOD_S, Network, open_network

pytestmark = pytest.mark.looptime

STOP = mavlink.MAV_CMD_IMAGE_STOP_CAPTURE
PERIOD_S = 0.4
UTC_S = 1_700_000_000.0


@dataclass
class PlannedFetcher(RecordedFetcher):
    """Delivers the image of each index after its own time; ``None``: never."""

    network: Network | None = None
    delays_s: dict[int, float | None] = field(default_factory=dict)

    async def fetch(self, url: str, host: str, deadline_s: float) -> tuple[Image, tuple[str, ...]]:
        self.asked.append((url, host))
        assert self.network is not None
        delay_s = self.delays_s.get(int(url.rpartition("/")[2]), 0.0)
        await self.network.clock.sleep(deadline_s - self.network.clock.now_s() if delay_s is None else delay_s)
        if delay_s is None:
            raise CaptureError("it did not come")
        return np.zeros((24, 32, 1), np.uint8), ("grey",)


class IntervalVehicle(CameraVehicle):
    """Vehicle whose camera takes images by itself, at telemetry's pace; messages of ``lost_indices`` are lost once."""

    def __init__(self) -> None:
        super().__init__()
        self.period_s = 0.0
        self.time_s = 100.0
        """Time since the camera's boot."""
        self.due_s = 0.0
        self.exposed_s: dict[int, float] = {}
        self.lost_indices: set[int] = set()
        self.is_idle = False
        """Whether it accepts an interval and takes no image."""
        self.acknowledges = True
        self.start_up_s = 0.0
        """Time from a start to the first image."""
        self.flags = mavlink.CAMERA_CAP_FLAGS_CAPTURE_IMAGE

    def captured(self, index: int) -> bytes:
        at_s = self.exposed_s.get(index, 0.0)
        return self.camera.pack(
            mavlink.MAVLink_camera_image_captured_message(
                *(round(at_s * 1e3), round((UTC_S + at_s) * 1e6), 0),
                *(*self.position_e7, 335_000, 35_000, [*self.q], index, 1),
                f"http://10.0.0.1/{index}".encode(),
            )
        )

    def camera_heartbeat(self) -> bytes:
        self.time_s += TELEMETRY_PERIOD_S
        if not self.period_s or self.is_idle or self.time_s < self.due_s:
            return super().camera_heartbeat()
        self.due_s += self.period_s
        self.exposed_s[self.image_index] = self.time_s
        self.image_index += 1
        told = b"" if self.image_index - 1 in self.lost_indices else self.captured(self.image_index - 1)
        return super().camera_heartbeat() + told

    def restart(self) -> None:
        self.period_s, self.time_s, self.image_index = 0.0, 1.0, 0
        self.exposed_s.clear()

    def _on_command(self, message: mavlink.MAVLink_message) -> bytes:
        if message.target_component != 100:
            return super()._on_command(message)
        if message.command == STOP or (message.command == START and message.param3 != 1.0):
            self.commands.append(message)
            return self._on_interval(message)
        wanted = int(message.param1)
        if message.command == REQUEST and wanted == mavlink.MAVLINK_MSG_ID_CAMERA_CAPTURE_STATUS:
            self.commands.append(message)
            status = 3 if self.period_s else 0
            return self.camera.pack(
                mavlink.MAVLink_camera_capture_status_message(
                    round(self.time_s * 1e3), status, 0, self.period_s, 0, 0.0, self.image_index
                )
            )
        if message.command == REQUEST and wanted == mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION:
            names = [0] * 32
            information = (0, names, names, 0, self.focal_mm, 6.4, 4.8, 640, 480, 0, self.flags, 0, b"")
            return self.camera.pack(mavlink.MAVLink_camera_information_message(*information))
        return super()._on_command(message)

    def _on_interval(self, message: mavlink.MAVLink_message) -> bytes:
        ack = mavlink.MAVLink_command_ack_message(message.command, self.result, 0, 0, 254, 190)
        if message.command == STOP or self.result == mavlink.MAV_RESULT_ACCEPTED:
            self.period_s = 0.0 if message.command == STOP else message.param2
            self.due_s = self.time_s + self.start_up_s
        return self.camera.pack(ack) if self.acknowledges else b""


async def take(network: Network, images: IntervalCaptures, count: int) -> list[Capture]:
    return [await images.next(network.clock.now_s() + 10.0) for _ in range(count)]


def indices(captures: list[Capture]) -> list[int]:
    return [capture.image_index for capture in captures]


def texts(network: Network) -> list[str]:
    return [notice.text for notice in network.notices]


async def test_images_come_by_themselves_with_their_times_until_the_camera_is_stopped() -> None:
    vehicle = IntervalVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            taken = await take(network, images, 5)
        assert vehicle.period_s == 0.0
    assert indices(taken) == [7, 8, 9, 10, 11]
    assert np.diff([capture.utc_s for capture in taken]) == pytest.approx([PERIOD_S] * 4, abs=1e-5)
    ((start,), (stop,)) = vehicle.sent(START), vehicle.sent(STOP)
    assert [start.param1, start.param2, start.param3, start.param4] == pytest.approx([0.0, PERIOD_S, 0.0, 0.0])
    assert stop.target_component == 100


async def test_lost_messages_are_asked_for_again_and_repeated_ones_are_one_image() -> None:
    vehicle = IntervalVehicle()
    vehicle.lost_indices = {8, 10, 11}
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            taken = await take(network, images, 3)
            network.deliver(vehicle.captured(7) + vehicle.captured(9), next(iter(network.vehicles)))
            taken += await take(network, images, 6)
    assert sorted(indices(taken)) == list(range(7, 16)), "each once"
    assert indices(taken) != sorted(indices(taken)), "the lost ones came later"
    times_utc_s = [capture.utc_s for capture in sorted(taken, key=lambda one: one.image_index)]
    assert np.diff(times_utc_s) == pytest.approx([PERIOD_S] * 8, abs=1e-5), "each with the time of its own exposure"


async def test_a_slow_image_delays_none_that_come_after_it_and_a_missing_one_is_named() -> None:
    vehicle, fetcher = IntervalVehicle(), PlannedFetcher(delays_s={8: 1.0, 9: None})
    async with open_network(vehicle, fetcher=fetcher) as network:
        fetcher.network = network
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            taken = await take(network, images, 6)
            assert set(indices(taken)) == {7, 8, 10, 11, 12, 13}
            assert indices(taken)[1] == 10
            with pytest.raises(CaptureError, match="image 9 from vehicle 1: it did not come"):
                await take(network, images, round(FETCH_S / PERIOD_S) + 1)
        camera = network.vehicle().state.camera
    assert camera is not None
    assert camera.failed == 1


async def test_images_that_cannot_be_fetched_in_time_are_left_out_the_oldest_first() -> None:
    vehicle = IntervalVehicle()
    fetcher = PlannedFetcher(delays_s={7 + number: 3.4 for number in range(99)})
    async with open_network(vehicle, fetcher=fetcher) as network:
        fetcher.network = network
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            with pytest.raises(CaptureError, match=r"image 11 .*faster than they can be fetched"):
                await images.next(network.clock.now_s() + 10.0)
            assert len(fetcher.asked) == MAX_FETCHES
            assert vehicle.image_index - 7 == MAX_FETCHES + KEPT_WAITING + 1
            assert indices([await images.next(network.clock.now_s() + 10.0)]) == [7]


async def test_a_camera_that_restarts_is_started_again() -> None:
    vehicle = IntervalVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            before = await take(network, images, 3)
            vehicle.restart()
            after = await take(network, images, 3)
        told = texts(network)
    assert indices(before) == [7, 8, 9]
    assert indices(after) == [0, 1, 2], "of other images, though of lower numbers"
    assert told.count("its camera has restarted: interval capture goes on") == 1
    assert len(vehicle.sent(START)) == 2


async def test_a_camera_that_another_station_stops_is_left_to_it() -> None:
    vehicle = IntervalVehicle()
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            await take(network, images, 3)
            vehicle.period_s = 0.0
            stopped_at_s = network.clock.now_s()
            with pytest.raises(NoIntervalError, match="another station has stopped it"):
                await take(network, images, 1)
            assert network.clock.now_s() - stopped_at_s < 2.5
    assert len(vehicle.sent(START)) == 1


@pytest.mark.parametrize("result", [mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_UNSUPPORTED])
async def test_a_refusal_is_told_and_single_images_are_taken_as_before(result: int) -> None:
    vehicle = IntervalVehicle()
    vehicle.result = result
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        with pytest.raises(NoIntervalError, match=r"the camera refuses: (denied|unsupported)"):
            async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0):
                pass
        assert not vehicle.sent(STOP)
        vehicle.result = mavlink.MAV_RESULT_ACCEPTED
        assert (await network.vehicle().capture(network.clock.now_s() + 5.0)).image_index == 7
        camera = network.vehicle().state.camera
    assert camera is not None
    assert (camera.failed, camera.late) == (0, 0), "it is no image that is missing"


async def test_a_camera_that_reports_that_it_takes_no_images_is_not_asked() -> None:
    vehicle = IntervalVehicle()
    vehicle.flags = mavlink.CAMERA_CAP_FLAGS_CAPTURE_VIDEO
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        with pytest.raises(NoIntervalError, match="the camera reports that it takes no images"):
            async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0):
                pass
    assert not vehicle.sent(START)


async def test_a_camera_that_the_autopilot_triggers_takes_images_on_request() -> None:
    cameras = CameraPlan(CameraSettings(SourceKind.REPORTED, ImagePlace(folder="images")))
    async with open_network(IntervalVehicle(), fetcher=RecordedFetcher(), cameras=cameras) as network:
        await settle(network)
        with pytest.raises(NoIntervalError, match="only a MAVLink camera component has it"):
            async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0):
                pass


async def test_a_camera_that_accepts_the_command_and_takes_no_image_is_found_out() -> None:
    vehicle = IntervalVehicle()
    vehicle.is_idle = True
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            with pytest.raises(NoIntervalError, match="has accepted it and takes no image"):
                await images.next(network.clock.now_s() + 30.0)
        assert vehicle.period_s == 0.0


@pytest.mark.parametrize("period_s", [0.4, 1.0, 3.0])
async def test_a_camera_that_says_that_it_has_begun_may_take_its_time_for_the_first_image(period_s: float) -> None:
    vehicle = IntervalVehicle()
    vehicle.start_up_s = 8.0
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(period_s, network.clock.now_s() + 2.0) as images:
            assert indices([await images.next(network.clock.now_s() + 20.0)]) == [7]


async def test_where_the_acknowledgement_is_lost_the_images_tell_that_the_camera_has_begun() -> None:
    vehicle = IntervalVehicle()
    vehicle.acknowledges = False
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            assert indices(await take(network, images, 2)) == [7, 8]
            vehicle.result = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        assert [text for text in texts(network) if "interval capture of its camera may go on" in text]
    assert len(vehicle.sent(STOP)) == 2, "repeated, and then given up"


async def test_a_camera_that_does_not_answer_is_stopped_in_case_that_it_has_begun() -> None:
    vehicle = IntervalVehicle()
    vehicle.acknowledges, vehicle.is_idle = False, True
    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        begin_s = network.clock.now_s()
        with pytest.raises(CaptureError, match="the camera does not respond") as caught:
            async with network.vehicle().interval(PERIOD_S, begin_s + 2.0):
                pass
        assert not isinstance(caught.value, NoIntervalError)
        assert network.clock.now_s() - begin_s == pytest.approx(3.0, abs=0.1)
    assert vehicle.sent(STOP)


async def test_the_camera_is_stopped_where_the_task_is_cancelled() -> None:
    vehicle = IntervalVehicle()

    async def watch(network: Network) -> None:
        async with network.vehicle().interval(PERIOD_S, network.clock.now_s() + 2.0) as images:
            while True:
                await take(network, images, 1)

    async with open_network(vehicle, fetcher=RecordedFetcher()) as network:
        await settle(network)
        watching = asyncio.create_task(watch(network))
        await network.clock.sleep(3.0)
        watching.cancel()
        await asyncio.wait([watching])
        assert watching.cancelled()
        assert vehicle.period_s == 0.0
        assert (await network.vehicle().capture(network.clock.now_s() + 5.0)).image_index >= 13
