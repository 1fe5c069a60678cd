"""The bridge between the flight's process and the interface's: what it keeps, what it bounds, what it refuses."""

from __future__ import annotations

import asyncio
import math
import socket
import struct
from dataclasses import replace

import pytest

from aos_gcs.bridge.calls import MAX_CALLS
from aos_gcs.bridge.messages import (
    MAX_REQUEST_BYTES,
    REPORTS,
    REQUESTS,
    MalformedMessageError,
    pack,
    unpack,
)
from aos_gcs.bridge.mirror import MissionMirror
from aos_gcs.clock import LoopClock
from aos_gcs.errors import AosError, LinkError, MissionError, ParameterError
from aos_gcs.mission.command_order import CommandOrder, OutdatedError
from aos_gcs.mission.model.actions import Action, ActionResult, Seen
from aos_gcs.mission.model.events import EventKind, JumpRecord
from aos_gcs.mission.model.findings import Finding, FindingChange, FindingStatus
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.planning.plan import plan_of
from aos_gcs.ports import Severity
from tests.fakes.bridge import connected, hosted, mirror_of, mirrored_by
from tests.fakes.mission import ScriptedMission

pytestmark = pytest.mark.looptime


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


async def settled() -> None:
    """Let everything arrive that is on its way."""
    for _ in range(20):
        await asyncio.sleep(0.01)


# --- a slow interface, a new one --------------------------------------------------------------------------------------


async def test_an_interface_that_does_not_read_costs_nothing_and_is_told_everything_later(
    mission: ScriptedMission,
) -> None:
    ours, theirs = socket.socketpair()
    async with hosted(mission, mission) as host:
        reader, writer = await asyncio.open_connection(sock=ours)
        serving = asyncio.create_task(host.serve(reader, writer))
        await settled()
        mission.notify(Severity.CRITICAL, "Vehicle 3 sinks")
        await mission.act(Action.START, None)
        for _ in range(5):
            for number in range(120):
                mission.notify(Severity.INFO, f"wind {number}" + 5000 * ".")
                await asyncio.sleep(0.0)
            mission.advance(4.0)
            await settled()
        assert writer.transport.get_write_buffer_size() < 2**20, "what waits is bounded"
        mirror = MissionMirror(*await asyncio.open_connection(sock=theirs))
        mirroring = asyncio.create_task(mirror.run())
        await settled()
        assert mirror.snapshot() == mission.snapshot()
        assert list(mirror.steps()) == list(mission.steps()) != []
        assert mirror.picture(PictureKind.INTEGRAL) == mission.picture(PictureKind.INTEGRAL)
        assert "Vehicle 3 sinks" in {notice.text for notice in mirror.notices}
        writer.close()
        await asyncio.gather(serving, mirroring)
        mirror.close()


async def test_losing_events_an_interface_starts_over_with_its_clients(mission: ScriptedMission) -> None:
    async with mirror_of(mission, mission) as mirror:
        mission.notify(Severity.INFO, "calm")
        await settled()
        with mirror.subscribe() as events:
            for number in range(300):
                mission.notify(Severity.WARNING, f"wind {number}")
            event = await anext(events)
            while event.kind is not EventKind.JUMP:
                event = await anext(events)
        assert isinstance(event.data, JumpRecord)
        await settled()
        assert mirror.notices[-1].text == "wind 299"


async def test_a_new_interface_is_told_all_that_its_predecessor_knew(mission: ScriptedMission) -> None:
    async with hosted(mission, mission) as host:
        async with mirrored_by(host) as first:
            mission.notify(Severity.CRITICAL, "Vehicle 3 sinks")
            await mission.act(Action.START, None)
            for _ in range(40):
                mission.advance(0.5)
            await settled()
            seq, notices = first.seq, first.notices
            assert len(first.steps()) > 1
        mission.notify(Severity.WARNING, "while nobody listened")
        await settled()
        async with mirrored_by(host) as second:
            assert second.seq == seq + 1
            assert second.snapshot() == mission.snapshot()
            assert list(second.steps()) == list(mission.steps())
            assert [notice.text for notice in second.notices] == [
                *(notice.text for notice in notices),
                "while nobody listened",
            ]
            assert second.settings == mission.settings
            assert second.picture(PictureKind.THERMAL) == mission.picture(PictureKind.THERMAL)


async def test_the_state_has_the_age_that_it_had_in_flight(mission: ScriptedMission) -> None:
    loop = asyncio.get_running_loop()
    async with mirror_of(mission, mission) as mirror:
        mission.advance(0.1)
        published_at_s = loop.time()
        await asyncio.sleep(5.0)
        mission.notify(Severity.INFO, "no state")
        await settled()
        assert mirror.heard_at_s == pytest.approx(published_at_s, abs=0.05)


# --- commands ---------------------------------------------------------------------------------------------------------


async def test_what_operators_change_is_known_when_they_are_answered(mission: ScriptedMission) -> None:
    async with mirror_of(mission, mission) as mirror:
        finding = await mirror.add_finding((1.0, 2.0, 0.0), "a tent", operator="Ada")
        assert mirror.snapshot().findings == (finding,)
        changed = await mirror.change_finding(
            finding.finding_id, FindingChange(FindingStatus.REJECTED, "empty", None), operator="Bob"
        )
        assert mirror.snapshot().findings == (changed,)
        plan = replace(plan_of(mirror.settings), vehicles=4)
        await mirror.apply_plan(plan, operator="Ada")
        assert mirror.settings.vehicles == 4
        assert mirror.settings == mission.settings


async def test_errors_keep_their_kind_and_their_words(mission: ScriptedMission) -> None:
    async with mirror_of(mission, mission) as mirror:
        mission.order = CommandOrder("scripted-1", asyncio.get_running_loop().time, 2.0)
        now_s = asyncio.get_running_loop().time()
        with pytest.raises(OutdatedError, match=r"3\.0 s old"):
            await mirror.act(Action.START, None, seen=Seen("scripted-1", 0, now_s - 3.0))
        with pytest.raises(MissionError, match="no finding 7"):
            await mirror.change_finding(7, FindingChange(None, "x", None))


class BrokenMission(ScriptedMission):
    """A mission whose commands fail, or take until they are let go."""

    def __init__(self) -> None:
        super().__init__(LoopClock())
        self.failure: Exception | None = None
        self.may_end = asyncio.Event()
        self.has_ended = False

    async def act(self, action: Action, *_: object, **__: object) -> tuple[ActionResult, ...]:
        if self.failure is not None:
            raise self.failure
        if action is not Action.HOLD:
            await self.may_end.wait()
            self.has_ended = True
        return ()


@pytest.fixture
async def broken() -> BrokenMission:
    return BrokenMission()


async def test_an_error_of_the_program_is_told_without_its_details(broken: BrokenMission) -> None:
    async with mirror_of(broken, broken) as mirror:
        broken.failure = ZeroDivisionError("secret")
        with pytest.raises(AosError, match="its log has the details") as caught:
            await mirror.act(Action.START, None)
        assert "secret" not in str(caught.value)
        broken.failure = ParameterError("c1 must be above 0", "c1")
        with pytest.raises(AosError, match="c1 must be above 0"):
            await mirror.act(Action.START, None)


async def test_however_many_commands_are_in_progress_a_hold_is_taken(broken: BrokenMission) -> None:
    async with mirror_of(broken, broken) as mirror:
        pending = [asyncio.create_task(mirror.act(Action.RETURN, (1,))) for _ in range(MAX_CALLS)]
        await settled()
        with pytest.raises(MissionError, match="too many commands"):
            await mirror.act(Action.RETURN, (1,))
        assert await mirror.act(Action.HOLD, None) == ()
        broken.may_end.set()
        await asyncio.gather(*pending)


async def test_a_command_is_carried_out_to_its_end_when_the_interface_is_gone(broken: BrokenMission) -> None:
    async with hosted(broken, broken) as host:
        async with mirrored_by(host) as mirror:
            waiting = asyncio.create_task(mirror.act(Action.LAND, (1,)))
            await settled()
        with pytest.raises(LinkError, match="remote control"):
            await waiting
        broken.may_end.set()
        await settled()
        assert broken.has_ended
        with pytest.raises(LinkError):
            await mirror.act(Action.HOLD, None)


# --- messages ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "data",
    [
        b"\xff" * 64,
        struct.pack("!I", MAX_REQUEST_BYTES + 1),
        struct.pack("!I", 7) + b"hello\n{",
        struct.pack("!I", 9) + b"act\n[1,2]",
        pack("ready", 7),
    ],
    ids=["noise", "too long", "unknown", "incomplete", "a report"],
)
async def test_what_is_no_message_ends_the_connection(mission: ScriptedMission, data: bytes) -> None:
    async with hosted(mission, mission) as host:
        (reader, writer), (_, far_writer) = await connected()
        far_writer.write(data)
        far_writer.write_eof()
        with pytest.raises(MalformedMessageError):
            await host.serve(reader, writer)
        writer.close()
        far_writer.close()
        assert mission.actions == []


def test_numbers_that_json_does_not_know_survive() -> None:
    finding = Finding(1, FindingStatus.NEW, (math.inf, -math.inf, 0.0), 1.0, 1.0, 1)
    _, (number, found) = unpack(pack("done add_finding", 7, finding)[4:], REPORTS)
    assert (number, found) == (7, finding)
    with pytest.raises(MalformedMessageError):
        unpack(b"done add_finding\n[1]", REPORTS)
    with pytest.raises(MalformedMessageError):
        unpack(pack("done acknowledge", 7, None)[4:], REQUESTS)
