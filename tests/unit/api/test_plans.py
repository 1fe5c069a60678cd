"""Plans through the API: checked, imported, saved, applied."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from aos_gcs.api.app import create_app
from aos_gcs.api.models.plans import PlanModel, PlanReportModel
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.actions import Action
from aos_gcs.planning.shape_files import MAX_FILE_BYTES
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.mission import ORIGIN, ScriptedMission


def rectangle(south: float, west: float, north: float, east: float) -> list[dict[str, float]]:
    """Corners, in thousandths of a degree from the origin."""
    corners = ((south, west), (south, east), (north, east), (north, west))
    return [
        {
            "latitude_deg": ORIGIN.latitude_deg + 1e-3 * north_mdeg,
            "longitude_deg": ORIGIN.longitude_deg + 1e-3 * east_mdeg,
        }
        for north_mdeg, east_mdeg in corners
    ]


PLAN: dict[str, Any] = {"vehicles": 6, "area": rectangle(0, 0, 1, 1), "layer_spacing_m": 3.0}


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.fixture
async def client(mission: ScriptedMission, tmp_path: Path) -> AsyncIterator[httpx.AsyncClient]:
    app = app_of(mission, plans_folder=tmp_path / "plans")
    async with OperatorClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1:8080") as client:
        yield client


async def check(client: httpx.AsyncClient, **changes: Any) -> PlanReportModel:
    response = await client.post("/api/plan/check", json=PLAN | changes)
    assert response.status_code == 200, response.text
    return PlanReportModel.model_validate_json(response.content)


async def test_a_good_plan_comes_back_with_its_estimate(client: httpx.AsyncClient) -> None:
    report = await check(client)
    assert report.flyable
    assert report.problems == []
    assert report.estimate is not None
    assert report.estimate.area_m2 == pytest.approx(111.2 * 74.1, rel=0.02)
    assert report.estimate.legs[0].start.latitude_deg == pytest.approx(ORIGIN.latitude_deg, abs=2e-3)
    assert 0.0 < report.estimate.battery_percent < 100.0
    assert report.layers_m == [35.0, 38.0, 41.0, 44.0, 47.0, 50.0]


async def test_problems_name_the_fields_of_the_request(client: httpx.AsyncClient) -> None:
    report = await check(client, area=[], no_go=[rectangle(0, 0, 1, 1)[:2]], layer_spacing_m=0.5, strategy="magic")
    assert not report.flyable
    assert report.estimate is None
    assert {problem.field for problem in report.problems} == {"area", "no_go[0]", "layer_spacing_m", "strategy"}


async def test_refused_parameters_are_told_by_their_own_names(client: httpx.AsyncClient) -> None:
    report = await check(client, strategy_parameters={"gamma": 7, "c5": True})
    assert {problem.field for problem in report.problems} == {"strategy_parameters.gamma", "strategy_parameters.c5"}


async def test_strategies_come_with_what_can_be_chosen_about_them(client: httpx.AsyncClient) -> None:
    strategies = {one["name"]: one["parameters"] for one in (await client.get("/api/plan/strategies")).json()}
    gamma = next(parameter for parameter in strategies["aos-apso"] if parameter["name"] == "gamma")
    assert (gamma["default"], gamma["above"], gamma["below"], gamma["at_most"]) == (0.9, 0.0, 1.0, None)
    stabilised = next(parameter for parameter in strategies["aos-apso"] if parameter["name"] == "leader_stabilised")
    assert (stabilised["default"], stabilised["is_switch"]) == (True, True)
    assert "c4_m" not in {parameter["name"] for parameters in strategies.values() for parameter in parameters}


async def test_the_engine_proposes_in_the_units_of_the_request(client: httpx.AsyncClient) -> None:
    report = await check(client, area=rectangle(0, 0, 0.45, 4.0), layer_spacing_m=2.0)
    proposals = {proposal.field: proposal.value for proposal in report.proposals}
    assert proposals["scan_heading_deg"] == pytest.approx(90.0, abs=10.0)
    assert proposals["layer_spacing_m"] == 3.0


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"vehicles": 0}, "vehicles"),
        ({"area": [{"latitude_deg": 91.0, "longitude_deg": 0.0}]}, "area[0].latitude_deg"),
        ({"area": [[48.0, 14.0]]}, "area[0]"),
        ({"scan_heading_deg": 400}, "scan_heading_deg"),
        ({"altitude": 30}, "altitude is unknown"),
        ({"vehicles": True}, "vehicles must be a whole number"),
        ({"vehicles": "3"}, "vehicles must be a whole number"),
        ({"lowest_layer_m": "40"}, "lowest_layer_m must be a number"),
        ({"split": "yes"}, "split must be true or false"),
        ({"search_mode": "fast"}, "search_mode must be 'continuous' or 'stops'"),
    ],
)
async def test_what_is_no_plan_is_refused(client: httpx.AsyncClient, changes: dict[str, Any], place: str) -> None:
    response = await client.post("/api/plan/check", json=PLAN | changes)
    assert response.status_code == 422
    assert place in response.json()["message"]


async def test_numbers_that_json_does_not_know_are_refused(client: httpx.AsyncClient) -> None:
    body = '{"vehicles": 3, "ceiling_m": NaN}'
    response = await client.post("/api/plan/check", content=body, headers={"Content-Type": "application/json"})
    assert response.status_code == 422


async def test_a_plan_is_applied_and_shown_until_the_start(client: httpx.AsyncClient, mission: ScriptedMission) -> None:
    applied = await client.post("/api/plan/apply", json=PLAN)
    assert applied.status_code == 200
    shown = PlanModel.model_validate_json((await client.get("/api/plan")).content)
    assert shown == PlanModel.model_validate_json(applied.content)
    assert shown.area[2].latitude_deg == pytest.approx(PLAN["area"][2]["latitude_deg"], abs=1e-9)
    assert (await client.get("/api/mission")).json()["area"][1]["east_m"] == pytest.approx(74.1, abs=0.5)

    await mission.act(Action.START, None)
    late = await client.post("/api/plan/apply", json=PLAN)
    assert (late.status_code, late.json()["id"]) == (409, "action_not_allowed")


async def test_a_plan_that_does_not_say_whether_the_swarm_splits_leaves_it_as_it_is(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    large = PLAN | {"vehicles": 10}
    assert (await client.post("/api/plan/apply", json=large | {"split": True})).status_code == 200
    assert (await client.post("/api/plan/apply", json=large)).json()["split"]
    assert mission.settings.search.split
    (few,) = (one for one in (await check(client, vehicles=2)).problems if one.field == "split")
    assert not few.blocking

    assert (await client.put("/api/plans/old", json=large)).status_code == 200
    assert (await client.get("/api/plans/old")).json()["split"]
    assert (await client.post("/api/plan/apply", json=large | {"split": False})).status_code == 200
    assert not mission.settings.search.split
    assert not (await client.get("/api/plans/old")).json()["split"]


async def test_plans_are_saved_listed_and_deleted(client: httpx.AsyncClient) -> None:
    assert (await client.get("/api/plans")).json() == []
    for name in ("Überlingen 2", "a"):
        assert (await client.put(f"/api/plans/{name}", json=PLAN)).status_code == 200
    assert [entry["name"] for entry in (await client.get("/api/plans")).json()] == ["a", "Überlingen 2"]
    saved = PlanModel.model_validate_json((await client.get("/api/plans/a")).content)
    assert saved == PlanModel.model_validate(PLAN)
    assert (await client.delete("/api/plans/a")).status_code == 204
    assert (await client.delete("/api/plans/a")).status_code == 404
    assert (await client.get("/api/plans/a")).status_code == 404


async def test_what_another_screen_has_saved_is_not_replaced_unseen(client: httpx.AsyncClient) -> None:
    async def version() -> str:
        (entry,) = (await client.get("/api/plans")).json()
        return str(entry["version"])

    first = await client.put("/api/plans/a?replaces=none", json=PLAN)
    assert first.status_code == 200
    again = await client.put("/api/plans/a?replaces=none", json=PLAN)
    assert (again.status_code, again.json()["id"]) == (409, "plan_changed")
    assert "already" in again.json()["message"]

    seen = await version()
    assert (await client.put(f"/api/plans/a?replaces={seen}", json=PLAN | {"vehicles": 7})).status_code == 200
    late = await client.put(f"/api/plans/a?replaces={seen}", json=PLAN | {"vehicles": 8})
    assert (late.status_code, (await client.get("/api/plans/a")).json()["vehicles"]) == (409, 7)
    assert "saved by another operator" in late.json()["message"]
    assert (await client.delete("/api/plans/a")).status_code == 204
    gone = await client.put("/api/plans/a?replaces=1-2", json=PLAN)
    assert "removed by another operator" in gone.json()["message"]


async def test_letters_are_the_same_however_they_were_typed(client: httpx.AsyncClient) -> None:
    await client.put("/api/plans/Büchsenhausen", json=PLAN)
    assert (await client.get("/api/plans/Bu\u0308chsenhausen")).status_code == 200


@pytest.mark.parametrize("name", [".hidden", "..", "a%2Fb", "..%2F..%2Fetc", "x" * 60, "a%00b", "a:b"])
async def test_names_that_leave_the_folder_are_refused(client: httpx.AsyncClient, name: str, tmp_path: Path) -> None:
    response = await client.put(f"/api/plans/{name}", json=PLAN)
    assert response.status_code in {404, 405, 422}
    if response.status_code == 422:
        assert "letters, digits" in response.json()["message"] or "64" in response.json()["message"]
    assert await asyncio.to_thread(lambda: list(tmp_path.iterdir())) == []


async def test_a_damaged_saved_plan_is_told(client: httpx.AsyncClient, tmp_path: Path) -> None:
    (tmp_path / "plans").mkdir()
    (tmp_path / "plans" / "broken.json").write_text('{"vehicles": "many"}')
    response = await client.get("/api/plans/broken")
    assert (response.status_code, response.json()["id"]) == (422, "unusable_data")
    assert "vehicles must be a whole number" in response.json()["message"]
    assert "http" not in response.json()["message"]


async def test_shapes_of_a_file_are_returned(client: httpx.AsyncClient) -> None:
    ring = [[14.0, 48.0], [14.1, 48.0], [14.1, 48.1], [14.0, 48.0]]
    response = await client.post("/api/plan/import", json={"type": "Polygon", "coordinates": [ring]})
    (shape,) = response.json()
    assert (shape["role"], len(shape["places"])) == ("area", 3)
    assert shape["places"][0] == {"latitude_deg": 48.0, "longitude_deg": 14.0}


async def test_files_that_are_huge_or_broken_are_refused(client: httpx.AsyncClient) -> None:
    huge = await client.post("/api/plan/import", content=b" " * (MAX_FILE_BYTES + 1))
    assert (huge.status_code, huge.json()["id"]) == (413, "too_large")
    broken = await client.post("/api/plan/import", content=b"\x00\x01")
    assert (broken.status_code, broken.json()["id"]) == (422, "unusable_data")


async def test_the_record_of_a_mission_takes_no_plan(mission: ScriptedMission) -> None:
    transport = httpx.ASGITransport(create_app(mission))
    async with OperatorClient(transport=transport, base_url="http://127.0.0.1:8080") as client:
        assert (await client.get("/api/plan")).status_code == 409
        assert (await client.post("/api/plan/apply", json=PLAN)).status_code == 409
