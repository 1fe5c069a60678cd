"""The map of searched ground in missions: fed while they fly, kept in the folder, carried on, never in their way."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import pytest

from aos_gcs.errors import WorkerError
from aos_gcs.geometry.projection import Plane
from aos_gcs.groundmap import floor
from aos_gcs.groundmap.ground_map import read_header
from aos_gcs.groundmap.work import GroundReport
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.mission.search.ground.mapping import MAX_WAITING, GroundMapping, GroundPlace
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import ForestSettings
from aos_gcs.ports import ThreadWorker
from tests.fakes.fleet import FRAME
from tests.fakes.ground_frames import ground_frame
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare
from tests.fakes.retraced import check_decisions_again

pytestmark = pytest.mark.virtual
P = ParamSpec("P")
T = TypeVar("T")

FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=5.0)


class Mapper:
    """Worker that computes in a thread, if it is not told to fail or to wait."""

    def __init__(self) -> None:
        self.reports: list[GroundReport] = []
        self.failure: Exception | None = None
        self.is_free = asyncio.Event()
        self.is_free.set()

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        await self.is_free.wait()
        if self.failure:
            raise self.failure
        result = await ThreadWorker().run(function, *args, **kwargs)
        if isinstance(result, GroundReport):
            self.reports.append(result)
        return result


async def search(flight: Flight, steps: int) -> None:
    """Fly until so many steps are made, and send all home."""
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is not Phase.CONNECT)
        if not flight.mission.auto_start.is_on:
            await flight.until(lambda: flight.mission.phase is Phase.READY)
            await flight.commands.act(Action.START, None)
        await flight.until(lambda: len(flight.view.steps()) >= steps)
        await flight.commands.act(Action.RETURN, None)
        await run


def mapping_of(flight: Flight) -> GroundMapping:
    return flight.mission._ground


async def test_what_a_mission_searches_is_on_the_map_and_on_the_disk(tmp_path: Path) -> None:
    place = GroundPlace(ThreadWorker(), tmp_path / "ground")
    flight = prepare(3, target=None, pictures=True, forest=FOREST, ground=place)
    await search(flight, 3)
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.left_out == 0
    assert ground.frames == sum(len(step.fitness) for step in flight.view.steps()) >= 9
    assert 0.0 < ground.seen_fraction <= 1.0
    assert ground.mean_views > 0.0
    assert ground.detection is not None
    assert 0.0 < ground.detection.standing < ground.detection.lying < 1.0
    kinds = {picture.kind for picture in flight.recorder.pictures}
    assert {PictureKind.VIEWS, PictureKind.DETECTION, PictureKind.FLOOR} <= kinds
    assert read_header(place.folder).frames == ground.frames


async def test_without_a_described_forest_views_are_counted_and_nothing_is_promised(tmp_path: Path) -> None:
    flight = prepare(3, target=None, pictures=True, ground=GroundPlace(ThreadWorker(), tmp_path))
    await search(flight, 1)
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.detection is None
    assert flight.view.picture(PictureKind.VIEWS) is not None
    assert flight.view.picture(PictureKind.DETECTION) is None


async def test_the_next_sortie_shows_the_map_before_it_starts_and_adds_to_it(tmp_path: Path) -> None:
    first = prepare(3, target=None, pictures=True, ground=GroundPlace(ThreadWorker(), tmp_path / "one"))
    await search(first, 2)
    async with first.journal.recorded(first.recorder):
        staying = asyncio.create_task(first.mission.stay())
        await first.clock.sleep(1.0)
        await first.commands.act(Action.NEW_SORTIE, None)
        following = await staying
    assert following is not None
    assert following.former_id == "m"
    frames = read_header(tmp_path / "one").frames
    place = GroundPlace(ThreadWorker(), tmp_path / "two", carried=tmp_path / "one")
    second = prepare(3, target=None, following=following, pictures=True, ground=place)
    async with flying(second) as run:
        await second.until(lambda: second.mission.phase is Phase.READY)
        ground = second.view.snapshot().ground
        assert ground is not None
        assert ground.frames == frames
        assert second.view.picture(PictureKind.VIEWS) is not None
        assert second.view.picture(PictureKind.FLOOR) is not None
        await second.commands.act(Action.START, None)
        await second.until(lambda: len(second.view.steps()) >= 1)
        await second.commands.act(Action.RETURN, None)
        await run
    assert read_header(tmp_path / "two").frames > frames
    assert read_header(tmp_path / "one").frames == frames


async def test_a_flight_that_is_taken_up_goes_on_with_its_map_and_another_does_not(tmp_path: Path) -> None:
    first = prepare(3, target=None, ground=GroundPlace(ThreadWorker(), tmp_path / "one"))
    await search(first, 2)
    frames = read_header(tmp_path / "one").frames
    for is_taken_up in (False, True):
        place = GroundPlace(ThreadWorker(), tmp_path / f"two {is_taken_up}", interrupted=tmp_path / "one")
        second = prepare(3, target=None, auto_start=False, ground=place)
        async with flying(second) as run:
            await second.until(lambda flight=second: flight.mission.phase is Phase.READY)  # type: ignore[misc]
            if is_taken_up:
                mapping_of(second).take_up()
                await second.clock.sleep(1.0)
            ground = second.view.snapshot().ground
            assert ground is not None
            assert ground.frames == (frames if is_taken_up else 0)
            await second.commands.act(Action.ABORT, None)
            await run


async def test_a_former_floor_is_drawn_until_it_is_whole_also_before_the_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = prepare(3, target=None, ground=GroundPlace(ThreadWorker(), tmp_path / "one"))
    await search(first, 2)
    monkeypatch.setattr(floor, "READ_AT_ONCE", 1)
    mapper = Mapper()
    place = GroundPlace(mapper, tmp_path / "two", interrupted=tmp_path / "one")
    second = prepare(3, target=None, auto_start=False, pictures=True, ground=place)
    async with flying(second) as run:
        await second.until(lambda: second.mission.phase is Phase.READY)
        mapping_of(second).take_up()
        await second.until(lambda: len(mapper.reports) > 1 and mapper.reports[-1].is_floor_whole)
        await second.clock.sleep(5.0)
        drawn = [report for report in mapper.reports if report.floor is not None]
        assert [report.is_floor_whole for report in drawn] == [*[False] * (len(drawn) - 1), True]
        assert len(drawn) > 1
        assert second.view.picture(PictureKind.FLOOR) is not None
        await second.commands.act(Action.ABORT, None)
        await run


async def test_a_map_that_is_slow_delays_nothing_and_counts_what_it_leaves_out(tmp_path: Path) -> None:
    worker = Mapper()
    flight = prepare(3, target=None, ground=GroundPlace(worker, tmp_path))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        worker.is_free.clear()
        waiting = MAX_WAITING + 7
        for step in (1, 2, 3):
            mapping_of(flight).offer(step, [ground_frame(0.0, 30.0)] * waiting, Plane(0.0))
        await flight.until(lambda: len(flight.view.steps()) >= 4)
        assert not any("hold" in text.lower() for text in flight.texts())
        worker.is_free.set()
        await flight.commands.act(Action.RETURN, None)
        await run
    ground = flight.view.snapshot().ground
    assert ground is not None
    taken = sum(len(step.fitness) for step in flight.view.steps())
    assert waiting <= ground.frames
    assert 2 * waiting <= ground.left_out < 2 * waiting + taken, "a whole step fits, older ones do not"
    assert ground.frames + ground.left_out == taken + 3 * waiting
    assert sum("cannot keep up" in text for text in flight.texts()) == 1


@pytest.mark.parametrize("failure", [WorkerError("it has ended (SIGKILL)"), ZeroDivisionError("division by zero")])
async def test_a_map_that_fails_is_reported_once_and_the_mission_goes_on(tmp_path: Path, failure: Exception) -> None:
    worker = Mapper()
    flight = prepare(3, target=None, ground=GroundPlace(worker, tmp_path))
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) >= 1)
        worker.failure = failure
        await flight.until(lambda: len(flight.view.steps()) >= 4)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert sum(f"not up to date: {failure}" in text for text in flight.texts()) == 1
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.left_out >= 6


async def test_frames_that_are_lost_with_the_process_are_named(tmp_path: Path) -> None:
    worker = Mapper()
    flight = prepare(3, target=None, ground=GroundPlace(worker, tmp_path / "one"))
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) >= 2)
        # A new process knows what is on the disk alone; here, nothing.
        mapping = mapping_of(flight)
        mapping._place = GroundPlace(worker, tmp_path / "two")
        await flight.until(lambda: len(flight.view.steps()) >= 3)
        await flight.commands.act(Action.RETURN, None)
        await run
    assert any("lost frames with its process" in text for text in flight.texts())
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.frames + ground.left_out == sum(len(step.fitness) for step in flight.view.steps())


async def test_a_disk_that_takes_nothing_is_reported_and_the_map_goes_on(tmp_path: Path) -> None:
    folder = tmp_path / "ground"
    folder.write_text("in the way", "utf-8")
    flight = prepare(3, target=None, ground=GroundPlace(ThreadWorker(), folder))
    await search(flight, 2)
    assert any("cannot be written" in text for text in flight.texts())
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.frames > 0


def continuous(pod: float, **changes: object) -> Flight:
    """A search of two vehicles on two legs for a probability of detection."""
    search = SearchSettings(SearchMode.CONTINUOUS, pod=pod, leg_spacing_m=12.0)
    area = ((-12.0, 10.0), (12.0, 10.0), (12.0, 26.0), (-12.0, 26.0))
    return prepare(2, None, area_enu_m=area, forest=FOREST, search=search, errors=EXACT, **changes)


async def test_the_likely_strip_is_flown_first(tmp_path: Path) -> None:
    begun_m = []
    for west_m, east_m in ((-12.0, 0.0), (0.0, 12.0)):
        corners = ((west_m, 10.0), (east_m, 10.0), (east_m, 26.0), (west_m, 26.0))
        places = [FRAME.to_geodetic((*corner, 0.0)) for corner in corners]
        ring = [[place.longitude_deg, place.latitude_deg] for place in (*places, places[0])]
        geometry = {"type": "Polygon", "coordinates": [ring]}
        prior = tmp_path / f"{east_m:g}.geojson"
        properties = {"weight": 1, "name": "likely"}
        prior.write_text(json.dumps({"type": "Feature", "properties": properties, "geometry": geometry}), "utf-8")
        search = SearchSettings(SearchMode.CONTINUOUS, leg_spacing_m=12.0, prior=str(prior), segments=str(prior))
        area = ((-12.0, 10.0), (12.0, 10.0), (12.0, 26.0), (-12.0, 26.0))
        place = GroundPlace(ThreadWorker(), tmp_path / f"ground {east_m:g}")
        flight = prepare(
            2, None, area_enu_m=area, search=search, errors=EXACT, forest=FOREST, ground=place, pictures=True
        )
        async with flying(flight) as run:
            await flight.until(lambda flight=flight: flight.mission.phase is Phase.SCAN)  # type: ignore[misc]
            begun_m.append(flight.mission.sortie.search.decider.progress.present_leg.start_enu_m[0])
            prior.unlink()  # the file was read before the take-off
            await run
        assert not any("prior" in text for text in flight.texts())
        picture = flight.view.picture(PictureKind.PRIOR)
        assert picture is not None
        assert (picture.west_m, picture.north_m) == (-12.0, 26.0)
        assert sum(one.kind is PictureKind.PRIOR for one in flight.recorder.pictures) == 1
        assert len(flight.mission.sortie.search.decider.progress.legs) == 2
        ground = flight.view.snapshot().ground
        assert ground is not None
        assert ground.seen_fraction == 1.0, "the unlikely strip, too"
        (segment,) = ground.segments
        assert (segment.name, segment.seen_fraction) == ("likely", 1.0)
        assert segment.probability == pytest.approx(1.0, abs=0.01)
        assert segment.success == pytest.approx(ground.success)
        assert segment.success == pytest.approx(segment.detection, abs=0.05)
        check_decisions_again(flight.recorder)
    assert begun_m == pytest.approx([-6.0, 6.0])


async def test_for_a_wanted_probability_the_line_mixes_low_and_high_layers() -> None:
    area = ((-12.0, 10.0), (12.0, 10.0), (12.0, 26.0), (-12.0, 26.0))
    search = SearchSettings(SearchMode.CONTINUOUS, pod=0.9)
    flight = prepare(3, None, area_enu_m=area, forest=FOREST, search=search, errors=EXACT)
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.SCAN)
        vehicles = flight.view.snapshot().vehicles
        await flight.commands.act(Action.RETURN, None)
        await run
    places = [(one.position_enu_m[0], one.layer_height_m) for one in vehicles if one.position_enu_m is not None]
    assert [layer_m for _, layer_m in sorted(places)][1] == 40.0, "the highest one is in the middle"


async def test_gaps_are_flown_again_until_what_is_wanted_is_reached(tmp_path: Path) -> None:
    flight = continuous(0.97, ground=GroundPlace(ThreadWorker(), tmp_path / "ground"))
    async with flying(flight) as run:
        await run
    again = next(text for text in flight.texts() if "flown again" in text)
    assert "(97% wanted)" in again
    progress = flight.mission.sortie.search.decider.progress
    assert len(progress.legs) > len(progress.planned_legs) == 2
    ground = flight.view.snapshot().ground
    assert ground is not None
    assert ground.detection is not None
    before = float(again.split("%")[0].split()[-1]) / 100.0
    assert ground.soon is None or ground.soon > before
    assert ground.detection.standing > before
    check_decisions_again(flight.recorder)


async def test_a_search_ends_before_its_last_leg_once_what_is_wanted_is_reached(tmp_path: Path) -> None:
    flight = continuous(0.05, ground=GroundPlace(ThreadWorker(), tmp_path / "ground"))
    async with flying(flight) as run:
        await run
    assert any("(5% wanted): the legs that are left are not flown" in text for text in flight.texts())
    assert flight.mission.sortie.search.decider.progress.leg == 1
