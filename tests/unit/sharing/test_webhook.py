"""The web hook: what its messages say, what is queued, and what becomes of answers."""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import json
import ssl
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from aiohttp import web

from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.events import NoticeRecord
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.sharing import ChannelState
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.ports import Severity
from aos_gcs.sharing.channel import ChannelError
from aos_gcs.sharing.http import Answer, Client, Request
from aos_gcs.sharing.secrets import read_secret
from aos_gcs.sharing.settings import WebhookSettings
from aos_gcs.sharing.webhook.channel import WebhookChannel
from aos_gcs.sharing.webhook.messages import FindingChanges, HookEvent, alert_message, finding_message
from aos_gcs.sharing.webhook.queue import CAPACITY, HookQueue
from tests.fakes.sharing import UTC_S, running, scripted, seen
from tests.timing import scaled_s

FOUND = Finding(1, FindingStatus.NEW, (10.0, 20.0, 1.0), 5.0, 8.0, 3, track_id=1, sigma_m=0.8, sightings=4)


def shown(*findings: Finding, **changes: object) -> MissionSnapshot:
    return replace(scripted(), findings=findings, **changes)  # type: ignore[arg-type]


def notice(number: int, severity: Severity = Severity.WARNING) -> NoticeRecord:
    return NoticeRecord(severity, f"notice {number}", 3, 1.0, number, UTC_S)


# --- what has happened ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "event"),
    [
        ({"status": FindingStatus.CONFIRMED}, HookEvent.FINDING_CONFIRMED),
        ({"status": FindingStatus.REJECTED, "comment": "a stump"}, HookEvent.FINDING_REJECTED),
        ({"merged_into": 2}, HookEvent.FINDING_MERGED),
        ({"kind": FindingKind.PERSON}, HookEvent.FINDING_CHANGED),
        ({"comment": "red"}, HookEvent.FINDING_CHANGED),
        ({"assignee": "Team 2"}, HookEvent.FINDING_CHANGED),
        ({"position_enu_m": (12.5, 20.0, 1.0)}, HookEvent.FINDING_CHANGED),
        ({"position_enu_m": (10.5, 20.0, 1.0), "sightings": 9, "seen_at_s": 20.0}, None),
    ],
)
def test_a_message_says_what_has_happened_to_a_finding(changes: dict[str, object], event: HookEvent | None) -> None:
    told = FindingChanges()
    assert [kind for kind, _ in told.since(shown(FOUND))] == [HookEvent.FINDING_NEW]
    changed = shown(replace(FOUND, **changes))  # type: ignore[arg-type]
    assert [kind for kind, _ in told.since(changed)] == ([] if event is None else [event])
    assert list(told.since(changed)) == []


@pytest.mark.parametrize(
    ("changes", "event"),
    [
        ({"status": FindingStatus.CONFIRMED}, HookEvent.FINDING_CONFIRMED),
        ({"status": FindingStatus.REJECTED}, HookEvent.FINDING_REJECTED),
        ({"merged_into": 2}, HookEvent.FINDING_MERGED),
    ],
)
def test_what_was_decided_while_nobody_looked_is_told(changes: dict[str, object], event: HookEvent) -> None:
    told, decided = FindingChanges(), shown(replace(FOUND, **changes))  # type: ignore[arg-type]
    assert [kind for kind, _ in told.since(decided)] == [HookEvent.FINDING_NEW, event]
    assert list(told.since(decided)) == []


def test_a_finding_that_creeps_is_told_of_when_it_has_moved_far_since_the_last_message() -> None:
    told = FindingChanges()
    steps = [shown(replace(FOUND, position_enu_m=(0.5 * step, 0.0, 0.0))) for step in range(13)]
    assert [len(list(told.since(step))) for step in steps] == [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]


def test_a_message_is_signed_dated_and_the_same_however_often_it_is_made() -> None:
    snapshot = shown(FOUND, started_utc_s=UTC_S)
    first, again = (finding_message(HookEvent.FINDING_NEW, FOUND, snapshot, UTC_S + late) for late in (60.0, 90.0))
    assert first.message_id == again.message_id == "scripted-1.finding.1.new"
    document = json.loads(first.body)
    assert (document["version"], document["event"], document["mission"]) == (1, "finding.new", "scripted-1")
    assert document["finding"]["found_utc"] == "2026-11-18T11:06:45.000Z"
    assert document["finding"]["latitude_deg"] == pytest.approx(48.33598, abs=1e-5)
    headers = first.headers("secret", UTC_S + 100.5)
    assert headers["X-AOS-Timestamp"] == "1795000100"
    expected = hmac.new(b"secret", b"1795000100." + first.body, hashlib.sha256).hexdigest()
    assert headers["X-AOS-Signature"] == f"sha256={expected}"


def test_decisions_that_are_taken_back_and_taken_again_are_messages_of_their_own() -> None:
    ids = [
        finding_message(event, replace(FOUND, comment=comment), shown(FOUND), UTC_S).message_id
        for event, comment in ((HookEvent.FINDING_CONFIRMED, "a"), (HookEvent.FINDING_CONFIRMED, "b"))
    ]
    assert len(set(ids)) == 2


def test_an_alert_has_its_severity_and_its_vehicle() -> None:
    message = alert_message(notice(7), "m", UTC_S)
    document = json.loads(message.body)
    assert message.message_id == "m.notice.7"
    assert document["alert"] == {
        "severity": "warning",
        "text": "notice 7",
        "vehicle_id": 3,
        "utc": "2026-11-18T11:06:40.000Z",
    }


def test_a_full_queue_drops_the_oldest_alert_and_keeps_the_findings() -> None:
    queue = HookQueue()
    finding = finding_message(HookEvent.FINDING_NEW, FOUND, shown(FOUND), UTC_S)
    for message in (finding, *(alert_message(notice(number), "m", UTC_S) for number in range(CAPACITY + 9))):
        queue.put(message)
    assert (len(queue), queue.lost) == (CAPACITY, 10)
    assert asyncio.run(queue.first()) is finding


# --- delivery ---------------------------------------------------------------------------------------------------------


class Receiver:
    """Answers requests by the statuses that it is given; with none left, it takes everything."""

    def __init__(self, *answers: int | ChannelError) -> None:
        self.answers = list(answers)
        self.times_s: list[float] = []
        self.events: list[str] = []

    async def request(self, request: Request) -> Answer:
        self.times_s.append(asyncio.get_running_loop().time())
        answer = self.answers.pop(0) if self.answers else 204
        if isinstance(answer, ChannelError):
            raise answer
        if answer == 204:
            self.events.append(json.loads(request.body or b"")["event"])
        return Answer(answer, b"")

    async def close(self) -> None:
        pass


@asynccontextmanager
async def delivering(
    client: Receiver | Client, url: str = "https://host/hook?token=x"
) -> AsyncIterator[WebhookChannel]:
    channel = WebhookChannel(WebhookSettings(url), "secret", client, lambda: UTC_S)
    async with running(channel.run()):
        yield channel


@pytest.mark.looptime
async def test_messages_are_repeated_in_order_until_they_are_taken() -> None:
    receiver = Receiver(503, ChannelError("No answer."), 500, 429, 500)
    async with delivering(receiver) as channel:
        channel.put(seen(shown(FOUND)))
        channel.take(notice(1))
        channel.take(notice(2, Severity.INFO))
        await asyncio.sleep(0.5)
        assert (channel.status.state, channel.status.text) == (
            ChannelState.FAILED,
            "The service answers with status 503",
        )
        await asyncio.sleep(60.0)
    assert receiver.events == ["station.started", "finding.new", "alert"]
    pauses_s = [after - before for before, after in zip(receiver.times_s, receiver.times_s[1:], strict=False)]
    assert pauses_s[:5] == pytest.approx([1.0, 2.0, 4.0, 8.0, 8.0], abs=0.01)
    assert channel.status.state is ChannelState.CONNECTED
    assert (channel.status.sent, channel.status.lost) == (3, 0)
    assert channel.status.target == "https://host"


@pytest.mark.looptime
async def test_a_receiver_that_was_away_for_long_is_tried_within_ten_seconds() -> None:
    receiver = Receiver(*[502] * 100)
    async with delivering(receiver) as channel:
        channel.put(seen(shown()))
        await asyncio.sleep(600.0)
        receiver.answers.clear()
        await asyncio.sleep(10.0)
        assert receiver.events == ["station.started"]


@pytest.mark.looptime
@pytest.mark.parametrize(("status", "text"), [(401, "refuses us (401); check its address"), (302, "has moved (302)")])
async def test_a_refusal_is_named_and_nothing_is_given_up(status: int, text: str) -> None:
    receiver = Receiver(status)
    async with delivering(receiver) as channel:
        channel.put(seen(shown()))
        await asyncio.sleep(0.5)
        assert channel.status.state is ChannelState.REFUSED
        assert text in channel.status.text
        await asyncio.sleep(2.0)
        assert receiver.events == ["station.started"]


@pytest.mark.looptime
async def test_a_message_that_the_receiver_cannot_use_does_not_stop_the_others() -> None:
    receiver = Receiver(204, 422)
    async with delivering(receiver) as channel:
        channel.put(seen(shown(FOUND)))
        channel.take(notice(1))
        await asyncio.sleep(0.5)
        assert receiver.events == ["station.started", "alert"]
        assert (channel.status.sent, channel.status.lost) == (2, 1)


async def test_a_receiver_gets_the_documented_request() -> None:
    requests: list[tuple[str, dict[str, str], bytes]] = []

    async def take(request: web.Request) -> web.Response:
        requests.append((request.path_qs, dict(request.headers), await request.read()))
        return web.Response(status=200)

    async with served(take) as url, delivering(Client(ssl.create_default_context()), f"{url}/hook?a=b") as channel:
        channel.put(seen(shown(FOUND)))
        async with asyncio.timeout(scaled_s(30.0)):
            while channel.status.sent < 2:  # noqa: ASYNC110 - nothing announces it
                await asyncio.sleep(0.01)
    path, headers, body = requests[1]
    assert path == "/hook?a=b"
    signed = hmac.new(b"secret", f"{headers['X-AOS-Timestamp']}.".encode() + body, hashlib.sha256).hexdigest()
    assert headers["X-AOS-Signature"] == f"sha256={signed}"
    assert headers["Idempotency-Key"] == json.loads(body)["id"] == "scripted-1.finding.1.new"
    assert headers["Content-Type"] == "application/json"


async def test_what_is_secret_in_a_url_is_in_no_text() -> None:
    client = Client(ssl.create_default_context())
    with pytest.raises(ChannelError) as failure:
        await client.request(Request("POST", "http://127.0.0.1:9/hook?token=sesame"))
    await client.close()
    assert "sesame" not in str(failure.value)


@asynccontextmanager
async def served(handler: Callable[..., object]) -> AsyncIterator[str]:
    app = web.Application()
    app.router.add_route("*", "/{path:.*}", handler)  # type: ignore[arg-type]
    runner = web.AppRunner(app)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    try:
        host, port = runner.addresses[0][:2]
        yield f"http://{host}:{port}"
    finally:
        await runner.cleanup()


# --- settings and secrets ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("url", ["ftp://host", "https://", "host/path", "https://host:0/"])
def test_an_address_that_is_none_is_refused(url: str) -> None:
    with pytest.raises(ConfigurationError, match="url must be like"):
        WebhookSettings(url)


def test_a_secret_comes_from_its_file_or_from_the_environment(tmp_path: Path) -> None:
    file = tmp_path / "secret"
    file.write_text(" larch\n", encoding="ascii")
    assert read_secret("webhook.secret_file", str(file), "V", {}) == "larch"
    assert read_secret("webhook.secret_file", None, "V", {"V": "spruce "}) == "spruce"
    with pytest.raises(ConfigurationError, match=r"webhook\.secret_file: name the file.*variable V"):
        read_secret("webhook.secret_file", None, "V", {})
    file.write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigurationError, match="holds no secret"):
        read_secret("webhook.secret_file", str(file), "V", {})
    with pytest.raises(ConfigurationError, match="cannot read"):
        read_secret("webhook.secret_file", str(tmp_path / "absent"), "V", {})
