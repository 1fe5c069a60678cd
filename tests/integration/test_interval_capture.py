"""Whole continuous searches of the real driver, whose simulated cameras take images by themselves. In virtual time."""

from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.mission.model.phase import Outcome
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_sim.camera.component import CameraComponent
from tests.fakes.air import Air, Faults
from tests.fakes.air_flight import AirFlight, flying_over

pytestmark = pytest.mark.looptime

CONTINUOUS = SearchSettings(SearchMode.CONTINUOUS)
PERIOD_S = 0.5


def cameras(flight: AirFlight) -> list[CameraComponent]:
    return [vehicle.camera for vehicle in flight.swarm.vehicles if isinstance(vehicle.camera, CameraComponent)]


def take_by_themselves(flight: AirFlight) -> list[bool]:
    return [camera.takes_interval for camera in cameras(flight)]


def times_in_flight_s(flight: AirFlight, vehicle_id: int) -> list[float]:
    """Return the times of the images of a vehicle that were taken before the first close look, in order."""
    steps = flight.recorder.steps
    last = next((number for number, step in steps.items() if step.branch != "sweep" and number > 3), len(steps))
    frames = [one for step, one in flight.recorder.frames if one.vehicle_id == vehicle_id and step <= last]
    return sorted(one.utc_s for one in frames)


def sweeps(flight: AirFlight) -> int:
    return sum(step.branch == "sweep" for step in flight.mission.view.steps())


async def test_a_search_takes_the_images_of_intervals_and_stops_the_cameras(monkeypatch: pytest.MonkeyPatch) -> None:
    async with flying_over(monkeypatch, Air(), search=CONTINUOUS) as flight:
        await flight.until(lambda: sweeps(flight) >= 3)
        assert take_by_themselves(flight) == [True] * 3
        assert await flight.run is Outcome.FOUND
        assert take_by_themselves(flight) == [False] * 3
        flight.assert_nobody_was_endangered()
        apart_s = np.diff(times_in_flight_s(flight, 2))
    assert np.median(apart_s) == pytest.approx(PERIOD_S, abs=0.05)
    assert not any("interval" in text for text in flight.texts())


async def test_where_another_station_stops_a_camera_its_images_are_requested(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.fakes.air_flight.TARGET_ENU_M", (500.0, 500.0))
    async with flying_over(monkeypatch, Air(), search=CONTINUOUS) as flight:
        await flight.until(lambda: sweeps(flight) >= 3)
        stop = mavlink.MAVLink_command_long_message(1, 100, mavlink.MAV_CMD_IMAGE_STOP_CAPTURE, 0, *[0.0] * 7)
        cameras(flight)[0].handle(stop, flight.swarm.now)
        assert await flight.run is Outcome.NOT_FOUND
    told = [text for text in flight.texts() if "interval" in text]
    assert told == ["each image of its camera is requested, without interval capture: another station has stopped it"]


@pytest.mark.slow
@pytest.mark.parametrize("autopilot", ["arducopter", "px4"])
async def test_lost_messages_and_disorder_keep_no_search_from_its_end(
    monkeypatch: pytest.MonkeyPatch, autopilot: str
) -> None:
    air = Air(Faults(loss=0.2, duplicate=0.1, reorder=0.1, latency_s=0.2))
    patience = {"FS_GCS_TIMEOUT": 60.0} if autopilot == "arducopter" else {}
    async with flying_over(monkeypatch, air, search=CONTINUOUS, autopilot=autopilot, parameters=patience) as flight:
        assert await flight.run is Outcome.FOUND
        assert take_by_themselves(flight) == [False] * 3
        flight.assert_nobody_was_endangered()
        for vehicle_id in (1, 2, 3):
            frames = [one for _, one in flight.recorder.frames if one.vehicle_id == vehicle_id]
            assert len({one.image_index for one in frames}) == len(frames), "no image twice"
