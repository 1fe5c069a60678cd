"""The HTTP routes, against a scripted mission."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest

from aos_gcs.api.convert.findings import target
from aos_gcs.api.errors import status_and_id
from aos_gcs.api.events import hub
from aos_gcs.api.models.base import ErrorModel
from aos_gcs.api.models.mission import MissionModel
from aos_gcs.api.models.preflight import PreflightCheckModel
from aos_gcs.api.models.steps import StepModel
from aos_gcs.clock import LoopClock
from aos_gcs.errors import AosError, CommandTimeoutError, LinkError, MissionError
from aos_gcs.mission.model.actions import Action
from aos_gcs.mission.model.findings import ErrorEllipse, TargetEstimate
from aos_gcs.mission.model.steps import PictureKind
from aos_gcs.ports import Severity
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.mission import ORIGIN, SILENT_ID, ScriptedMission

BASE_URL = "http://127.0.0.1:8080"


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.fixture
async def client(mission: ScriptedMission) -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(app_of(mission))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        yield client


def error_of(response: httpx.Response) -> ErrorModel:
    return ErrorModel.model_validate_json(response.content)


async def test_mission_shows_metres_and_degrees(client: httpx.AsyncClient) -> None:
    response = await client.get("/api/mission")

    assert response.status_code == 200
    shown = MissionModel.model_validate_json(response.content)
    first = shown.vehicles[0]
    assert first.position is not None
    assert first.position.east_m == -21.0
    assert first.position.latitude_deg == pytest.approx(ORIGIN.latitude_deg, abs=1e-3)
    assert first.battery_percent == pytest.approx(97.0)
    assert first.home is not None
    assert first.home.east_m == pytest.approx(-21.0, abs=0.01)
    assert shown.allowed_actions == [
        Action.CHOOSE,
        Action.START,
        Action.HOLD,
        Action.ABORT,
        Action.FOCUS,
        Action.OVERRIDE,
    ]


async def test_values_never_reported_are_null(client: httpx.AsyncClient) -> None:
    shown = MissionModel.model_validate_json((await client.get("/api/mission")).content)
    silent = next(vehicle for vehicle in shown.vehicles if vehicle.vehicle_id == SILENT_ID)
    told = {"vehicle_id", "autopilot", "mode", "mode_name", "task", "takes_part", "landed", "text", "components"}
    assert {name for name, value in silent if value is not None} == told


async def test_a_vehicle_shows_its_link_and_what_its_camera_has_seen(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    mission.make_step()
    shown = MissionModel.model_validate_json((await client.get("/api/mission")).content)
    link, camera = shown.vehicles[1].link, shown.vehicles[1].camera
    assert link is not None
    assert (link.round_trip_ms, link.clock_offset_ms, link.clock_drift_ppm) == (40.0, 4.0, 2.0)
    assert camera is not None
    assert (camera.frames, camera.last_step, len(camera.footprint)) == (1, 1, 4)
    assert camera.footprint[0].latitude_deg == pytest.approx(ORIGIN.latitude_deg, abs=1e-2)


async def test_steps_are_listed_oldest_first(client: httpx.AsyncClient, mission: ScriptedMission) -> None:
    assert (await client.get("/api/mission/steps")).json() == []
    mission.make_step()
    assert [step["step"] for step in (await client.get("/api/mission/steps")).json()] == [1]
    mission.make_step()
    listed = [StepModel.model_validate(step) for step in (await client.get("/api/mission/steps")).json()]
    assert [step.step for step in listed] == [1, 2]
    assert listed[1].missing[0].vehicle_id == SILENT_ID
    after = (await client.get("/api/mission/steps", params={"after": 1})).json()
    assert [step["step"] for step in after] == [2]
    assert (await client.get("/api/mission/steps", params={"after": -1})).status_code == 422


async def test_steps_of_hours_come_in_parts(
    client: httpx.AsyncClient, mission: ScriptedMission, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hub, "STEPS_PER_ANSWER", 3)
    for _ in range(5):
        mission.make_step()
    first = (await client.get("/api/mission/steps")).json()
    rest = (await client.get("/api/mission/steps", params={"after": first[-1]["step"]})).json()
    assert [[step["step"] for step in part] for part in (first, rest)] == [[1, 2, 3], [4, 5]]


@pytest.mark.parametrize("kind", PictureKind)
async def test_picture_comes_once_and_then_is_unchanged(
    client: httpx.AsyncClient, mission: ScriptedMission, kind: PictureKind
) -> None:
    missing = await client.get(f"/api/mission/pictures/{kind}.png")
    assert missing.status_code == 404
    assert error_of(missing).id == "not_found"
    assert "first step" in error_of(missing).message

    mission.make_step()
    found = await client.get(f"/api/mission/pictures/{kind}.png")
    assert found.status_code == 200
    assert found.headers["content-type"] == "image/png"
    assert found.headers["x-step"] == "1"
    assert found.content.startswith(b"\x89PNG")

    known = {"If-None-Match": found.headers["etag"]}
    assert (await client.get(f"/api/mission/pictures/{kind}.png", headers=known)).status_code == 304
    mission.make_step()
    assert (await client.get(f"/api/mission/pictures/{kind}.png", headers=known)).headers["x-step"] == "2"


async def test_notices_are_acknowledged_for_all(client: httpx.AsyncClient, mission: ScriptedMission) -> None:
    for text in ("wind", "rain"):
        mission.notify(Severity.WARNING, text)
    assert (await client.post("/api/notices/acknowledge", json={"notice_ids": [2, 2]})).status_code == 204
    assert (await client.post("/api/notices/acknowledge", json={"notice_ids": [2]})).status_code == 204
    shown = (await client.get("/api/mission")).json()["acknowledgements"]
    assert [(one["notice_id"], one["operator"]) for one in shown] == [(2, "")]
    refused = await client.post("/api/notices/acknowledge", json={"notice_ids": [1, 3]})
    assert (refused.status_code, error_of(refused).id) == (409, "action_not_allowed")
    for ids in ([], [0], list(range(1, 202))):
        assert (await client.post("/api/notices/acknowledge", json={"notice_ids": ids})).status_code == 422


async def test_action_answers_vehicle_by_vehicle(client: httpx.AsyncClient, mission: ScriptedMission) -> None:
    await client.post("/api/mission/actions", json={"action": "start"})
    response = await client.post("/api/mission/actions", json={"action": "hold", "vehicle_ids": [3, 1, 3]})

    assert response.status_code == 200
    assert [(result["vehicle_id"], result["accepted"]) for result in response.json()["results"]] == [
        (1, True),
        (3, True),
    ]
    assert mission.actions == [(Action.START, None), (Action.HOLD, (3, 1))]


async def test_action_that_the_phase_forbids_is_a_conflict(client: httpx.AsyncClient) -> None:
    response = await client.post("/api/mission/actions", json={"action": "land"})
    assert response.status_code == 409
    assert error_of(response).id == "action_not_allowed"
    assert "no vehicle is flying yet" in error_of(response).message


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ({"action": "explode"}, "action"),
        ({}, "action"),
        ({"action": "hold", "vehicle_ids": []}, "vehicle_ids"),
        ({"action": "hold", "vehicle_ids": [0]}, "vehicle_ids"),
        ({"action": "hold", "vehicles": [1]}, "vehicles is unknown"),
        ({"action": "hold", "vehicle_ids": [True]}, "vehicle_ids[0] must be a whole number"),
        ({"action": "hold", "vehicle_ids": ["1"]}, "vehicle_ids[0] must be a whole number"),
        ({"action": "focus", "focal_height_m": "2"}, "focal_height_m must be a number"),
    ],
)
async def test_request_that_cannot_be_understood(
    client: httpx.AsyncClient, mission: ScriptedMission, body: dict[str, object], place: str
) -> None:
    response = await client.post("/api/mission/actions", json=body)
    assert response.status_code == 422
    assert error_of(response).id == "invalid_request"
    assert place in error_of(response).message
    assert mission.actions == []


@pytest.mark.parametrize("path", ["/api/nothing", "/api/mission/pictures/xray.png", "/nothing.js"])
async def test_unknown_paths_have_the_error_body(client: httpx.AsyncClient, path: str) -> None:
    response = await client.get(path)
    assert response.status_code in {404, 422}
    assert error_of(response).message


def all_errors(root: type[AosError] = AosError) -> list[type[AosError]]:
    return [root, *(each for child in root.__subclasses__() for each in all_errors(child))]


def test_every_error_has_a_status() -> None:
    for kind in all_errors():
        status, error_id = status_and_id(kind("text"))
        assert 400 <= status < 600, kind
        assert error_id
    assert status_and_id(MissionError("text"))[0] == 409
    assert status_and_id(LinkError("text")) == (502, "link_failed")
    assert status_and_id(CommandTimeoutError("text")) == (502, "command_failed")


# --- the dashboard's files


async def test_page_that_is_not_built_says_how(mission: ScriptedMission, tmp_path: Path) -> None:
    transport = httpx.ASGITransport(app_of(mission, tmp_path / "static"))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        response = await client.get("/")
    assert response.status_code == 503
    assert "npm run build" in response.text


async def test_page_is_revalidated_and_its_hashed_files_are_kept(mission: ScriptedMission, tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<p>page</p>")
    (tmp_path / "icon.svg").write_text("<svg/>")
    (tmp_path / "service-worker.js").write_text("1")
    (tmp_path / "manifest.webmanifest").write_text("{}")
    (tmp_path / "assets" / "index-1a2b.js").write_text("1")
    transport = httpx.ASGITransport(app_of(mission, tmp_path))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        page = await client.get("/")
        assert page.headers["cache-control"] == "no-cache"
        assert "frame-ancestors 'none'" in page.headers["content-security-policy"]
        assert (await client.get("/icon.svg")).headers["cache-control"] == "no-cache"
        assert (await client.get("/service-worker.js")).headers["cache-control"] == "no-cache"
        manifest = await client.get("/manifest.webmanifest")
        assert manifest.headers["content-type"].startswith("application/manifest+json")
        assert "immutable" in (await client.get("/assets/index-1a2b.js")).headers["cache-control"]
        assert (await client.get("/../secret")).status_code == 404


@pytest.mark.parametrize(
    ("accepted", "encoding", "content"),
    [
        ("gzip, deflate, br, zstd", "br", b"brotli"),
        ("gzip, deflate", "gzip", b"zipped"),
        ("br;q=0, gzip;q=0.5", "gzip", b"zipped"),
        ("br; q=0.0, gzip; q=0", None, b"plain"),
        ("identity", None, b"plain"),
    ],
)
async def test_files_are_sent_in_the_best_form_that_the_browser_reads(
    mission: ScriptedMission, tmp_path: Path, accepted: str, encoding: str | None, content: bytes
) -> None:
    folder = tmp_path / "assets"
    folder.mkdir()
    for ending, form in (("", b"plain"), (".gz", b"zipped"), (".br", b"brotli")):
        (folder / f"index-1a2b.js{ending}").write_bytes(form)
    (folder / "small.css").write_text("p{}")
    transport = httpx.ASGITransport(app_of(mission, tmp_path))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        async with client.stream("GET", "/assets/index-1a2b.js", headers={"Accept-Encoding": accepted}) as response:
            assert b"".join([part async for part in response.aiter_raw()]) == content
        assert response.headers.get("content-encoding") == encoding
        assert response.headers["content-type"].startswith("text/javascript")
        assert "immutable" in response.headers["cache-control"]
        plain = await client.get("/assets/small.css", headers={"Accept-Encoding": accepted})
        assert (plain.text, plain.headers.get("content-encoding")) == ("p{}", None)


def test_a_target_shows_the_ellipse_of_its_error_in_degrees() -> None:
    estimate = TargetEstimate(
        (3.0, 4.0, 0.5),
        0.8,
        7,
        track_id=2,
        ellipse=ErrorEllipse(1.0, 0.5, math.radians(30.0)),
        velocity_enu_mps=(0.9, 1.2),
        seen_at_s=41.0,
    )
    shown = target(estimate, ORIGIN)
    assert shown.ellipse is not None
    assert (shown.ellipse.semi_major_m, shown.ellipse.heading_deg) == pytest.approx((1.0, 30.0))
    assert shown.speed_mps == pytest.approx(1.5)
    assert (shown.track_id, shown.sightings, shown.seen_at_s) == (2, 7, 41.0)
    assert shown.position.latitude_deg == pytest.approx(ORIGIN.latitude_deg, abs=1e-3)


async def test_the_focal_height_is_set_and_given_back(client: httpx.AsyncClient) -> None:
    for height_m, source in ((1.5, "operator"), (None, "configured")):
        body = {"action": "focus", "focal_height_m": height_m}
        response = await client.post("/api/mission/actions", json=body)
        assert response.status_code == 200
        focus = MissionModel.model_validate_json((await client.get("/api/mission")).content).focus
        assert focus is not None
        assert (focus.height_m, focus.source) == (height_m or 0.0, source)


async def test_a_focal_height_that_is_no_number_is_refused(client: httpx.AsyncClient) -> None:
    body = '{"action": "focus", "focal_height_m": NaN}'
    response = await client.post("/api/mission/actions", content=body, headers={"Content-Type": "application/json"})
    assert response.status_code == 422


async def test_a_failed_check_can_be_overridden_and_taken_back(client: httpx.AsyncClient) -> None:
    body = {"vehicle_id": SILENT_ID, "check": "camera", "reason": "it only carries the radio"}
    response = await client.post("/api/preflight/override", json=body)
    assert response.status_code == 200
    check = PreflightCheckModel.model_validate_json(response.content)
    assert check.overridden is not None
    assert (check.status, check.blocks, check.overridden.reason) == ("fail", False, "it only carries the radio")
    shown = MissionModel.model_validate_json((await client.get("/api/mission")).content)
    assert check in shown.preflight
    response = await client.post("/api/preflight/override", json=body | {"reason": None})
    assert PreflightCheckModel.model_validate_json(response.content).blocks


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"check": "link"}, 409),
        ({"vehicle_id": 99}, 409),
        ({"vehicle_id": -1}, 422),
        ({"reason": ""}, 422),
        ({"reason": "x" * 501}, 422),
        ({"status": "pass"}, 422),
    ],
)
async def test_overrides_that_are_none_are_refused(
    client: httpx.AsyncClient, change: dict[str, object], status: int
) -> None:
    body = {"vehicle_id": SILENT_ID, "check": "camera", "reason": "why not"} | change
    response = await client.post("/api/preflight/override", json=body)
    assert (response.status_code, bool(error_of(response).message)) == (status, True)
