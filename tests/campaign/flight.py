"""One mission of the campaign, from its launch until all vehicles are down."""

from __future__ import annotations

import asyncio
import gc
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from aos_gcs.errors import MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.runtime.simulated.virtual_time import run
from tests.campaign.faults.base import Fault
from tests.campaign.faults.station import Freeze
from tests.campaign.oracle import Violation
from tests.campaign.scenario import Scenario
from tests.campaign.station import Station
from tests.campaign.world import World

_MEMORY = Path("/dev/shm")  # noqa: S108 - the folder's name is random
"""Folder in which files do not wait for a disk."""
PREFLIGHT_S = 60.0
PATIENCE_S = 75.0
"""Time from the launch after which an operator ends the mission."""
STAGE_S = 50.0
"""Time that each of the operator's further orders has."""


@dataclass(frozen=True)
class FlightVerdict:
    """Result of one mission."""

    scenario: Scenario
    violations: tuple[Violation, ...]
    refused: str = ""
    """Reason why it was not launched."""
    outcome: str = ""
    smallest_m: float | None = None
    duration_s: float = 0.0
    trace: tuple[str, ...] = field(default=(), repr=False)
    """Notices and faults with their times."""


def fly(scenario: Scenario) -> FlightVerdict:
    """Fly a scenario in virtual time."""
    gc.collect()  # what others have left unfinished is reported when it is collected: before this mission, not in it
    with tempfile.TemporaryDirectory(prefix="campaign-", dir=_MEMORY if _MEMORY.is_dir() else None) as folder:
        try:
            return run(_fly(scenario, Path(folder)))
        except Exception as error:  # whatever it is: the other missions go on
            return FlightVerdict(scenario, (Violation("exception", 0.0, f"the mission broke off: {error!r}"),))


async def _fly(scenario: Scenario, folder: Path) -> FlightVerdict:
    trace: list[str] = []
    can_freeze = any(isinstance(fault, Freeze) for fault in scenario.faults)
    world = World(
        scenario.swarm_options(),
        scenario.settings(),
        folder,
        scenario.seed,
        can_freeze=can_freeze,
    )
    refused, outcome = "", ""
    async with world:
        await world.start_station()
        station = world.station
        assert station is not None
        collector = asyncio.create_task(_collect(world, trace))
        await _until(world, lambda: station.has_launched or station.is_over, PREFLIGHT_S)
        if not station.has_launched or station.is_over:
            refused = station.journal.message
        else:
            world.launched_at_s = world.clock.now_s()
            faults = [asyncio.create_task(_occur(world, fault, trace)) for fault in scenario.faults]
            await _bring_down(world)
            for task in faults:
                task.cancel()
            for result in await asyncio.gather(*faults, return_exceptions=True):
                if isinstance(result, Exception):
                    raise result
        outcome = str(station.mission.outcome)
        collector.cancel()
        duration_s = world.now_s()
    violations = tuple(world.oracle.violations.values())
    return FlightVerdict(scenario, violations, refused, outcome, world.oracle.smallest_m, duration_s, tuple(trace))


async def _occur(world: World, fault: Fault, trace: list[str]) -> None:
    await world.sleep(fault.at_s)
    trace.append(f"{world.now_s():6.1f}  FAULT {fault.describe()}")
    await fault.act(world)


async def _until(world: World, condition: Callable[[], bool], timeout_s: float) -> bool:
    deadline_s = world.clock.now_s() + timeout_s
    while not condition() and world.clock.now_s() < deadline_s:
        await world.sleep(0.5)
    return condition()


async def _bring_down(world: World) -> None:
    """Wait for the end of the mission; an operator orders it when it does not come by itself."""

    def is_over() -> bool:
        return world.all_down() and (world.station is None or world.station.is_over or world.station.number > 1)

    if await _until(world, is_over, PATIENCE_S):
        return
    for orders in ([Action.RESUME, Action.RETURN], [Action.RESUME, Action.LAND], [Action.LAND]):
        for action in orders:
            await _order(world, action)
        if await _until(world, is_over, STAGE_S):
            return
    up = [v.system_id for v in world.swarm.vehicles if v.autopilot.flight.armed]
    if up:
        world.oracle.report("not down", f"vehicles {up}")
    elif not is_over():
        world.oracle.report("unfinished", "all vehicles are down, but the mission goes on")


async def _order(world: World, action: Action) -> None:
    if world.station is None:
        return
    with suppress(MissionError):  # refused, with a reason
        await world.station.mission.commands.act(action, None, operator="attendant")


async def _collect(world: World, trace: list[str]) -> None:
    """Note all notices of all stations with the mission's time."""
    async with asyncio.TaskGroup() as group:
        known: list[Station] = []
        while True:
            if world.station is not None and world.station not in known:
                known.append(world.station)
                group.create_task(_follow(world, world.station, trace))
            await world.sleep(0.5)


async def _follow(world: World, station: Station, trace: list[str]) -> None:
    with station.journal.subscribe() as events:
        async for event in events:
            if event.kind == "notice":
                vehicle = "" if event.data.vehicle_id is None else f"{event.data.vehicle_id}: "
                trace.append(f"{world.now_s():6.1f}  {vehicle}{event.data.text}")
