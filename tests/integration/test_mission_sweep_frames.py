"""Frames that are missing, late or lost in a continuous search: nobody counts as having looked. In virtual time."""

from __future__ import annotations

import logging
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import CaptureError
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.ports import Capture, Notice
from aos_gcs.store import recorder as store
from aos_gcs.store.database import MissionDatabase, Write
from aos_gcs.store.reader import MissionReader
from tests.fakes.fleet import FRAME, FakeVehicle
from tests.fakes.mission_flight import EXACT, Flight, InlineExecutor, flying, prepare

pytestmark = pytest.mark.virtual

NORTH_M = (10.0, 60.0)
AREA = ((-10.0, NORTH_M[0]), (10.0, NORTH_M[0]), (10.0, NORTH_M[1]), (-10.0, NORTH_M[1]))
SLOW_CAMERA_S = 1.0 / 0.3
IN_FLIGHT = 5
"""Step at which the line flies along its leg."""


def search(
    camera_delay_s: float = 0.6, area_enu_m: tuple[tuple[float, float], ...] = AREA, recorder: Recorder | None = None
) -> Flight:
    return prepare(
        3,
        None,
        errors=EXACT,
        camera_delay_s=camera_delay_s,
        area_enu_m=area_enu_m,
        search=SearchSettings(SearchMode.CONTINUOUS),
        recorder=recorder,
    )


def exposures_north_m(flight: Flight, vehicle_ids: tuple[int, ...]) -> list[float]:
    """Return where the frames of vehicles were exposed that a step has used, in order."""
    used = [one for step, one in flight.recorder.frames if one.vehicle_id in flight.recorder.steps[step].fitness]
    return sorted(float(FRAME.to_enu(one.position)[1]) for one in used if one.vehicle_id in vehicle_ids)


def assert_looked_at_everywhere(
    flight: Flight, vehicle_ids: tuple[int, ...] = (1, 2, 3), end_m: float = NORTH_M[1]
) -> None:
    """Assert that frames of these vehicles were taken all along the leg, which counts as scanned."""
    north_m = [NORTH_M[0], *exposures_north_m(flight, vehicle_ids), end_m]
    assert np.diff(north_m).max() <= 10.0
    assert flight.view.snapshot().covered_fraction == 1.0
    assert "Scan complete: the whole area was scanned, nothing was found" in flight.texts()


def missing_reasons(flight: Flight, vehicle_id: int) -> list[str]:
    """Return why frames of a vehicle are missing in the steps, in order."""
    return [step.missing[vehicle_id] for step in flight.view.steps() if vehicle_id in step.missing]


def replace_capture(vehicle: FakeVehicle, capture: object) -> None:
    object.__setattr__(vehicle, "capture", capture)


async def test_cameras_of_less_than_a_frame_in_three_seconds_make_the_line_stop_for_each() -> None:
    flight = search(SLOW_CAMERA_S, (*AREA[:2], (10.0, 30.0), (-10.0, 30.0)))
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
    assert "No frame has come in flight for 3 s (no image yet): the search goes on with stops" in flight.texts()
    assert np.diff(exposures_north_m(flight, (1, 2, 3))).max() <= 4.0
    assert flight.view.snapshot().covered_fraction == 1.0


async def test_one_slow_camera_delays_nobody_and_its_frames_count_where_they_were_exposed() -> None:
    end_m = 130.0
    flight = search(area_enu_m=(*AREA[:2], (AREA[2][0], end_m), (AREA[3][0], end_m)))
    flight.fleet.members[3].camera_delay_s = SLOW_CAMERA_S
    async with flying(flight) as run:
        assert await run is Outcome.NOT_FOUND
        camera = flight.view.snapshot().vehicles[2].camera
    assert not any("stops" in text for text in flight.texts())
    assert_looked_at_everywhere(flight, (1, 2), end_m)
    slow = exposures_north_m(flight, (3,))
    assert 2 <= len(slow) <= len(exposures_north_m(flight, (1,))) // 3
    assert camera is not None
    assert camera.failures
    assert "the line flies on without its frames: no image for 3 s" in flight.texts()
    assert flight.texts().count("its camera delivers 0.3 images per second instead of 2") == 1


async def test_frames_without_a_pose_are_named_and_counted_and_nobody_looked_there() -> None:
    flight = search()

    async def capture(deadline_s: float) -> Capture:  # noqa: ARG001
        await flight.clock.sleep(0.6)
        raise CaptureError("no pose within 0.5 s of its exposure")

    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == IN_FLIGHT)
        replace_capture(flight.fleet.members[3], capture)
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        camera = flight.view.snapshot().vehicles[2].camera
        await run
    named = [text for text in flight.texts() if "no pose within 0.5 s of its exposure" in text]
    assert len(named) == 1
    assert camera is not None
    assert camera.frames <= IN_FLIGHT + 1 < camera.failures
    assert max(exposures_north_m(flight, (3,))) < max(exposures_north_m(flight, (1,))) - 20.0
    assert_looked_at_everywhere(flight, (1, 2))


async def test_frames_that_come_late_and_in_a_burst_keep_their_places_and_hold_nobody_up() -> None:
    flight = search()
    vehicle, late = flight.fleet.members[3], []
    take = vehicle.capture

    async def capture(deadline_s: float) -> Capture:
        """Deliver nothing for a while, and then one frame after the other that was exposed long before."""
        frame = await take(deadline_s)
        if len(late) < 200:
            late.extend([frame] * 200)
            await flight.clock.sleep(4.0)
        return late[min(len(late) - 1, vehicle.images)]

    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == IN_FLIGHT)
        replace_capture(vehicle, capture)
        assert await run is Outcome.NOT_FOUND
    assert_looked_at_everywhere(flight, (1, 2))
    # However many there are of one place, they are one place.
    assert max(exposures_north_m(flight, (3,))) < max(exposures_north_m(flight, (1,))) - 20.0
    assert "the line flies on without its frames: no image for 4 s" in flight.texts()
    assert any("m from where it is: it came more than 6 s late" in one for one in missing_reasons(flight, 3))
    assert not any("behind the line" in text for text in flight.texts()), "its place is where it flies"


async def test_a_disk_that_is_full_in_flight_stops_nobody() -> None:
    flight = search()
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == IN_FLIGHT)
        flight.recorder.is_full = True
        assert await run is Outcome.NOT_FOUND
    assert flight.view.snapshot().covered_fraction == 1.0
    assert len(flight.view.steps()) > len(flight.recorder.steps)


async def test_a_disk_that_is_full_in_flight_is_named_once_and_the_search_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(store, "ThreadPoolExecutor", InlineExecutor)

    def write(_database: MissionDatabase, _writes: Sequence[Write]) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    def take(notice: Notice) -> None:
        flight.journal.take(notice)

    caplog.set_level(logging.INFO, "aos_gcs.mission.journal")
    async with store.MissionRecorder.create(tmp_path, "m", {}, notify=take) as recorder:
        flight = search(recorder=recorder)
        async with flying(flight) as run:
            await flight.until(lambda: len(flight.view.steps()) == IN_FLIGHT)
            monkeypatch.setattr(MissionDatabase, "write", write)
            assert await run is Outcome.NOT_FOUND
    assert flight.view.snapshot().covered_fraction == 1.0
    (named,) = [one for one in caplog.messages if "disk" in one]
    assert named == (
        f"The mission continues without recording: cannot record into {tmp_path / 'm'}: database or disk is full; free "
        "some space or check the disk."
    )
    with MissionReader(tmp_path / "m") as reader:
        assert IN_FLIGHT - 1 <= len(reader.steps()) <= IN_FLIGHT + 1 < len(flight.view.steps())
