"""Continuous searches whose cameras take images by themselves, and what becomes of the others. In virtual time."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.imaging.model import IntervalCapture
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.ports import Capture
from tests.fakes.fleet import FRAME, FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare

pytestmark = pytest.mark.virtual

AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 90.0), (-12.0, 90.0))
CAMERA_S = 0.6
"""Time from an exposure until its image is there."""
PERIOD_S, SPEED_MPS = 0.5, 5.0


def search(
    n: int = 3, interval_capture: IntervalCapture = IntervalCapture.AUTO, area: tuple[tuple[float, float], ...] = AREA
) -> Flight:
    flight = prepare(
        n,
        None,
        errors=EXACT,
        camera_delay_s=CAMERA_S,
        area_enu_m=area,
        search=SearchSettings(SearchMode.CONTINUOUS),
        imaging=ImagingSettings(rx_quantile=0.998, interval_capture=interval_capture),
    )
    for vehicle in flight.fleet.members.values():
        vehicle.has_interval = True
    return flight


LONG_AREA = (*AREA[:2], (12.0, 210.0), (-12.0, 210.0))


def is_on_its_way(flight: Flight) -> bool:
    return sum(step.branch == "sweep" for step in flight.view.steps()) >= 5


def exposures_north_m(flight: Flight, vehicle_id: int) -> list[float]:
    """Return where frames of a vehicle were exposed that a step has used, in the order of the steps."""
    used = [one for step, one in flight.recorder.frames if one.vehicle_id in flight.recorder.steps[step].fitness]
    return [float(FRAME.to_enu(one.position)[1]) for one in used if one.vehicle_id == vehicle_id]


def assert_looked_at_everywhere(
    flight: Flight, vehicle_ids: tuple[int, ...], most_m: float, area: tuple[tuple[float, float], ...] = AREA
) -> None:
    for vehicle_id in vehicle_ids:
        north_m = [area[0][1], *sorted(exposures_north_m(flight, vehicle_id)), area[2][1]]
        assert np.diff(north_m).max() <= most_m
    assert flight.view.snapshot().covered_fraction == 1.0


def told(flight: Flight, text: str) -> list[str]:
    return [one for one in flight.texts() if text in one]


async def test_cameras_that_take_images_by_themselves_keep_the_rate_although_images_take_longer_than_a_period() -> None:
    flight = search()
    async with flying(flight) as run:
        await flight.until(lambda: is_on_its_way(flight))
        assert [vehicle.running is not None for vehicle in flight.fleet.members.values()] == [True] * 3
        assert await run is Outcome.NOT_FOUND
    assert [vehicle.running for vehicle in flight.fleet.members.values()] == [None] * 3, "all were stopped"
    assert_looked_at_everywhere(flight, (1, 2, 3), 6.0)
    apart_m = np.diff(exposures_north_m(flight, 2)[3:-3])
    assert np.median(apart_m) == pytest.approx(PERIOD_S * SPEED_MPS, abs=0.05)
    assert not told(flight, "instead of")
    assert not told(flight, "left out")


async def test_the_line_keeps_its_speed_although_each_image_is_on_its_way_for_longer_than_a_second() -> None:
    durations_s = {}
    for interval_capture in IntervalCapture:
        flight = search(interval_capture=interval_capture)
        for vehicle in flight.fleet.members.values():
            vehicle.camera_delay_s = 1.2
        async with flying(flight) as run:
            assert await run is Outcome.NOT_FOUND
        slow = [text for text in told(flight, "so that no ground is left out") if "every 1.2 s instead" in text]
        assert bool(slow) is (interval_capture is IntervalCapture.OFF)
        assert_looked_at_everywhere(flight, (1, 2, 3), 10.0)
        swept_s = [step.elapsed_s for step in flight.recorder.steps.values() if step.branch == "sweep"]
        durations_s[interval_capture] = swept_s[-1] - swept_s[0]
    assert durations_s[IntervalCapture.AUTO] < 0.75 * durations_s[IntervalCapture.OFF]


async def test_where_it_is_switched_off_each_image_is_requested() -> None:
    flight = search(interval_capture=IntervalCapture.OFF)
    async with flying(flight) as run:
        await flight.until(lambda: is_on_its_way(flight))
        assert [vehicle.running for vehicle in flight.fleet.members.values()] == [None] * 3
        assert await run is Outcome.NOT_FOUND
    apart_m = np.diff(exposures_north_m(flight, 2)[3:-3])
    assert np.median(apart_m) == pytest.approx(CAMERA_S * SPEED_MPS, abs=0.3)
    assert not told(flight, "without interval capture")


async def test_a_camera_that_refuses_is_named_once_and_asked_for_each_image() -> None:
    flight = search()
    flight.fleet.members[3].has_interval = False
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    refused = "each image of its camera is requested, without interval capture: the camera has none"
    assert told(flight, "without interval capture") == [refused]
    assert_looked_at_everywhere(flight, (1, 2, 3), 10.0)


async def test_a_camera_that_another_station_stops_is_named_and_asked_for_each_image() -> None:
    flight = search()
    vehicle = flight.fleet.members[3]
    async with flying(flight) as run:
        await flight.until(lambda: is_on_its_way(flight))
        assert vehicle.running is not None
        vehicle.running.ended = "another station has stopped it"
        assert await run is Outcome.NOT_FOUND
    assert len(told(flight, "without interval capture: another station has stopped it")) == 1
    assert_looked_at_everywhere(flight, (1, 2, 3), 10.0)


async def test_a_camera_with_a_long_least_interval_is_named_and_asked_for_each_image_instead() -> None:
    flight = search(area=LONG_AREA)
    flight.fleet.members[3].least_period_s = 1.0 / 0.3
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    (named,) = told(flight, "without interval capture")
    assert "0.3 images per second instead of 2" in named
    assert not told(flight, "its camera delivers"), "asked for each, it is as fast as others"
    assert_looked_at_everywhere(flight, (1, 2), 6.0, LONG_AREA)
    north_m = sorted(exposures_north_m(flight, 3))
    assert np.median(np.diff(north_m[len(north_m) // 2 :])) < 4.0


async def test_a_camera_that_was_slow_for_a_while_takes_images_by_itself_again() -> None:
    flight = search(area=(*AREA[:2], (12.0, 500.0), (-12.0, 500.0)))
    vehicle = flight.fleet.members[3]
    vehicle.least_period_s = 1.0 / 0.3
    async with flying(flight) as run:
        await flight.until(lambda: bool(told(flight, "without interval capture")))
        vehicle.least_period_s = 0.0
        await flight.until(lambda: vehicle.running is None)
        await flight.until(lambda: vehicle.running is not None)
        await flight.clock.sleep(5.0)
        assert vehicle.running is not None
        await flight.commands.act(Action.ABORT, None)
        await run
    assert len(told(flight, "interval capture")) == 1


async def test_images_that_come_late_or_out_of_order_keep_nothing_waiting_and_count_where_they_were_exposed() -> None:
    flight = search()
    vehicle = flight.fleet.members[3]
    take = vehicle._expose

    def expose() -> Capture | None:
        """Each third image comes late, after those that follow it, and each seventh not at all."""
        object.__setattr__(vehicle, "camera_delay_s", 1.9 if vehicle.images % 3 == 0 else CAMERA_S)
        capture = take()
        return None if vehicle.images % 7 == 0 else capture

    object.__setattr__(vehicle, "_expose_if_it_works", expose)
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    assert_looked_at_everywhere(flight, (1, 2, 3), 10.0)
    north_m = exposures_north_m(flight, 3)
    assert north_m != sorted(north_m)
    assert len(north_m) == len(set(north_m))
    assert np.median(np.diff(exposures_north_m(flight, 2)[3:-3])) == pytest.approx(PERIOD_S * SPEED_MPS, abs=0.05)


async def test_a_vehicle_that_leaves_the_swarm_takes_no_images_by_itself_any_more() -> None:
    flight = search(4)
    leaving: FakeVehicle = flight.fleet.members[4]
    async with flying(flight) as run:
        await flight.until(lambda: is_on_its_way(flight))
        await flight.commands.act(Action.RETURN, (4,))
        await flight.until(lambda: leaving.running is None)
        assert flight.fleet.members[1].running is not None
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        assert [vehicle.running for vehicle in flight.fleet.members.values()] == [None] * 4
        await run


async def test_a_hold_of_all_stops_the_cameras_and_they_begin_again_with_the_search() -> None:
    flight = search()
    cameras = flight.fleet.members.values()
    async with flying(flight) as run:
        await flight.until(lambda: is_on_its_way(flight))
        await flight.commands.act(Action.HOLD, None)
        await flight.until(lambda: all(vehicle.running is None for vehicle in cameras))
        await flight.commands.act(Action.RESUME, None)
        await flight.until(lambda: all(vehicle.running is not None for vehicle in cameras))
        assert await run is Outcome.NOT_FOUND
    assert_looked_at_everywhere(flight, (1, 2, 3), 10.0)
