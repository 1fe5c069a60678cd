"""Live sharing's view of a mission, its messages to the flight's process, and what operators are told of it."""

from __future__ import annotations

import asyncio

import httpx
import pytest

from aos_gcs.bridge.messages import REQUESTS, SHARING_REQUESTS, MalformedMessageError, pack, unpack
from aos_gcs.bridge.quiet_view import QuietView
from aos_gcs.clock import LoopClock
from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import sharing_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.ports import Notice, Severity
from aos_gcs.runtime.processes.sharing_process import SharingStart
from aos_gcs.sharing.settings import SharingSettings, TakSettings
from aos_gcs.sharing.watch import SharingWatch
from tests.fakes.app import app_of
from tests.fakes.bridge import connected, hosted, mirrored_by
from tests.fakes.mission import ScriptedMission

STATUS = ChannelStatus("TAK", "tcp://host:8087", ChannelState.CONNECTED, "Connected")


async def collected(view: QuietView, events: list[Event]) -> None:
    with view.subscribe() as stream:
        async for event in stream:
            events.append(event)


@pytest.mark.looptime
async def test_a_quiet_view_has_states_now_and_then_every_notice_and_nothing_else() -> None:
    mission, events = ScriptedMission(LoopClock()), list[Event]()
    view = QuietView(mission, 1.0, asyncio.get_running_loop().time)
    following = asyncio.create_task(collected(view, events))
    await asyncio.sleep(0)
    for _ in range(12):
        mission.advance(0.25)
        mission.make_step()
        mission.notify(Severity.INFO, "gust")
        await asyncio.sleep(0.25)
    kinds = [event.kind for event in events]
    assert (kinds.count(EventKind.SNAPSHOT), kinds.count(EventKind.NOTICE)) == (3, 12)
    assert set(kinds) == {EventKind.SNAPSHOT, EventKind.NOTICE}
    assert [event.seq for event in events] == list(range(1, len(events) + 1))
    assert view.steps() == ()
    following.cancel()


@pytest.mark.looptime
async def test_a_loss_of_events_stays_visible_in_a_quiet_view() -> None:
    mission, events = ScriptedMission(LoopClock()), list[Event]()
    following = asyncio.create_task(collected(QuietView(mission, 1.0, lambda: 0.0), events))
    await asyncio.sleep(0)
    for _ in range(300):
        mission.notify(Severity.INFO, "gust")
    await asyncio.sleep(0)
    mission.notify(Severity.INFO, "last")
    await asyncio.sleep(0)
    assert events[-1].seq == len(events)
    for _ in range(300):
        mission.notify(Severity.INFO, "gust")
    await asyncio.sleep(0)
    assert events[-1].seq == len(events) + 1
    following.cancel()


@pytest.mark.looptime
async def test_live_sharing_reports_and_commands_nothing() -> None:
    mission = ScriptedMission(LoopClock())
    told: list[tuple[ChannelStatus, ...]] = []
    async with hosted(mission, mission, requests=SHARING_REQUESTS, on_sharing=told.append) as host:
        async with mirrored_by(host) as mirror:
            mirror.tell_sharing((STATUS,))
            await asyncio.sleep(1.0)
        assert told == [(STATUS,)]
        command = pack("act", 1, Action.HOLD, None, None, "", None)
        (reader, writer), (_, far_writer) = await connected()
        far_writer.write(command)
        with pytest.raises(MalformedMessageError, match="unknown message 'act'"):
            await host.serve(reader, writer)
        for end in (writer, far_writer):
            end.close()
    assert mission.actions == []


def test_the_dashboard_cannot_speak_for_live_sharing() -> None:
    message = pack("sharing", (STATUS,))[4:]
    assert unpack(message, SHARING_REQUESTS) == ("sharing", ((STATUS,),))
    with pytest.raises(MalformedMessageError):
        unpack(message, REQUESTS)


def test_a_failure_is_reported_after_ten_seconds_and_its_end_once() -> None:
    notices: list[Notice] = []
    now_s = 0.0
    watch = SharingWatch(notices.append, lambda: now_s)
    failed = ChannelStatus("TAK", "tcp://host:8087", ChannelState.FAILED, "The server refuses the connection.")
    for second in range(60):
        now_s = float(second)
        is_down = 5 <= second < 9 or 20 <= second < 40
        watch.look((failed if is_down else STATUS,))
    assert [(notice.severity, notice.text) for notice in notices] == [
        (Severity.INFO, "Sharing with TAK (tcp://host:8087): Connected"),
        (
            Severity.WARNING,
            "Sharing with TAK (tcp://host:8087): nothing is shared. The server refuses the connection.",
        ),
        (Severity.INFO, "Sharing with TAK (tcp://host:8087): Connected"),
    ]


def test_a_refusal_is_reported_at_once() -> None:
    notices: list[Notice] = []
    watch = SharingWatch(notices.append, lambda: 0.0)
    refused = ChannelStatus("TAK", "tls://host:8089", ChannelState.REFUSED, "The server refuses our certificate.")
    watch.look((refused,))
    watch.look((refused,))
    assert [notice.severity for notice in notices] == [Severity.WARNING]


def test_the_process_is_told_its_settings() -> None:
    settings = SharingSettings(TakSettings("tls://host:8089", ca_file="ca.pem"))
    start = SharingStart(settings, 20)
    assert SharingStart.from_json(start.to_json()) == start


def test_the_configuration_names_the_field_that_is_wrong() -> None:
    file = {"link": {"urls": ["udpin://0.0.0.0:14550"]}, "mission": {"vehicles": 2}}
    assert not sharing_settings(parse_config(file)).any
    assert sharing_settings(parse_config(file | {"tak": {"url": "udp://239.2.3.1:6969"}})).any
    with pytest.raises(ConfigurationError, match=r"tak\.user is unknown"):
        sharing_settings(parse_config(file | {"tak": {"url": "udp://239.2.3.1:6969", "user": "x"}}))
    with pytest.raises(ConfigurationError, match=r"tak: .*needs a port"):
        sharing_settings(parse_config(file | {"tak": {"url": "tcp://host"}}))


@pytest.mark.looptime
async def test_the_page_is_told_how_each_receiver_does() -> None:
    mission = ScriptedMission(LoopClock())
    mission.sharing = (STATUS,)
    transport = httpx.ASGITransport(app_of(mission))
    async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1") as client:
        told = (await client.get("/api/mission")).json()["sharing"]
    assert told == [
        {
            "name": "TAK",
            "target": "tcp://host:8087",
            "state": "connected",
            "text": "Connected",
            "sent": 0,
            "lost": 0,
            "sent_utc_s": None,
            "received": 0,
            "refused": 0,
            "refused_text": "",
        }
    ]
