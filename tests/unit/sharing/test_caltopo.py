"""CalTopo: documented requests and nothing else, positions that are never old, and a map that is not littered."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import json
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from itertools import pairwise
from urllib.parse import parse_qs, urlsplit

import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.sharing import ChannelState
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.caltopo.channel import MapChannel, PositionChannel
from aos_gcs.sharing.caltopo.objects import MAX_TRACK_POINTS, VehicleTracks
from aos_gcs.sharing.caltopo.requests import Credential, position_report, signed
from aos_gcs.sharing.channel import ChannelError
from aos_gcs.sharing.http import Answer, Request
from aos_gcs.sharing.preview import preview
from aos_gcs.sharing.settings import CaltopoSettings, SharingSettings, TakSettings, WebhookSettings
from tests.fakes.scripted_vehicle import ORIGIN
from tests.fakes.sharing import UTC_S, running, scripted, seen

URL = "https://caltopo.com"
SECRET = b"sixteen byte key"
CREDENTIAL = Credential("ID", SECRET)
FOUND = Finding(1, FindingStatus.NEW, (10.0, 20.0, 1.0), 5.0, 8.0, 3, track_id=1, sigma_m=0.8, sightings=4)


def shown(*findings: Finding, **changes: object) -> MissionSnapshot:
    return replace(scripted(), findings=findings, **changes)  # type: ignore[arg-type]


# --- requests ---------------------------------------------------------------------------------------------------------


def test_a_position_is_reported_as_documented() -> None:
    request = position_report(URL, "KEY 1/2", "AOS03", GeodeticPosition(48.5, -14.25, 300.0))
    expected = f"{URL}/api/v1/position/report/KEY%201%2F2?id=AOS03&lat=48.5000000&lng=-14.2500000"
    assert (request.method, request.url, request.body) == ("GET", expected, None)


def test_a_request_with_an_object_is_a_form_that_is_signed_over_method_path_expiry_and_json() -> None:
    payload = {"properties": {"title": 'Zürich & "x"'}}
    request = signed(URL, CREDENTIAL, "POST", "/api/v1/map/ABC/Marker", utc_s=1000.5, payload=payload)
    assert request.url == f"{URL}/api/v1/map/ABC/Marker"
    form = {name: values[0] for name, values in parse_qs((request.body or b"").decode()).items()}
    assert set(form) == {"id", "expires", "signature", "json"}
    assert (form["id"], form["expires"], json.loads(form["json"])) == ("ID", "1120500", payload)
    message = f"POST /api/v1/map/ABC/Marker\n1120500\n{form['json']}".encode()
    assert base64.b64decode(form["signature"]) == hmac.new(SECRET, message, hashlib.sha256).digest()


@pytest.mark.parametrize("method", ["GET", "DELETE"])
def test_a_request_without_an_object_has_its_signature_in_the_query(method: str) -> None:
    request = signed(URL, CREDENTIAL, method, "/api/v1/map/ABC/Marker/7", utc_s=0.0)
    parts = urlsplit(request.url)
    query = {name: values[0] for name, values in parse_qs(parts.query).items()}
    message = f"{method} /api/v1/map/ABC/Marker/7\n120000\n".encode()
    assert (parts.path, request.body, set(query)) == ("/api/v1/map/ABC/Marker/7", None, {"id", "expires", "signature"})
    assert base64.b64decode(query["signature"]) == hmac.new(SECRET, message, hashlib.sha256).digest()


def test_a_secret_that_is_none_is_refused_without_being_quoted() -> None:
    assert Credential.from_text("ID", base64.b64encode(SECRET).decode()) == CREDENTIAL
    with pytest.raises(ConfigurationError, match="credential_secret_file") as failure:
        Credential.from_text("ID", "sesame!")
    assert "sesame" not in str(failure.value)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({}, "positions = true, or map"),
        ({"map": "ABC12"}, "credential_id"),
        ({"map": "a/b", "credential_id": "x"}, "map must be the id"),
        ({"positions": True, "name": "AOS 1"}, "letters and digits"),
        ({"positions": True, "url": "caltopo.com"}, "url must be like"),
    ],
)
def test_settings_that_cannot_work_are_refused(fields: dict[str, object], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        CaltopoSettings(**fields)  # type: ignore[arg-type]


# --- a service --------------------------------------------------------------------------------------------------------


class Service:
    """Takes positions and keeps a map, as far as requests have the documented form and a valid signature."""

    def __init__(self) -> None:
        self.positions: list[tuple[float, str, float, float]] = []
        self.features: dict[str, dict[str, object]] = {}
        self.requests: list[tuple[str, str]] = []
        self.is_up = True
        self.delay_s = 0.0
        self.status: int | None = None
        self.date_utc_s: float | None = None

    async def request(self, request: Request) -> Answer:
        parts = urlsplit(request.url)
        self.requests.append((request.method, parts.path))
        try:
            async with asyncio.timeout(request.timeout_s):
                await asyncio.sleep(self.delay_s)
        except TimeoutError:
            raise ChannelError("No answer.") from None
        if not self.is_up:
            raise ChannelError("No connection to the service.")
        if self.status is not None:
            return Answer(self.status, b"", self.date_utc_s)
        if parts.path.startswith("/api/v1/position/report/"):
            query = parse_qs(parts.query)
            now_s = asyncio.get_running_loop().time()
            self.positions.append((now_s, query["id"][0], float(query["lat"][0]), float(query["lng"][0])))
            return Answer(200, b"{}")
        return Answer(200, json.dumps({"result": self._map(request, parts.path)}).encode())

    def _map(self, request: Request, path: str) -> dict[str, object]:
        query = urlsplit(request.url).query if request.body is None else request.body.decode()
        form = {name: values[0] for name, values in parse_qs(query).items()}
        payload = form.get("json", "")
        assert form["signature"] == CREDENTIAL.signature(request.method, path, int(form["expires"]), payload)
        base, _, rest = path.partition("/map/ABC/")
        assert base == "/api/v1"
        kind, _, number = rest.partition("/")
        if (request.method, kind) == ("GET", "since"):
            return {"state": {"features": list(self.features.values())}}
        if request.method == "DELETE":
            del self.features[number]
            return {}
        number = number or f"f{len(self.requests)}"
        assert kind == json.loads(payload)["properties"]["class"]
        self.features[number] = json.loads(payload) | {"id": number}
        return {"id": number}

    async def close(self) -> None:
        pass

    def titles(self) -> list[str]:
        return sorted(one["properties"]["title"] for one in self.features.values())  # type: ignore[index]


@asynccontextmanager
async def reporting(service: Service) -> AsyncIterator[PositionChannel]:
    now_s = asyncio.get_running_loop().time
    settings = CaltopoSettings(positions=True)
    channel = PositionChannel(settings, "KEY", service, now_s, lambda: UTC_S)
    async with running(channel.run()):
        yield channel


@asynccontextmanager
async def mapping(service: Service) -> AsyncIterator[MapChannel]:
    now_s = asyncio.get_running_loop().time
    settings = CaltopoSettings(map="ABC", credential_id="ID")
    channel = MapChannel(settings, CREDENTIAL, service, now_s, lambda: UTC_S)
    async with running(channel.run()):
        yield channel


@pytest.mark.looptime
async def test_each_vehicle_is_reported_every_three_seconds_and_never_more_often() -> None:
    service = Service()
    async with reporting(service) as channel:
        for _ in range(120):
            channel.put(seen(published_at_s=asyncio.get_running_loop().time()))
            await asyncio.sleep(0.25)
    for device in ("AOS01", "AOS02"):
        times_s = [time_s for time_s, name, *_ in service.positions if name == device]
        assert 8 <= len(times_s) <= 11
        assert min(after - before for before, after in pairwise(times_s)) >= 3.0
    assert channel.status.state is ChannelState.CONNECTED


@pytest.mark.looptime
async def test_after_an_outage_only_present_positions_are_reported() -> None:
    service = Service()
    frame = LocalFrame(ORIGIN)
    async with reporting(service) as channel:
        for second in range(200):
            now_s = asyncio.get_running_loop().time()
            service.is_up = not 20 <= second < 150
            service.delay_s = 60.0 if 120 <= second < 140 else 0.0
            vehicles = tuple(replace(one, position_enu_m=(now_s, 0.0, 30.0)) for one in scripted().vehicles)
            channel.put(seen(shown(vehicles=vehicles), published_at_s=now_s))
            await asyncio.sleep(1.0)
            if second == 100:
                assert channel.status.state is ChannelState.FAILED
    for time_s, _, latitude_deg, longitude_deg in service.positions:
        east_m, *_ = frame.to_enu(GeodeticPosition(latitude_deg, longitude_deg, ORIGIN.altitude_amsl_m))
        assert time_s - east_m <= 1.6
    assert [time_s for time_s, *_ in service.positions if 25.0 < time_s < 145.0] == []
    assert min(time_s for time_s, *_ in service.positions if time_s > 145.0) <= 160.0


@pytest.mark.looptime
async def test_a_mission_that_is_silent_is_not_reported() -> None:
    service = Service()
    async with reporting(service) as channel:
        channel.put(seen(published_at_s=asyncio.get_running_loop().time()))
        await asyncio.sleep(60.0)
    assert max(time_s for time_s, *_ in service.positions) <= 5.5


@pytest.mark.looptime
async def test_a_map_has_area_legs_and_findings_and_loses_those_that_are_rejected() -> None:
    service = Service()
    stranger = {"id": "x", "properties": {"class": "Marker", "title": "Clue 1", "description": "a glove"}}
    service.features["x"] = stranger
    leg = ((0.0, 0.0), (0.0, 50.0))
    async with mapping(service) as channel:
        channel.put(seen(shown(FOUND, legs_enu_m=(leg,), leg=1), published_at_s=-math.inf))
        await asyncio.sleep(5.0)
        assert service.titles() == ["AOS leg 1, flown", "AOS search area", "Clue 1", "Finding 1: Undecided"]
        count = len(service.requests)
        await asyncio.sleep(60.0)
        assert len(service.requests) == count
        confirmed = replace(FOUND, status=FindingStatus.CONFIRMED)
        channel.put(seen(shown(confirmed), published_at_s=-math.inf))
        await asyncio.sleep(5.0)
        assert "Finding 1: Undecided, confirmed" in service.titles()
        assert len(service.requests) == count + 1
        channel.put(seen(shown(replace(FOUND, status=FindingStatus.REJECTED)), published_at_s=-math.inf))
        await asyncio.sleep(5.0)
        assert service.titles() == ["AOS leg 1, flown", "AOS search area", "Clue 1"]


@pytest.mark.looptime
async def test_a_restarted_station_and_a_lost_answer_make_nothing_twice() -> None:
    service = Service()
    for _ in range(2):
        async with mapping(service) as channel:
            channel.put(seen(shown(FOUND), published_at_s=-math.inf))
            await asyncio.sleep(3.0)
    assert len(service.features) == 2
    async with mapping(service) as channel:
        channel.put(seen(shown(FOUND, replace(FOUND, finding_id=2)), published_at_s=-math.inf))
        original = service._map

        def lost(request: Request, path: str) -> dict[str, object]:
            original(request, path)
            if request.method == "POST":
                service._map = original  # type: ignore[method-assign]
                raise ChannelError("No answer.")
            return {"state": {"features": list(service.features.values())}}

        service._map = lost  # type: ignore[method-assign]
        await asyncio.sleep(20.0)
    assert len(service.features) == 3


@pytest.mark.looptime
async def test_a_refusal_and_a_wrong_clock_are_named() -> None:
    service = Service()
    service.status = 401
    async with mapping(service) as channel:
        await asyncio.sleep(0.5)
        assert channel.status.state is ChannelState.REFUSED
        assert "(401); check the id of the map" in channel.status.text
        service.date_utc_s = UTC_S + 3600.0
        await asyncio.sleep(5.0)
        assert "clock differs from this machine's by 60 min" in channel.status.text


def test_a_track_is_thinned_out_and_keeps_its_ends() -> None:
    tracks = VehicleTracks()
    for metre in range(20_000):
        tracks.note(1, float(metre), 0.0)
    ((_, points),) = tracks.lines()
    assert len(points) <= MAX_TRACK_POINTS
    assert points[0] == (0.0, 0.0)
    assert points[-1][0] > 19_000.0


# --- what would be sent -----------------------------------------------------------------------------------------------


def test_a_preview_has_every_message_and_no_secret() -> None:
    settings = SharingSettings(
        TakSettings("udp://239.2.3.1:6969"),
        WebhookSettings("https://host/hook"),
        CaltopoSettings(positions=True, map="ABC", credential_id="ID"),
    )
    lines = list(preview(settings, shown(FOUND), UTC_S))
    beginnings = [line.partition(" ")[0] for line in lines]
    assert [beginnings.count(one) for one in ("udp://239.2.3.1:6969", "GET", "POST")] == [4, 2, 4]
    assert any(line.startswith(f"GET {URL}/api/v1/position/report/SECRET?id=AOS01&lat=") for line in lines)
    assert any('"title": "Finding 1: Undecided"' in line for line in lines if line.startswith(f"POST {URL}/api/v1/map"))
