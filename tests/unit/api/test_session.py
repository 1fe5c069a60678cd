"""Operators sign in; observers look and change nothing."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from aos_gcs.api.access.guess_throttle import FORGET_AFTER_S, FREE_GUESSES, GUESSES_PER_MINUTE, GuessThrottle
from aos_gcs.api.access.operator_code import read_code
from aos_gcs.api.access.operator_file import FILE_NAME, OperatorFile
from aos_gcs.api.access.operators import MAX_ADDRESSES, MAX_OPERATORS, Access, Role, WrongCodeError
from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.mission.model.actions import Action
from aos_gcs.runtime.sign_in import operator_secrets
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.hand_time import HandTime
from tests.fakes.mission import ScriptedMission

CODE = "larch-and-spruce"
BASE_URL = "http://127.0.0.1:8080"
HERE = "127.0.0.1"


@pytest.fixture
def time() -> HandTime:
    return HandTime()


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.fixture
async def client(mission: ScriptedMission, time: HandTime) -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(app_of(mission, operator_code=CODE, now_s=time))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        yield client


async def sign_in(client: httpx.AsyncClient, name: str = "Ada", code: str = CODE) -> httpx.Response:
    return await client.post("/api/session", json={"code": code, "name": name})


async def start(client: httpx.AsyncClient) -> httpx.Response:
    return await client.post("/api/mission/actions", json={"action": "start"})


async def test_observers_see_everything_and_command_nothing(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    assert (await client.get("/api/session")).json() == {
        "role": "observer",
        "name": "",
        "sign_in_required": True,
        "accounts": False,
    }
    assert (await client.get("/api/mission")).status_code == 200
    refused = await start(client)
    assert (refused.status_code, refused.json()["id"]) == (403, "operators_only")
    assert mission.actions == []


async def test_an_operator_commands_under_their_name(client: httpx.AsyncClient, mission: ScriptedMission) -> None:
    signed_in = await sign_in(client, "Ada Lovelace")
    assert signed_in.json() == {"role": "operator", "name": "Ada Lovelace", "sign_in_required": True, "accounts": False}
    cookie = signed_in.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert CODE not in cookie

    assert (await start(client)).status_code == 200
    assert mission.actions == [(Action.START, None)]
    assert mission.operators == ["Ada Lovelace"]


async def test_a_wrong_code_opens_nothing(client: httpx.AsyncClient) -> None:
    refused = await sign_in(client, code=CODE + "x")
    assert (refused.status_code, refused.json()["id"]) == (403, "wrong_code")
    assert (await start(client)).status_code == 403


async def test_guessing_is_slowed_down_and_commands_are_not(
    client: httpx.AsyncClient, mission: ScriptedMission, time: HandTime
) -> None:
    await sign_in(client)
    for _ in range(FREE_GUESSES):
        assert (await sign_in(client, code="guess")).status_code == 403
    assert (await sign_in(client, code="guess")).status_code == 403
    refused = await sign_in(client)  # the right code, too, or else guessing would go on
    assert (refused.status_code, refused.json()["id"]) == (429, "too_many_guesses")
    assert refused.headers["Retry-After"] == "1"
    assert "Wait 1 s, then sign in" in refused.json()["message"]
    # Who is signed in already notices nothing of it.
    command = await start(client)
    assert (command.status_code, mission.operators) == (200, ["Ada"])
    time.now_s += 1.0
    assert (await sign_in(client)).status_code == 200
    assert (await sign_in(client, code="guess")).status_code == 403, "begins anew after the right one"


def test_each_wrong_code_costs_twice_the_wait_of_the_one_before(time: HandTime) -> None:
    throttle = GuessThrottle(time)
    waits_s = []
    for _ in range(FREE_GUESSES + 9):
        throttle.note_wrong(HERE)
        waits_s.append(throttle.wait_s(HERE))
        time.now_s += waits_s[-1]
        assert throttle.wait_s(HERE) == 0.0
    assert waits_s[FREE_GUESSES - 1 :] == [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0, 60.0, 60.0]
    time.now_s += FORGET_AFTER_S + 1.0
    throttle.note_wrong(HERE)
    assert throttle.wait_s(HERE) == 0.0


def test_signing_in_with_an_own_account_forgives_no_guesses_about_others(time: HandTime) -> None:
    throttle, guesses = GuessThrottle(time), 0
    for _ in range(20):
        while throttle.wait_s(HERE) == 0.0 and guesses % FREE_GUESSES != FREE_GUESSES - 1:
            throttle.note_wrong(HERE, "Ada")
            guesses += 1
        throttle.note_wrong(HERE, "Olga")
        throttle.note_right(HERE, "Olga")
        guesses += 1
    assert throttle.wait_s(HERE) > 0.0
    time.now_s += FORGET_AFTER_S + 1.0
    for _ in range(FREE_GUESSES - 1):
        throttle.note_wrong(HERE, "ada")
    throttle.note_wrong(HERE, "Ada")
    throttle.note_right(HERE, "Ada")
    throttle.note_wrong(HERE, "Ada")
    assert throttle.wait_s(HERE) == 0.0, "begins anew after the right one"


def test_many_addresses_together_have_a_budget_that_leaves_this_machine_alone(time: HandTime) -> None:
    throttle = GuessThrottle(time)
    guesses = 0
    for number in range(5000):
        time.now_s += 0.1
        address = f"10.0.{number // 250}.{number % 250}"
        if throttle.wait_s(address) == 0.0:
            throttle.note_wrong(address)
            guesses += 1
        assert throttle.wait_s(HERE) == 0.0
    minutes = 5000 * 0.1 / 60.0
    assert guesses <= GUESSES_PER_MINUTE * (minutes + 1.0)


@pytest.mark.parametrize(
    ("one", "other", "is_same"),
    [
        ("2001:db8::1", "2001:db8::ffff:2", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
        ("::ffff:10.0.0.1", "10.0.0.1", True),
        ("::ffff:10.0.0.1", "::ffff:10.0.0.2", False),
    ],
)
def test_a_machine_counts_once_whatever_address_it_takes(time: HandTime, one: str, other: str, is_same: bool) -> None:
    throttle = GuessThrottle(time)
    for _ in range(FREE_GUESSES + 1):
        throttle.note_wrong(one)
    assert (throttle.wait_s(other) > 0.0) is is_same


async def test_whoever_signs_out_observes(client: httpx.AsyncClient) -> None:
    await sign_in(client)
    cookies = dict(client.cookies)
    assert (await client.delete("/api/session")).json()["role"] == "observer"
    client.cookies.update(cookies)  # the old cookie is worth nothing either
    assert (await start(client)).status_code == 403


async def test_a_made_up_cookie_is_refused(client: httpx.AsyncClient) -> None:
    client.cookies.set("aos_gcs_8080", "operator")
    assert (await start(client)).status_code == 403


async def test_a_service_without_code_lets_everybody_command(mission: ScriptedMission) -> None:
    transport = httpx.ASGITransport(app_of(mission))
    async with OperatorClient(transport=transport, base_url=BASE_URL) as client:
        assert (await client.get("/api/session")).json()["role"] == "operator"
        assert (await sign_in(client)).json()["sign_in_required"] is False
        assert (await start(client)).status_code == 200


@pytest.mark.parametrize("body", [{}, {"code": CODE}, {"code": CODE, "name": " "}, {"code": CODE, "name": 41 * "x"}])
async def test_a_sign_in_that_cannot_be_understood(client: httpx.AsyncClient, body: dict[str, str]) -> None:
    assert (await client.post("/api/session", json=body)).status_code == 422


async def test_every_route_that_changes_something_is_for_operators(
    client: httpx.AsyncClient, mission: ScriptedMission
) -> None:
    for path, method in _changing_routes(mission):
        response = await client.request(method, path.replace("{", "").replace("}", ""))
        assert response.json()["id"] == "operators_only", (method, path)


def _changing_routes(mission: ScriptedMission) -> Iterator[tuple[str, str]]:
    for path, item in app_of(mission).openapi()["paths"].items():
        for method in item:
            # Anybody signs in, and anybody may know what is wrong with a plan.
            if method != "get" and path not in {
                "/api/session",
                "/api/session/invitation",
                "/api/session/password",
                "/api/plan/check",
            }:
                yield path, method


def test_the_longest_session_makes_room_for_a_new_one() -> None:
    access = Access(CODE, HandTime())
    first = access.sign_in(CODE, "first", HERE)
    last = [access.sign_in(CODE, "another", HERE) for _ in range(MAX_OPERATORS)][-1]
    assert access.session(first).role is Role.OBSERVER
    assert access.session(last).role is Role.OPERATOR


def test_codes_beyond_ascii_are_compared_too() -> None:
    access = Access("fjällräven", HandTime())
    assert access.session(access.sign_in("fjällräven", "Åsa", HERE)).name == "Åsa"
    with pytest.raises(WrongCodeError):
        access.sign_in("fjallraven", "Åsa", HERE)


def test_the_code_is_read_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "code.txt"
    file.write_text(f"  {CODE}\n")
    assert read_code(file) == CODE
    file.write_text("short\n")
    with pytest.raises(ConfigurationError, match="8 or more characters"):
        read_code(file)
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_code(tmp_path / "missing.txt")


async def test_code_and_sign_ins_outlast_a_restart(tmp_path: Path) -> None:
    def start() -> Access:
        secrets = operator_secrets(ApiConfig(), tmp_path)
        return Access(secrets.code, HandTime(), secrets.file)

    code = operator_secrets(ApiConfig(), tmp_path).code
    access = start()
    staying, leaving = access.sign_in(code, "Ada", HERE), access.sign_in(code, "Bob", HERE)
    await access.write_down()
    access.sign_out(leaving)
    await access.write_down()

    access = start()
    assert access.session(staying).name == "Ada"
    assert access.session(leaving).role is Role.OBSERVER
    path = tmp_path / FILE_NAME
    assert path.stat().st_mode & 0o077 == 0
    assert staying not in path.read_text()


async def test_addresses_of_operators_outlast_the_process(tmp_path: Path) -> None:
    def serving(code: str) -> tuple[FastAPI, httpx.AsyncClient]:
        app = app_of(ScriptedMission(LoopClock()), operator_code=code, operator_file=OperatorFile(file))
        transport = httpx.ASGITransport(app, client=("10.0.0.7", 5000))
        return app, OperatorClient(transport=transport, base_url=BASE_URL)

    file = tmp_path / FILE_NAME
    app, client = serving(CODE)
    async with client:
        await sign_in(client)
        assert not app.state.limits.connections.is_known("10.0.0.7")
        await client.get("/api/session")
        await asyncio.gather(*asyncio.all_tasks() - {asyncio.current_task()})
    app, client = serving(CODE)
    await client.aclose()
    assert app.state.limits.connections.is_known("10.0.0.7")
    access = app.state.access
    assert not access.note_address("10.0.0.7")
    for number in range(MAX_ADDRESSES):
        assert access.note_address(f"10.1.0.{number}")
    assert len(access.addresses) == MAX_ADDRESSES
    assert "10.0.0.7" not in access.addresses
    assert OperatorFile(file).addresses("another code") == ()


async def test_another_code_ends_all_sessions(tmp_path: Path) -> None:
    file = tmp_path / "code.txt"
    file.write_text(CODE)
    config = ApiConfig(operator_code_file=file)
    secrets = operator_secrets(config, tmp_path)
    access = Access(secrets.code, HandTime(), secrets.file)
    token = access.sign_in(CODE, "Ada", HERE)
    await access.write_down()
    file.write_text(CODE + "-2")
    secrets = operator_secrets(config, tmp_path)
    assert Access(secrets.code, HandTime(), secrets.file).session(token).role is Role.OBSERVER


@pytest.mark.parametrize("content", [b"", b"\xff", b"[]", b'{"sessions": {"x": 1}}', b'{"code": null}'])
def test_a_damaged_file_of_operators_stops_nothing(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "operators"
    path.write_bytes(content)
    assert OperatorFile(path).sessions(CODE) == {}
    assert OperatorFile(path).code("new-code") == "new-code"
    assert OperatorFile(path).code("another") == "new-code"


def test_a_folder_that_cannot_be_written_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    file = OperatorFile(tmp_path / "file" / "operators")
    assert file.code("new-code") == "new-code"
