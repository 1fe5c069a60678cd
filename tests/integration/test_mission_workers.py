"""A mission whose worker for images fails: the swarm holds, and goes on when the worker is back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ParamSpec, TypeVar

import pytest

from aos_gcs.errors import WorkerError
from aos_gcs.imaging.pictures import render_pictures
from aos_gcs.imaging.step.analysis import analyse_examined
from aos_gcs.imaging.step.examination import examine_all
from aos_gcs.mission.model.phase import Outcome, Phase
from aos_gcs.mission.search.ground.coverage import add_footprints
from aos_gcs.mission.search.targets.persons import watch_persons
from aos_gcs.ports import Goto, ThreadWorker
from tests.fakes.mission_flight import Flight, flying, prepare

pytestmark = pytest.mark.virtual

P = ParamSpec("P")
T = TypeVar("T")


@dataclass
class FailingWorker:
    """Fails the named calls of each function, counted from 1."""

    fails: dict[Callable, set[int]]
    calls: dict[Callable, int] = field(default_factory=dict)
    on_failure: Callable[[], None] = lambda: None

    async def run(self, function: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> T:
        self.calls[function] = self.calls.get(function, 0) + 1
        if self.calls[function] in self.fails.get(function, ()):
            self.on_failure()
            raise WorkerError("Image analysis has ended (SIGKILL)")
        return await ThreadWorker().run(function, *args, **kwargs)


def gotos(flight: Flight) -> int:
    return sum(isinstance(command, Goto) for vehicle in flight.fleet.members.values() for command in vehicle.commands)


@pytest.mark.parametrize("function", [analyse_examined, examine_all])
async def test_a_step_without_analysis_is_repeated_and_commands_nobody(function: Callable) -> None:
    seen: list[tuple[int, bool]] = []

    def note() -> None:
        seen.append((gotos(flight), any(vehicle.is_moving() for vehicle in flight.fleet.members.values())))

    flight = prepare(worker=FailingWorker({function: {3, 4}}, on_failure=note))
    async with flying(flight) as run:
        await flight.until(lambda: len(seen) == 2)
        assert seen[0] == seen[1], "nobody was sent anywhere"
        assert not seen[0][1], "nobody moves"
        assert await run is Outcome.FOUND
    text = "is repeated: Image analysis has ended (SIGKILL). Fault of this station; the swarm holds its position"
    assert [told for told in flight.texts() if text in told] == [f"Step {step} {text}" for step in (3, 4)]
    assert {3, 4}.isdisjoint(step.step for step in flight.view.steps())


async def test_frames_are_recorded_and_examined_while_another_is_awaited() -> None:
    worker = FailingWorker({})
    flight = prepare(worker=worker)
    flight.fleet.members[3].camera_delay_s = 2.0
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.recorder.frames) == 3)
        assert {frame.vehicle_id for _, frame in flight.recorder.frames} == {1, 2, 4}
        await flight.until(lambda: worker.calls.get(examine_all, 0) == 1)
        assert len(flight.recorder.frames) == 3, "the slow one is still awaited"
        assert analyse_examined not in worker.calls
        await flight.until(lambda: len(flight.view.steps()) == 1)
        run.cancel()
    assert {frame.vehicle_id for step, frame in flight.recorder.frames if step == 1} == {1, 2, 3, 4}
    assert flight.view.steps()[0].fitness.keys() == {1, 2, 3, 4}


async def test_a_worker_that_fails_every_time_ends_the_search() -> None:
    flight = prepare(worker=FailingWorker({analyse_examined: set(range(1, 100))}))
    async with flying(flight) as run:
        await flight.until(lambda: flight.mission.phase is Phase.RETURN)
        assert await run is Outcome.FAILED
    assert "No images could be analysed in 3 steps (Image analysis has ended (SIGKILL))." in flight.texts()
    assert not any(vehicle.armed for vehicle in flight.fleet.members.values())


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (render_pictures, "Step 2: no pictures"),
        (add_footprints, "Step 2: the map of coverage is not up to date"),
        (watch_persons, "Step 2: not all was learned from its images"),
    ],
)
async def test_what_only_informs_is_left_out(function: Callable, text: str) -> None:
    flight = prepare(worker=FailingWorker({function: {2}}), pictures=True)
    async with flying(flight) as run:
        assert await run is Outcome.FOUND
    assert [told for told in flight.texts() if text in told] == [f"{text}: Image analysis has ended (SIGKILL)"]
    assert [step.step for step in flight.view.steps()][:3] == [1, 2, 3]


@pytest.mark.parametrize("failures", [set(), {1, 2}])
async def test_footprints_of_a_failed_map_count_in_the_next_one(failures: set[int]) -> None:
    flight = prepare(target=None, worker=FailingWorker({add_footprints: failures}))
    async with flying(flight) as run:
        await flight.until(lambda: len(flight.view.steps()) == 4)
        assert flight.view.snapshot().covered_fraction == pytest.approx(0.4325, abs=0.005)
        run.cancel()
