"""All channels of a mission: what each of them is given, and what cannot work is refused before anything is opened."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from aos_gcs.clock import LoopClock
from aos_gcs.errors import ConfigurationError
from aos_gcs.mission.model.events import Event, EventKind, JumpRecord, NoticeRecord
from aos_gcs.mission.model.proposals import Proposal
from aos_gcs.mission.model.sharing import ChannelState, ChannelStatus
from aos_gcs.ports import Severity
from aos_gcs.sharing.channel import ProposalChanges
from aos_gcs.sharing.service import CALTOPO_SECRET, CONNECT_KEY, WEBHOOK_SECRET, make_channels, share
from aos_gcs.sharing.settings import CaltopoSettings, SharingSettings, TakSettings, WebhookSettings
from aos_gcs.sharing.state import SeenState
from tests.fakes.command_line import exit_status
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import record
from tests.fakes.sharing import running

NOW_UTC_S = 1_795_000_000.0


class Channel:
    """Keeps what it is given."""

    def __init__(self) -> None:
        self.status = ChannelStatus("test", "nowhere", ChannelState.CONNECTED, "Connected")
        self.states: list[SeenState] = []
        self.notices: list[int] = []
        self.waiting = [ProposalChanges("TAK", (), ("gone",)), ProposalChanges("TAK")]

    def proposals(self) -> ProposalChanges:
        return self.waiting.pop(0) if self.waiting else ProposalChanges()

    def put(self, state: SeenState) -> None:
        self.states.append(state)

    def take(self, notice: NoticeRecord) -> None:
        self.notices.append(notice.notice_id)

    async def run(self) -> None:
        await asyncio.Event().wait()


class Source(ScriptedMission):
    """A mission as its mirror shows it."""

    def __init__(self) -> None:
        super().__init__(LoopClock())
        self.heard_at_s = 7.0
        self.notices: list[NoticeRecord] = []
        self.told: list[tuple[ChannelStatus, ...]] = []
        self.proposed: list[tuple[str, tuple[Proposal, ...], tuple[str, ...]]] = []

    def tell_proposals(self, source: str, proposals: tuple[Proposal, ...], withdrawn: tuple[str, ...]) -> None:
        self.proposed.append((source, proposals, withdrawn))

    def tell_sharing(self, statuses: tuple[ChannelStatus, ...]) -> None:
        self.told.append(statuses)


def notice(number: int, age_s: float = 0.0) -> NoticeRecord:
    return NoticeRecord(Severity.WARNING, "gust", None, 0.0, number, NOW_UTC_S - age_s)


@asynccontextmanager
async def sharing(source: Source) -> AsyncIterator[Channel]:
    channel = Channel()
    async with running(share(source, [channel], lambda: NOW_UTC_S)):
        await asyncio.sleep(0.1)
        yield channel


@pytest.mark.looptime
async def test_channels_get_the_present_state_newer_ones_and_how_they_do_is_told() -> None:
    source = Source()
    async with sharing(source) as channel:
        source.advance(0.25)
        await asyncio.sleep(2.5)
    assert [state.published_at_s for state in channel.states] == [7.0, 7.0]
    assert source.told == [(channel.status,)] * 3
    assert source.proposed == [("TAK", (), ("gone",))]


@pytest.mark.looptime
async def test_each_notice_is_passed_on_once_also_after_a_loss_of_events() -> None:
    source = Source()
    source.notices = [notice(1, age_s=600.0), notice(2, age_s=60.0)]
    async with sharing(source) as channel:
        assert channel.notices == [2]
        source.stream.publish(EventKind.NOTICE, notice(3))
        jump = JumpRecord((notice(2), notice(3), notice(4)))
        source.stream.hand_out(Event(99, 0.0, EventKind.JUMP, jump))
        await asyncio.sleep(0.1)
    assert channel.notices == [2, 3, 4]
    assert len(channel.states) == 2


def test_there_is_one_channel_for_each_thing_that_is_shared() -> None:
    settings = SharingSettings(
        TakSettings("udp://239.2.3.1:6969"),
        WebhookSettings("https://host/hook"),
        CaltopoSettings(positions=True, map="ABC", credential_id="ID"),
    )
    secrets = {WEBHOOK_SECRET: "larch", CONNECT_KEY: "KEY", CALTOPO_SECRET: "c2VjcmV0"}
    channels = make_channels(settings, secrets, lambda: 0.0, lambda: NOW_UTC_S)
    assert [one.status.name for one in channels] == ["TAK", "Web hook", "CalTopo positions", "CalTopo map"]
    for missing in secrets:
        others = {name: value for name, value in secrets.items() if name != missing}
        with pytest.raises(ConfigurationError, match=f"variable {missing}"):
            make_channels(settings, others, lambda: 0.0, lambda: NOW_UTC_S)


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        (SharingSettings(TakSettings("udp://239.2.3.1:6969", geoid="/nowhere")), r"tak\.geoid: .* does not exist"),
        (SharingSettings(TakSettings("tls://host:8089", ca_file="/nowhere")), r"tak\.ca_file: /nowhere does not exist"),
        (SharingSettings(webhook=WebhookSettings("https://host", "/nowhere")), r"webhook\.secret_file: cannot read"),
    ],
)
def test_files_that_are_not_there_are_refused(settings: SharingSettings, text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        make_channels(settings, {}, lambda: 0.0, lambda: NOW_UTC_S)


def test_no_receiver_is_none() -> None:
    assert not SharingSettings().any
    assert replace(SharingSettings(), tak=TakSettings("udp://239.2.3.1:6969")).any


async def test_the_command_prints_what_would_be_sent_of_a_recorded_mission(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "flown"
    await record(folder, length_s=12)
    file = tmp_path / "mission.toml"
    receivers = '[tak]\nurl = "udp://239.2.3.1:6969"\n[caltopo]\npositions = true\n'
    file.write_text(f'[link]\nurls = ["udpin://0.0.0.0:14550"]\n[mission]\nvehicles = 2\n{receivers}', encoding="utf-8")
    assert await asyncio.to_thread(_sharing, file, folder) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any('type="a-f-A-M-H-Q"' in line for line in lines)
    assert any("/api/v1/position/report/SECRET?id=AOS01" in line for line in lines)
    file.write_text('[link]\nurls = ["udpin://0.0.0.0:14550"]\n[mission]\nvehicles = 2\n', encoding="utf-8")
    assert await asyncio.to_thread(_sharing, file, folder) == 2
    assert "names no receiver" in capsys.readouterr().err


def _sharing(*arguments: Path) -> object:
    """Run the command, and return its exit status."""
    return exit_status(["sharing", *arguments])
