"""One of several operators has control; the others ask for it or take it over, and everybody holds."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from aos_gcs.api.access.control import PRESENT_FOR_S, REQUEST_LASTS_S, Control, NotInControlError
from aos_gcs.api.access.operator_file import OperatorFile
from aos_gcs.api.access.operators import Access
from aos_gcs.clock import LoopClock
from aos_gcs.errors import InputDataError
from aos_gcs.mission.model.actions import Action
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.hand_time import HandTime
from tests.fakes.mission import ScriptedMission
from tests.timing import scaled_s

CODE = "larch-and-spruce"
BASE_URL = "http://127.0.0.1:8080"


@pytest.fixture
def time() -> HandTime:
    return HandTime()


@pytest.fixture
def control(time: HandTime) -> Control:
    control = Control(time)
    for name in ("Ada", "Robin"):
        control.begin_following(name)
    return control


# --- who has control --------------------------------------------------------------------------------------------------


def test_an_operator_who_is_alone_notices_nothing(time: HandTime) -> None:
    control = Control(time)
    control.begin_following("Ada")
    assert control.claim("Ada") is False  # nothing to tell
    assert control.claim("Ada") is False
    assert control.state().holder == "Ada"


def test_the_first_of_several_who_commands_has_control(control: Control) -> None:
    assert control.claim("Robin") is True
    with pytest.raises(NotInControlError, match=r"Robin has control\. Ask for control or take it over"):
        control.claim("Ada")
    assert control.claim("Robin") is False


def test_control_is_asked_for_and_granted_or_refused(control: Control) -> None:
    control.claim("Robin")
    assert control.ask("Ada") is False
    assert control.state().requests == ("Ada",)
    with pytest.raises(NotInControlError):
        control.answer("Ada", "Ada", granted=True)  # nobody grants it to themselves
    control.answer("Robin", "Ada", granted=False)
    assert (control.state().holder, control.state().requests) == ("Robin", ())
    control.ask("Ada")
    control.answer("Robin", "Ada", granted=True)
    assert control.state().holder == "Ada"
    with pytest.raises(NotInControlError):
        control.claim("Robin")


def test_a_request_that_nobody_answers_is_forgotten(control: Control, time: HandTime) -> None:
    control.claim("Robin")
    control.ask("Ada")
    time.now_s += REQUEST_LASTS_S + 1.0
    with pytest.raises(InputDataError, match="Ada does not ask for control now"):
        control.answer("Robin", "Ada", granted=True)
    assert control.state().holder == "Robin"


@pytest.mark.parametrize("reason", ["", "  ", "no"])
def test_control_is_taken_over_with_a_reason_only(control: Control, reason: str) -> None:
    control.claim("Robin")
    with pytest.raises(InputDataError, match=r"reason: .*why you take over control from Robin"):
        control.take("Ada", reason)
    assert control.state().holder == "Robin"
    assert control.take("Ada", "Robin does not answer") == "Robin"
    assert control.state().holder == "Ada"


def test_control_of_somebody_who_is_gone_goes_to_the_next_who_commands(control: Control, time: HandTime) -> None:
    control.claim("Robin")
    control.end_following("Robin")
    time.now_s += PRESENT_FOR_S - 1.0
    with pytest.raises(NotInControlError):  # the page may be about to reconnect
        control.claim("Ada")
    time.now_s += 2.0
    assert control.state() == type(control.state())("Robin", False, ("Ada",), ())
    assert control.claim("Ada") is True
    control.begin_following("Robin")  # and does not get it back by coming back
    with pytest.raises(NotInControlError):
        control.claim("Robin")


def test_a_second_page_of_the_same_person_has_the_same_control(control: Control, time: HandTime) -> None:
    control.begin_following("Robin")
    control.claim("Robin")
    control.end_following("Robin")
    time.now_s += 100.0
    assert control.state().is_holder_present
    with pytest.raises(NotInControlError):
        control.claim("Ada")


def test_control_that_was_given_up_is_free(control: Control) -> None:
    control.claim("Robin")
    with pytest.raises(NotInControlError):
        control.release("Ada")
    control.release("Robin")
    assert control.ask("Ada") is True


async def test_control_outlasts_the_process(tmp_path: Path, time: HandTime, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aos_gcs.api.access.operators._WRITTEN_WITHIN_S", scaled_s(30.0))

    def start() -> Access:
        return Access(CODE, time, OperatorFile(tmp_path / "operators.json"))

    access = start()
    access.control.claim("Robin")
    await access.write_down()
    time.now_s += 3600.0
    control = start().control
    with pytest.raises(NotInControlError):
        control.claim("Ada")
    time.now_s += PRESENT_FOR_S + 1.0
    control.claim("Ada")  # Robin has not come back


# --- over HTTP --------------------------------------------------------------------------------------------------------


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.fixture
def app(mission: ScriptedMission, time: HandTime) -> FastAPI:
    return app_of(mission, operator_code=CODE, now_s=time)


async def client_of(app: FastAPI, name: str) -> OperatorClient:
    client = OperatorClient(transport=httpx.ASGITransport(app), base_url=BASE_URL)
    await client.post("/api/session", json={"code": CODE, "name": name})
    return client


@pytest.fixture
async def robin(app: FastAPI) -> AsyncIterator[OperatorClient]:
    client = await client_of(app, "Robin")
    yield client
    await client.aclose()


@pytest.fixture
async def ada(app: FastAPI) -> AsyncIterator[OperatorClient]:
    client = await client_of(app, "Ada")
    yield client
    await client.aclose()


async def act(client: OperatorClient, action: str) -> httpx.Response:
    return await client.post("/api/mission/actions", json={"action": action})


async def test_commands_without_control_are_refused_with_who_has_it_and_holds_never(
    robin: OperatorClient, ada: OperatorClient, mission: ScriptedMission
) -> None:
    assert (await act(robin, "start")).status_code == 200
    plan = (await ada.get("/api/plan")).json()
    override = {"vehicle_id": 1, "check": "home", "reason": "seen"}
    for answer in (
        await act(ada, "return"),
        await ada.post("/api/plan/apply", json=plan),
        await ada.post("/api/preflight/override", json=override),
    ):
        assert (answer.status_code, answer.json()["id"]) == (409, "not_in_control")
        assert "Robin has control" in answer.json()["message"]
    assert (await act(ada, "hold")).status_code == 200
    assert mission.actions == [(Action.START, None), (Action.HOLD, None)]
    assert mission.announced == []  # Robin was alone until then


async def test_each_change_of_control_is_shown_and_on_record(
    robin: OperatorClient, ada: OperatorClient, mission: ScriptedMission
) -> None:
    await act(robin, "start")
    assert (await ada.post("/api/control/request")).json()["requests"] == ["Ada"]
    shown = (await robin.get("/api/mission")).json()["control"]
    assert shown == {"holder": "Robin", "holder_present": True, "operators": ["Ada", "Robin"], "requests": ["Ada"]}
    await robin.post("/api/control/answer", json={"operator": "Ada", "granted": False})
    assert (await act(ada, "return")).status_code == 409
    unexplained = await ada.post("/api/control/take", json={})
    assert (unexplained.status_code, unexplained.json()["id"]) == (422, "unusable_data")
    taken = await ada.post("/api/control/take", json={"reason": "battery of\n vehicle 3"})
    assert taken.json()["holder"] == "Ada"
    assert (await act(ada, "return")).status_code == 200
    assert (await robin.post("/api/control/answer", json={"operator": "Ada", "granted": True})).status_code == 409
    assert mission.announced == [
        ("Ada", "asks Robin for control"),
        ("Robin", "keeps control; refuses Ada"),
        ("Ada", "takes over control from Robin: battery of vehicle 3"),
    ]


async def test_a_command_goes_on_by_itself_when_the_one_in_control_is_gone(
    robin: OperatorClient, ada: OperatorClient, time: HandTime, mission: ScriptedMission
) -> None:
    await act(robin, "start")
    time.now_s += PRESENT_FOR_S + 1.0
    assert (await act(ada, "return")).status_code == 200
    assert mission.announced == [("Ada", "has control")]


async def test_where_nobody_signs_in_there_is_no_control(mission: ScriptedMission) -> None:
    async with OperatorClient(transport=httpx.ASGITransport(app_of(mission)), base_url=BASE_URL) as client:
        assert (await act(client, "start")).status_code == 200
        assert (await client.get("/api/mission")).json()["control"] is None
