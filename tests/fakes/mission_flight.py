"""Whole missions of the coordinator on the fake fleet, in virtual time."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from aos_gcs.airspace.separation import minimum_separation
from aos_gcs.clock import LoopClock
from aos_gcs.errors import RecordingError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.commands import LiveCommands
from aos_gcs.mission.coordinator import Coordinator
from aos_gcs.mission.former_flight import FormerFlight
from aos_gcs.mission.health import LoopMonitor
from aos_gcs.mission.journal import Journal, Recorder
from aos_gcs.mission.model.actions import Action, ActionRecord
from aos_gcs.mission.model.checks import PreflightCheck
from aos_gcs.mission.model.decisions import ConclusionRecord, DecisionRecord, SearchRecord
from aos_gcs.mission.model.events import Event
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord
from aos_gcs.mission.model.steps import Picture, StepRecord
from aos_gcs.mission.model.vehicles import SettingsRecord, Task
from aos_gcs.mission.next_sortie import NextSortie
from aos_gcs.mission.search.ground.mapping import GroundPlace
from aos_gcs.mission.views import LiveView
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import Deadlines, DetectionSettings, MissionSettings, PreflightSettings
from aos_gcs.ports import Capture, FlightMode, LandedState, Worker
from tests.fakes.fleet import ORIGIN, FakeFleet, FakeVehicle

TARGET = (4.0, 40.0)
EXACT = {"bias_m": (0.0, 0.0), "swing_m": (0.0, 0.0)}
"""No errors of positions: for tests whose expectations hang on ties, such as of two legs that are equally near."""


class InlineExecutor(ThreadPoolExecutor):
    """Runs at once what is submitted: a thread would let virtual time run on while it works."""

    def submit(self, function: Callable, /, *args: object, **kwargs: object) -> Future:
        future: Future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(repr=False)
class MemoryRecorder:
    """Keeps everything, and what had been flushed when.

    Without a ``repr`` of all that: asyncio asks the task for one that returns it, where a run of virtual time ends.
    """

    events: list[Event] = field(default_factory=list)
    frames: list[tuple[int, Capture]] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    steps: dict[int, StepRecord] = field(default_factory=dict)
    states: dict[int, Mapping[str, object]] = field(default_factory=dict)
    """States of the strategy by step."""
    searches: list[SearchRecord] = field(default_factory=list)
    decisions: dict[int, DecisionRecord] = field(default_factory=dict)
    conclusions: dict[int, ConclusionRecord] = field(default_factory=dict)
    actions: list[ActionRecord] = field(default_factory=list)
    settings: list[SettingsRecord] = field(default_factory=list)
    outcome: OutcomeRecord | None = None
    on_flush: Callable[[], None] | None = None
    is_stuck: bool = False
    """Whether the disk no longer answers."""
    is_full: bool = False
    """Whether nothing more can be kept, as on a full disk."""
    lost_before_flush: int = 0

    def _has_room(self) -> bool:
        self.lost_before_flush += self.is_full
        return not self.is_full

    async def record_event(self, event: Event) -> None:
        if self._has_room():
            self.events.append(event)

    async def record_frame(self, step: int, frame: Capture) -> None:
        if self._has_room():
            self.frames.append((step, frame))

    async def record_picture(self, picture: Picture) -> None:
        if self._has_room():
            self.pictures.append(picture)

    async def record_step(self, step: StepRecord, strategy_state: Mapping[str, object]) -> None:
        assert strategy_state
        if self._has_room():
            self.steps[step.step] = step
            self.states[step.step] = strategy_state

    async def record_search(self, search: SearchRecord) -> None:
        if self._has_room():
            self.searches.append(search)

    async def record_decision(self, decision: DecisionRecord) -> None:
        if self._has_room():
            self.decisions[decision.step] = decision

    async def record_conclusion(self, conclusion: ConclusionRecord) -> None:
        if self._has_room():
            self.conclusions[conclusion.step] = conclusion

    async def record_action(self, action: ActionRecord) -> None:
        if self.is_stuck:
            await asyncio.Event().wait()
        if self._has_room():
            self.actions.append(action)

    async def record_settings(self, settings: SettingsRecord) -> None:
        if self._has_room():
            self.settings.append(settings)

    async def record_outcome(self, outcome: OutcomeRecord) -> None:
        if self._has_room():
            self.outcome = outcome

    async def flush(self, *, frames: bool = True) -> None:  # noqa: ARG002
        if self.is_stuck:
            await asyncio.Event().wait()
        if self.on_flush is not None:
            self.on_flush()
        lost, self.lost_before_flush = self.lost_before_flush, 0
        if lost:
            raise RecordingError(f"{lost} records could not be kept")


def settings(n: int, **changes: object) -> MissionSettings:
    base = MissionSettings(
        vehicles=n,
        any_vehicles=True,
        area_enu_m=((-12.0, 10.0), (12.0, 10.0), (12.0, 70.0), (-12.0, 70.0)),
        imaging=ImagingSettings(rx_quantile=0.998),
        origin=ORIGIN,
        deadlines=Deadlines(connect_s=5.0, preflight_s=15.0, capture_s=5.0, transfer_s=60.0, land_s=60.0),
        preflight=PreflightSettings(upload_fence=True),
        search=SearchSettings(SearchMode.STOPS),
        detection=DetectionSettings(threshold_m2=0.3, found_min_count=2, stop_at_first=True),
        auto_start=True,
        auto_return=True,
    )
    return replace(base, **changes)


@dataclass
class Flight:
    mission: Coordinator
    fleet: FakeFleet
    recorder: MemoryRecorder
    clock: LoopClock
    journal: Journal
    pulse: LoopMonitor
    smallest_m: float = math.inf
    """Smallest true distance of two flying vehicles, as far as it was watched."""

    @property
    def view(self) -> LiveView:
        return self.mission.view

    @property
    def commands(self) -> LiveCommands:
        return self.mission.commands

    async def until(self, condition: Callable[[], bool]) -> None:
        async with self.clock.timeout_at(self.clock.now_s() + 600.0):
            while not condition():
                await self.clock.sleep(0.05)

    async def watch_separation(self) -> None:
        """Compare the true positions of the vehicles until cancelled; keep the smallest distance of two that fly."""
        while True:
            flying = [one.true_enu_m() for one in self.fleet.members.values() if one.state.landed is LandedState.IN_AIR]
            if len(flying) > 1:
                self.smallest_m = min(self.smallest_m, minimum_separation(np.array(flying))[0])
            await self.clock.sleep(0.1)

    def texts(self) -> list[str]:
        return [event.data.text for event in self.recorder.events if event.kind == "notice"]

    def check(self, vehicle_id: int, name: str) -> PreflightCheck:
        found = {(check.vehicle_id, check.name): check for check in self.view.snapshot().preflight}
        return found[vehicle_id, name]

    def task(self, vehicle_id: int) -> Task:
        return self.view.snapshot().vehicles[vehicle_id - 1].task


def prepare(
    n: int = 4,
    target: tuple[float, float] | None = TARGET,
    *,
    errors: Mapping[str, object] | None = None,
    worker: Worker | None = None,
    former: FormerFlight | None = None,
    unrestored: Mapping[int, Mapping[str, float]] | None = None,
    following: NextSortie | None = None,
    ground: GroundPlace | None = None,
    pictures: bool = False,
    camera_delay_s: float = 0.0,
    recorder: Recorder | None = None,
    **changes: object,
) -> Flight:
    """Return a mission of n vehicles whose ``errors``, fields of :class:`FakeErrors`, differ from those of RTK.

    ``pictures`` for operators are left out unless a test looks at them: they take a quarter of a mission's work. Where
    a test waits for time to pass, cameras with a delay make fewer steps of it. ``recorder`` takes the place of the one
    in memory.
    """
    asyncio.get_running_loop().set_default_executor(InlineExecutor(1))
    clock = LoopClock()
    fleet, journal = FakeFleet(clock, n, target, errors), Journal(clock)
    recorder = MemoryRecorder() if recorder is None else recorder
    for vehicle in fleet.members.values():
        vehicle.camera_delay_s = camera_delay_s
    pulse = LoopMonitor(period_s=0.5)
    mission = Coordinator(
        "m",
        following.settings if following is not None else settings(n, **changes),
        fleet=fleet,
        clock=clock,
        journal=journal,
        recorder=recorder,
        loop_monitor=pulse,
        imaging=worker,
        former=former,
        unrestored=unrestored,
        following=following,
        ground=ground,
        pictures=pictures,
    )
    return Flight(mission, fleet, recorder, clock, journal, pulse)


@asynccontextmanager
async def flying(flight: Flight) -> AsyncIterator[asyncio.Task[Outcome]]:
    async with flight.journal.recorded(flight.recorder), asyncio.TaskGroup() as group:
        run = group.create_task(flight.mission.run())
        yield run


def take_over(vehicle: FakeVehicle, mode: FlightMode = FlightMode.HOLD) -> int:
    """Have a pilot stop a vehicle, hovering unless another mode is named; return how many commands it has been sent."""
    vehicle.fly_to(vehicle.position_enu_m())
    vehicle.mode, vehicle.taken_over = mode, "its mode changed to LOITER"
    return len(vehicle.commands)


def lose(vehicle: FakeVehicle) -> None:
    vehicle.silent_since_s = vehicle.clock.now_s()


async def ask_for_another(flight: Flight) -> NextSortie:
    """Ask for a new sortie after the end of a mission, as the service waits for it, and return its beginning."""
    async with flight.journal.recorded(flight.recorder):
        staying = asyncio.create_task(flight.mission.stay())
        await flight.clock.sleep(1.0)
        await flight.commands.act(Action.NEW_SORTIE, None, operator="Ada")
        following = await staying
    assert following is not None
    return following
