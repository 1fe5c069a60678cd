"""Proposals of others on the wire: what is shown, who decides, and what a flown mission puts on record."""

from __future__ import annotations

from collections.abc import AsyncIterator

import httpx
import pytest

from aos_gcs.api.access.roles import Role, needed_role
from aos_gcs.api.models.mission import MissionModel
from aos_gcs.clock import LoopClock
from aos_gcs.errors import MissionError
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.model.proposals import ProposalShape, ProposalUse
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.bridge import mirror_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.mission_flight import flying, prepare
from tests.unit.sharing.test_proposals import SQUARE, proposal

BASE_URL = "http://127.0.0.1:8080"


@pytest.fixture
async def mission() -> ScriptedMission:
    mission = ScriptedMission(LoopClock())
    mission.proposals.take([proposal("a"), proposal("b", shape=ProposalShape.AREA, points_deg=SQUARE)])
    return mission


@pytest.fixture
async def client(mission: ScriptedMission) -> AsyncIterator[httpx.AsyncClient]:
    async with OperatorClient(transport=httpx.ASGITransport(app_of(mission)), base_url=BASE_URL) as client:
        yield client


async def test_proposals_are_shown_with_what_they_can_be_used_for(client: httpx.AsyncClient) -> None:
    shown = MissionModel.model_validate_json((await client.get("/api/mission")).content).proposals
    assert [one.model_dump(mode="json") for one in shown] == (await client.get("/api/proposals")).json()
    assert [(one.name, one.use, one.altitude_amsl_m) for one in shown] == [("LKP", None, 300.0)] * 2
    assert shown[0].uses == [ProposalUse.LAUNCH, ProposalUse.RETURN, ProposalUse.FINDING, ProposalUse.DISMISSED]
    assert [(place.latitude_deg, place.longitude_deg) for place in shown[1].places] == list(SQUARE)


async def test_a_decision_is_made_once(client: httpx.AsyncClient) -> None:
    decided = await client.post("/api/proposals/2", json={"use": "no_go"})
    assert (decided.status_code, decided.json()["use"], decided.json()["operator"]) == (200, "no_go", "")
    again = await client.post("/api/proposals/2", json={"use": "dismissed"})
    assert (again.status_code, again.json()["message"]) == (
        409,
        "Another operator has decided about this proposal already.",
    )
    for path, body, status in (("1", {"use": "area"}, 409), ("99", {"use": "area"}, 409), ("1", {"use": "fly"}, 422)):
        assert (await client.post(f"/api/proposals/{path}", json=body)).status_code == status


def test_only_those_who_fly_decide() -> None:
    assert needed_role("POST", "/api/proposals/1") is Role.OPERATOR
    assert needed_role("GET", "/api/proposals") is Role.OBSERVER


@pytest.mark.looptime
async def test_a_decision_crosses_the_processes(mission: ScriptedMission) -> None:
    async with mirror_of(mission, mission) as mirror:
        decided = await mirror.decide_proposal(1, ProposalUse.FINDING, operator="Ada")
        assert mirror.snapshot().proposals[0] == decided
        with pytest.raises(MissionError, match="cannot be used as launch"):
            await mirror.decide_proposal(2, ProposalUse.LAUNCH, operator="Ada")


@pytest.mark.looptime
async def test_a_mission_records_who_took_over_what_and_marks_findings() -> None:
    flight = prepare(auto_start=False)
    async with flying(flight) as run:
        await flight.until(lambda: flight.view.snapshot().phase is Phase.READY)
        origin = flight.view.snapshot().origin
        assert origin is not None
        here = (round(origin.latitude_deg + 0.001, 7), round(origin.longitude_deg, 7))
        near, far = proposal("a", points_deg=(here,), sender="EAGLE 1"), proposal("b", points_deg=((1.0, 1.0),))
        flight.view.proposals.take([near, far, proposal("c", shape=ProposalShape.AREA, points_deg=SQUARE)])
        await flight.commands.decide_proposal(1, ProposalUse.FINDING, operator="Ada")
        with pytest.raises(MissionError, match="more than 50 km from the mission"):
            await flight.commands.decide_proposal(2, ProposalUse.FINDING, operator="Ada")
        await flight.commands.decide_proposal(3, ProposalUse.AREA, operator="Ada")
        shown = flight.view.snapshot()
        assert [record.use for record in shown.proposals] == [ProposalUse.FINDING, None, ProposalUse.AREA]
        (finding,) = shown.findings
        assert finding.position_enu_m[:2] == pytest.approx((0.0, 111.2), abs=0.2)
        assert (finding.operator, finding.comment) == ("Ada", "LKP, proposed by EAGLE 1 (TAK).")
        assert shown.area_enu_m == flight.commands.settings.area_enu_m  # Nothing is taken over without a plan.
        await flight.until(lambda: any("taken over" in text for text in flight.texts()))
        assert "Ada: proposal 'LKP' of EAGLE 1 (TAK) marked as finding" in flight.texts()
        assert "Ada: proposal 'LKP' of somebody (TAK) taken over as search area" in flight.texts()
        run.cancel()
