"""Missions that forget what they have seen: figures, pictures, the wanted probability and the next sortie."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar

import pytest

from aos_gcs.groundmap.work import GroundReport
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.mission.search.ground.mapping import GroundPlace
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import ForestSettings
from aos_gcs.ports import ThreadWorker
from tests.fakes.mission_flight import EXACT, Flight, flying, prepare
from tests.fakes.retraced import check_decisions_again

pytestmark = pytest.mark.virtual
P = ParamSpec("P")
T = TypeVar("T")

FOREST = ForestSettings(canopy_height_m=18.0, crown_base_m=5.0)
AREA = ((-12.0, 10.0), (12.0, 10.0), (12.0, 46.0), (-12.0, 46.0))


class Noting:
    """Worker that notes the probabilities of detection that are told."""

    def __init__(self) -> None:
        self.detections: list[float] = []

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        result = await ThreadWorker().run(function, *args, **kwargs)
        if isinstance(result, GroundReport):
            assert result.figures.detection is not None
            self.detections.append(result.figures.detection.standing)
        return result


def forgetful(folder: Path, forget_min: float | None, worker: Noting, **changes: object) -> Flight:
    """A search of two vehicles on two legs for a probability of detection."""
    search = SearchSettings(SearchMode.CONTINUOUS, pod=0.97, leg_spacing_m=12.0, forget_min=forget_min)
    place = GroundPlace(worker, folder)
    return prepare(2, None, area_enu_m=AREA, forest=FOREST, search=search, errors=EXACT, ground=place, **changes)


async def test_the_probability_falls_with_time_and_the_search_still_ends(tmp_path: Path) -> None:
    told = {}
    for forget_min in (None, 0.1):
        worker = Noting()
        flight = forgetful(tmp_path / str(forget_min), forget_min, worker)
        async with flying(flight) as run:
            await run
        told[forget_min] = worker.detections
        ground = flight.view.snapshot().ground
        assert ground is not None
        assert ground.detection is not None
        assert ground.detection.standing == worker.detections[-1]
        check_decisions_again(flight.recorder)
    kept, forgotten = told[None], told[0.1]
    assert kept == sorted(kept)
    assert kept[-1] >= 0.97
    assert forgotten[-1] < max(forgotten) < 0.97
    assert any("gained little of what was expected: the search ends" in text for text in flight.texts())


async def test_a_map_that_goes_on_is_forgotten_before_the_start_by_the_time_of_day(tmp_path: Path) -> None:
    first = forgetful(tmp_path / "one", 1.0, Noting())
    async with flying(first) as run:
        await first.until(lambda: len(first.view.steps()) >= 3)
        await first.commands.act(Action.RETURN, None)
        await run
    worker = Noting()
    place = GroundPlace(worker, tmp_path / "two", carried=tmp_path / "one")
    search = SearchSettings(forget_min=1.0)
    second = prepare(
        2, None, area_enu_m=AREA, forest=FOREST, search=search, auto_start=False, ground=place, pictures=True
    )
    async with flying(second) as run:
        await second.until(lambda: second.mission.phase is Phase.READY)
        before = second.view.picture(PictureKind.VIEWS)
        await second.until(lambda: worker.detections[-1] == 0.0)
        await second.clock.sleep(2.0)
        ground, after = second.view.snapshot().ground, second.view.picture(PictureKind.VIEWS)
        assert ground is not None
        assert ground.frames > 0
        assert ground.seen_fraction == 0.0
        assert worker.detections[0] > 0.0
        assert before is not None
        assert after is not None
        assert before.png != after.png
        await second.commands.act(Action.ABORT, None)
        await run
