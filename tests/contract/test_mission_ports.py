"""Behaviour that the ports of a mission promise: of a live one, of its mirror, of a scripted one, and of a replay."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.control import MissionCommands, MissionView
from aos_gcs.mission.events import DEFAULT_CAPACITY
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.checks import CheckStatus, PreflightCheck
from aos_gcs.mission.model.events import Event, EventKind, NoticeRecord
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.proposals import Proposal, ProposalShape, ProposalUse
from aos_gcs.mission.model.steps import FocusSource, PictureKind
from aos_gcs.planning.plan import plan_of
from aos_gcs.ports import Safeguard, Severity
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.replay import MissionReplay
from tests.fakes.bridge import mirror_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.mission_flight import flying, prepare
from tests.fakes.recording import record

pytestmark = pytest.mark.looptime

POLL_S = 0.5
LIMIT_S = 300.0
UNKNOWN_ID = 99
SEARCHING = (Phase.LINE, Phase.SCAN, Phase.CONVERGE, Phase.FOUND)


@dataclass
class Mission:
    """A mission on the ground, with one failed check, that can be started."""

    view: MissionView
    commands: MissionCommands | None
    clock: LoopClock
    publish: Callable[[], object]
    """Put an event on its stream."""
    start: Callable[[], object]
    """Let it fly, or its record be shown."""
    propose: Callable[[list[Proposal]], object] | None = None
    """Have others propose something; None for a replay."""

    async def until(self, condition: Callable[[], bool]) -> None:
        async with self.clock.timeout_at(self.clock.now_s() + LIMIT_S):
            while not condition():
                await self.clock.sleep(POLL_S)

    async def until_step(self, number: int) -> None:
        await self.until(lambda: len(self.view.steps()) >= number)


@asynccontextmanager
async def coordinator(_folder: Path) -> AsyncIterator[Mission]:
    flight = prepare(auto_start=False, auto_return=False, pictures=True)
    flight.fleet.members[2].facts["link_loss"] = Safeguard(False, "none", "set FS_GCS_ENABLE to 1")
    async with flying(flight) as run:
        mission = Mission(
            flight.view,
            flight.commands,
            flight.clock,
            lambda: flight.journal.notice(Severity.INFO, "wind"),
            flight.fleet.members[2].facts.clear,
            flight.view.proposals.take,
        )
        await mission.until(lambda: bool(failed_checks(mission.view)))
        yield mission
        run.cancel()


@asynccontextmanager
async def scripted(_folder: Path) -> AsyncIterator[Mission]:
    clock = LoopClock()
    script = ScriptedMission(clock)
    async with running(script):
        publish = partial(script.notify, Severity.INFO, "wind")
        yield Mission(script, script, clock, publish, lambda: None, script.proposals.take)


@asynccontextmanager
async def replay(folder: Path) -> AsyncIterator[Mission]:
    await record(folder)
    clock = LoopClock()
    with MissionReader(folder) as reader:
        shown = MissionReplay(reader, clock)
        async with running(shown):
            yield Mission(shown, None, clock, lambda: shown.seek(time_s=0.0), lambda: shown.seek(playing=True))


@asynccontextmanager
async def running(mission: ScriptedMission | MissionReplay) -> AsyncIterator[None]:
    task = asyncio.create_task(mission.run())
    yield
    task.cancel()


@asynccontextmanager
async def mirrored(folder: Path) -> AsyncIterator[Mission]:
    """Show and command a mission through messages, as another process does."""
    async with coordinator(folder) as mission, mirror_of(mission.view, mission.commands) as mirror:
        yield replace(mission, view=mirror, commands=mirror)


Opener = Callable[[], AbstractAsyncContextManager[Mission]]


@pytest.fixture(params=[coordinator, mirrored, scripted, replay], ids=lambda opener: opener.__name__)
def open_mission(request: pytest.FixtureRequest, tmp_path: Path) -> Opener:
    """Open a mission of every kind; in the test, where time is virtual."""
    return partial(request.param, tmp_path / "m")


@pytest.fixture(params=[coordinator, mirrored, scripted], ids=lambda opener: opener.__name__)
def open_commanded(request: pytest.FixtureRequest, tmp_path: Path) -> Opener:
    """Open a mission that takes commands."""
    return partial(request.param, tmp_path / "m")


def failed_checks(view: MissionView) -> list[PreflightCheck]:
    return [check for check in view.snapshot().preflight if check.status is CheckStatus.FAIL and check.overridable]


async def launch(mission: Mission) -> None:
    """Start a mission that takes commands, and wait until it searches."""
    mission.start()
    await mission.until(lambda: mission.view.snapshot().phase is Phase.READY)
    await mission.commands.act(Action.START, None, operator="Ada")
    await mission.until(lambda: mission.view.snapshot().phase in SEARCHING)


async def begin(mission: Mission) -> None:
    """Start a mission of any kind."""
    if mission.commands is None:
        mission.start()
    else:
        await launch(mission)


# --- what can be seen -----------------------------------------------------------------------------------------------


async def test_steps_and_their_pictures_come_with_the_search(open_mission: Opener) -> None:
    async with open_mission() as mission:
        assert (mission.view.snapshot().step, list(mission.view.steps())) == (0, [])
        assert [mission.view.picture(kind) for kind in PictureKind] == [None] * len(PictureKind)
        await begin(mission)
        await mission.until_step(2)
        steps = list(mission.view.steps())
        assert [step.step for step in steps] == list(range(1, len(steps) + 1)), "the oldest first"
        # A step may be on its way, and a mirror may know of a step before its snapshot does.
        await mission.until(lambda: mission.view.snapshot().step - len(mission.view.steps()) in {0, 1})
        await mission.until(lambda: mission.view.picture(PictureKind.INTEGRAL) is not None)
        for kind in PictureKind:
            picture = mission.view.picture(kind)
            if picture is not None:
                assert (picture.kind, picture.png[:4]) == (kind, b"\x89PNG")
                assert 1 <= picture.step <= len(mission.view.steps())
                assert picture.west_m < picture.east_m
                assert picture.south_m < picture.north_m


async def test_events_are_followed_from_now_on_without_gaps(open_mission: Opener) -> None:
    async with open_mission() as mission:
        mission.publish()
        seen: list[Event] = []
        with mission.view.subscribe() as events:
            await begin(mission)
            async for event in events:
                seen.append(event)
                if event.kind is EventKind.STEP:
                    break
        assert [event.seq for event in seen] == list(range(seen[0].seq, seen[0].seq + len(seen)))
        assert seen[0].seq > 1, "earlier events are not told again"
        assert seen[-1].data == mission.view.steps()[0]
        assert EventKind.SNAPSHOT in {event.kind for event in seen}


async def test_a_slow_reader_loses_its_oldest_events_and_no_other_does(open_mission: Opener) -> None:
    async with open_mission() as mission:
        with mission.view.subscribe() as slow, mission.view.subscribe() as quick:
            mission.publish()
            first = (await anext(quick)).seq
            for _ in range(2 * DEFAULT_CAPACITY):
                mission.publish()
                await anext(quick)
            assert (await anext(slow)).seq > first + DEFAULT_CAPACITY / 2


# --- what can be commanded ------------------------------------------------------------------------------------------


async def test_actions_that_make_no_sense_are_refused_and_change_nothing(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        await begin(mission)
        await mission.until_step(1)
        act = mission.commands.act
        before = mission.view.snapshot()
        for action, vehicle_ids, height_m in (
            (Action.START, None, None),
            (Action.HOLD, (1, UNKNOWN_ID), None),
            (Action.HOLD, None, 2.0),
            (Action.FOCUS, (1,), 2.0),
            (Action.OVERRIDE, None, None),
        ):
            with pytest.raises(MissionError):
                await act(action, vehicle_ids, height_m, operator="Ada")
        with pytest.raises(MissionError):
            await mission.commands.override_check(1, "battery", "it is warm", operator="Ada")
        after = mission.view.snapshot()
        assert (after.suspension, after.focus) == (before.suspension, before.focus)
        assert [vehicle.task for vehicle in after.vehicles] == [vehicle.task for vehicle in before.vehicles]


async def test_an_unknown_notice_is_refused_and_none_is_acknowledged(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        mission.publish()
        with pytest.raises(MissionError):
            await mission.commands.acknowledge([1, 10**6], operator="Ada")
        assert mission.view.snapshot().acknowledgements == ()


async def test_an_action_answers_for_every_vehicle_that_it_concerns(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        await launch(mission)
        one = await mission.commands.act(Action.HOLD, (1,), operator="Ada")
        assert [(result.vehicle_id, result.accepted) for result in one] == [(1, True)]
        everybody = await mission.commands.act(Action.HOLD, None, operator="Ada")
        vehicles = mission.view.snapshot().vehicles
        assert [result.vehicle_id for result in everybody] == [vehicle.telemetry.vehicle_id for vehicle in vehicles]


async def test_the_plane_of_the_mission_is_set_and_left_again(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        await launch(mission)
        configured = mission.view.snapshot().focus
        assert await mission.commands.act(Action.FOCUS, None, 1.5, operator="Ada") == ()
        chosen = mission.view.snapshot().focus
        assert (chosen.height_m, chosen.source) == (1.5, FocusSource.OPERATOR)
        await mission.commands.act(Action.FOCUS, None, operator="Ada")
        assert mission.view.snapshot().focus == configured


async def test_a_failed_check_is_overridden_and_the_override_taken_back(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        commands = mission.commands
        failed = failed_checks(mission.view)[0]
        key = failed.vehicle_id, failed.name

        def found() -> PreflightCheck:
            return next(check for check in mission.view.snapshot().preflight if (check.vehicle_id, check.name) == key)

        overridden = await commands.override_check(*key, "a pilot stands by", operator="Ada")
        assert overridden == found()
        assert overridden.overridden is not None
        assert (overridden.overridden.reason, overridden.overridden.by) == ("a pilot stands by", "Ada")
        assert not overridden.blocks
        assert (await commands.override_check(*key, None, operator="Ada")).blocks
        assert found().overridden is None
        passed = next(check for check in mission.view.snapshot().preflight if check.status is CheckStatus.PASS)
        for vehicle_id, name in (
            (passed.vehicle_id, passed.name),
            (UNKNOWN_ID, failed.name),
            (key[0], "no such check"),
        ):
            with pytest.raises(MissionError):
                await commands.override_check(vehicle_id, name, "a pilot stands by", operator="Ada")


async def test_the_first_acknowledgement_of_a_notice_stays_on_record(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        mission.publish()
        for operator in ("Ada", "Bob"):
            await mission.commands.acknowledge([1], operator=operator)
        (given,) = mission.view.snapshot().acknowledgements
        assert (given.notice_id, given.operator) == (1, "Ada")


async def test_a_finding_is_marked_and_changed_field_by_field(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        commands = mission.commands
        marked = await commands.add_finding((4.0, -6.0, 0.0), "jacket", operator="Ada")
        assert (marked.position_enu_m, marked.comment, marked.operator) == ((4.0, -6.0, 0.0), "jacket", "Ada")
        assert (marked.status, marked.assignee, marked.track_id) == (FindingStatus.NEW, "", None)
        other = await commands.add_finding((8.0, 0.0, 0.0), "", operator="Ada")
        assert other.finding_id != marked.finding_id

        confirmed = FindingChange(status=FindingStatus.CONFIRMED, assignee="team 2")
        changed = await commands.change_finding(marked.finding_id, confirmed, operator="Bob")
        assert changed == replace(marked, status=FindingStatus.CONFIRMED, assignee="team 2", operator="Bob")
        await mission.until(lambda: mission.view.snapshot().findings == (changed, other))
        emptied = await commands.change_finding(marked.finding_id, FindingChange(comment=""), operator="Bob")
        assert emptied == replace(changed, comment="")


async def test_a_finding_that_there_is_not_is_refused(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        marked = await mission.commands.add_finding((4.0, -6.0, 0.0), "", operator="Ada")
        with pytest.raises(MissionError, match=f"no finding {UNKNOWN_ID}"):
            await mission.commands.change_finding(UNKNOWN_ID, FindingChange(comment="shoe"), operator="Ada")
        await mission.until(lambda: mission.view.snapshot().findings == (marked,))


async def test_a_proposal_is_decided_once_and_marked_where_it_becomes_a_finding(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        await mission.until(lambda: mission.view.snapshot().origin is not None)
        origin = mission.view.snapshot().origin
        mission.propose([a_point("jacket", origin.latitude_deg, origin.longitude_deg)])
        await mission.until(lambda: bool(mission.view.snapshot().proposals))
        (waiting,) = mission.view.snapshot().proposals
        decide = mission.commands.decide_proposal
        for proposal_id, use in (
            (UNKNOWN_ID, ProposalUse.DISMISSED),
            (waiting.proposal_id, ProposalUse.AREA),  # a point is no area
        ):
            with pytest.raises(MissionError):
                await decide(proposal_id, use, operator="Ada")
        decided = await decide(waiting.proposal_id, ProposalUse.FINDING, operator="Ada")
        assert (decided.proposal, decided.use, decided.operator) == (waiting.proposal, ProposalUse.FINDING, "Ada")
        for use in (ProposalUse.FINDING, ProposalUse.DISMISSED):
            with pytest.raises(MissionError, match="Ada has decided"):
                await decide(waiting.proposal_id, use, operator="Bob")
        await mission.until(lambda: mission.view.snapshot().proposals == (decided,))
        (finding,) = mission.view.snapshot().findings
        assert finding.position_enu_m == pytest.approx((0.0, 0.0, 0.0), abs=0.1)
        assert "jacket" in finding.comment


def a_point(name: str, latitude_deg: float, longitude_deg: float) -> Proposal:
    return Proposal(
        uid="a",
        source="TAK",
        name=name,
        sender="Kim",
        kind="b-m-p-s-m",
        shape=ProposalShape.POINT,
        points_deg=((latitude_deg, longitude_deg),),
        altitude_amsl_m=None,
        remarks="",
        sent_utc_s=0.0,
        stale_utc_s=1e10,
        received_utc_s=0.0,
    )


async def test_a_plan_is_flown_that_comes_before_the_start_and_none_that_comes_after(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        commands = mission.commands
        plan = replace(plan_of(commands.settings), strategy="aos-pso")
        await commands.apply_plan(plan, operator="Ada")
        await mission.until(lambda: commands.settings.strategy == "aos-pso")
        await launch(mission)
        with pytest.raises(MissionError, match="the mission has started"):
            await commands.apply_plan(replace(plan, strategy="aos-apso"), operator="Ada")
        assert commands.settings.strategy == "aos-pso"
        assert mission.view.snapshot().phase in SEARCHING


async def test_an_announcement_becomes_a_notice(open_commanded: Opener) -> None:
    async with open_commanded() as mission:
        with mission.view.subscribe() as events:
            await mission.commands.announce("has control", operator="Ada")
            async with mission.clock.timeout_at(mission.clock.now_s() + LIMIT_S):
                while not isinstance((notice := (await anext(events)).data), NoticeRecord):
                    pass
        assert (notice.text, notice.severity, notice.vehicle_id) == ("Ada: has control", Severity.INFO, None)
