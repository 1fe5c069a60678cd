"""Sharing with TAK over real connections: in its own process, to a server that is restarted, by certificates."""

from __future__ import annotations

import asyncio
import math
import socket
import ssl
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.findings import FindingChange, FindingStatus
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.ports import Notice
from aos_gcs.runtime.processes.sharing_supervisor import open_sharing_process
from aos_gcs.sharing.channel import ChannelError
from aos_gcs.sharing.settings import SharingSettings, TakSettings
from aos_gcs.sharing.tak import connection
from aos_gcs.sharing.tak.channel import TakChannel
from tests.fakes.bridge import connected
from tests.fakes.mission import ScriptedMission
from tests.fakes.program import unused_port
from tests.fakes.sharing import TakServer, make_authority, make_certificate, running, seen
from tests.timing import scaled_s

FINDING = "aos-gcs.scripted-1.finding.1"


def mark(uid: str) -> bytes:
    """Return a mark that somebody has set just now."""
    now = datetime.now(UTC)
    times = {"time": now, "start": now, "stale": now + timedelta(minutes=5.0)}
    written = " ".join(f'{name}="{one.isoformat()}"' for name, one in times.items())
    point = '<point lat="48.0" lon="15.0" hae="9999999.0" ce="10.0" le="10.0"/>'
    return f'<event version="2.0" uid="{uid}" type="b-m-p-s-m" how="h-g-i-g-o" {written}>{point}</event>'.encode()


async def test_findings_reach_a_server_that_is_restarted_and_leave_it_when_they_are_rejected() -> None:
    mission, notices, statuses = ScriptedMission(LoopClock()), list[Notice](), list[ChannelStatus]()
    server = TakServer(time.time, marks=mark("drawn-1"))
    async with AsyncExitStack() as stack, AsyncExitStack() as first:
        await stack.enter_async_context(asyncio.timeout(scaled_s(40.0)))
        port = await first.enter_async_context(server.listening(unused_port(socket.SOCK_STREAM)))
        settings = SharingSettings(TakSettings(f"tcp://127.0.0.1:{port}", receive=True))
        sharing = await stack.enter_async_context(open_sharing_process(settings, notices.append))
        assert sharing is not None
        await stack.enter_async_context(sharing.following(mission, mission, statuses.extend, mission.proposals))
        flying = asyncio.create_task(mission.run())
        stack.callback(flying.cancel)
        found = await mission.add_finding((10.0, 20.0, 0.0), "jacket", operator="Ada")
        await server.until(lambda: {"aos-gcs.vehicle.1", FINDING} <= set(server.uids()))
        await server.until(lambda: statuses[-1].state is ChannelState.CONNECTED)
        await server.until(lambda: bool(mission.proposals.all()))
        await first.aclose()
        await server.until(lambda: statuses[-1].state is ChannelState.FAILED)
        await mission.change_finding(found.finding_id, FindingChange(FindingStatus.REJECTED), operator="Ada")
        server.events.clear()
        await stack.enter_async_context(server.listening(port))
        await server.until(lambda: {f"{FINDING}.delete", "aos-gcs.area"} <= set(server.uids()))
        # The server may be back before the decision has arrived: the deletion has the last word.
        assert FINDING not in server.uids()[server.uids().index(f"{FINDING}.delete") :]
        await server.until(lambda: statuses[-1].state is ChannelState.CONNECTED)
    assert [record.proposal.uid for record in mission.proposals.all()] == ["drawn-1"]
    assert "From TAK: one proposal waits for the plan" in [notice.text for notice in notices]
    assert any("Sharing with TAK" in notice.text and "Connected" in notice.text for notice in notices)


@asynccontextmanager
async def sharing(settings: TakSettings) -> AsyncIterator[TakChannel]:
    channel = TakChannel(settings, None, asyncio.get_running_loop().time, time.time)
    channel.put(seen(published_at_s=math.inf))
    async with running(channel.run()), asyncio.timeout(scaled_s(30.0)):
        yield channel


async def until(channel: TakChannel, text: str) -> ChannelState:
    while text not in channel.status.text:  # noqa: ASYNC110 - nothing announces it
        await asyncio.sleep(0.02)
    return channel.status.state


async def test_a_server_that_takes_nothing_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "TAKE_S", 0.2)
    (reader, writer), (_, far_writer) = await connected()
    stream = connection.Stream(reader, writer)
    with pytest.raises(ChannelError, match="has taken nothing"):
        await stream.send([b"x" * 10_000_000])
    await stream.close()
    far_writer.close()


async def test_a_member_of_a_group_hears_the_marks_of_others_and_not_its_own() -> None:
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as other:
        other.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]  # free for the group, too, as long as this socket is open
        settings = TakSettings(f"udp://239.2.3.1:{port}", interface="127.0.0.1", receive=True)
        async with sharing(settings) as channel:
            await until(channel, "Sending")
            for datagram in (b"<event", b"<event how='h-e' no XML></event>", mark("drawn-2")):
                other.sendto(datagram, ("239.2.3.1", port))
            while not channel.status.received:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0.02)
            assert channel.status.sent > 0
            assert [one.uid for one in channel.proposals().proposals] == ["drawn-2"]
            assert (channel.status.refused, channel.status.refused_text) == (1, "an event that is no XML")


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificates")
    make_authority(folder, "team")
    make_authority(folder, "stranger")
    for authority, name in (("team", "server"), ("team", "station"), ("stranger", "intruder")):
        make_certificate(folder, authority, name)
    return folder


def server_context(folder: Path) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "server.pem", folder / "server.key")
    context.load_verify_locations(folder / "team.pem")
    context.verify_mode = ssl.CERT_REQUIRED
    return context


@pytest.mark.parametrize(
    ("fields", "text", "state"),
    [
        ({"certificate": "station"}, "Connected", ChannelState.CONNECTED),
        ({"certificate": "station", "ca_file": "stranger.pem"}, "not signed by the authority", ChannelState.REFUSED),
        ({"certificate": "station", "server_name": "tak.example"}, "for another name", ChannelState.REFUSED),
        ({"certificate": "intruder"}, "check that it accepts our certificate", ChannelState.REFUSED),
        ({}, "check that it accepts our certificate", ChannelState.REFUSED),
    ],
)
async def test_certificates_that_do_not_fit_are_named(
    certificates: Path, fields: dict[str, str], text: str, state: ChannelState
) -> None:
    name = fields.get("certificate")
    server = TakServer(time.time)
    async with server.listening(ssl=server_context(certificates)) as port:
        settings = TakSettings(
            f"tls://127.0.0.1:{port}",
            ca_file=str(certificates / fields.get("ca_file", "team.pem")),
            certificate_file=None if name is None else str(certificates / f"{name}.pem"),
            key_file=None if name is None else str(certificates / f"{name}.key"),
            server_name=fields.get("server_name"),
        )
        async with sharing(settings) as channel:
            assert await until(channel, text) is state
    assert bool(server.events) == (state is ChannelState.CONNECTED)
