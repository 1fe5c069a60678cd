"""Accounts of a command post: roles, sign-in, invitations, and what each role may ask for."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncIterator
from pathlib import Path

import argon2
import httpx
import pytest
from fastapi import FastAPI

from aos_gcs.api.access import passwords
from aos_gcs.api.access.account_sessions import SESSIONS_PER_ACCOUNT, UNUSED_S
from aos_gcs.api.access.accounts import Account, AccountError, AccountFile, InvitationError
from aos_gcs.api.access.guess_throttle import FREE_GUESSES, GUESSES_PER_MINUTE
from aos_gcs.api.access.operator_file import OperatorFile
from aos_gcs.api.access.operators import Access, AccessDeniedError, TooManyGuessesError
from aos_gcs.api.access.roles import ROUTE_ROLES, Role, needed_role
from aos_gcs.api.openapi import make_document
from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.mission.model.actions import Action
from aos_gcs.runtime.sign_in import operator_secrets
from tests.fakes.app import OperatorClient, app_of
from tests.fakes.hand_time import HandTime
from tests.fakes.mission import ScriptedMission
from tests.timing import scaled_s

PASSWORD = "larch and spruce"  # noqa: S105 - of the tests
BASE_URL = "http://127.0.0.1:8080"
PEOPLE = {
    "Olga": Role.OBSERVER,
    "Anders": Role.ANALYST,
    "Robin": Role.OPERATOR,
    "Ada": Role.ADMINISTRATOR,
}
HERE = "192.0.2.1"
_NOT_ENOUGH = {"sign_in_required", "role_required"}


@pytest.fixture(autouse=True)
def cheap_digests(monkeypatch: pytest.MonkeyPatch) -> None:
    hasher = argon2.PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
    monkeypatch.setattr(passwords, "_hasher", lambda: hasher)
    passwords._nobodys.cache_clear()


@pytest.fixture
def time() -> HandTime:
    return HandTime()


@pytest.fixture
def accounts(tmp_path: Path) -> AccountFile:
    file = AccountFile(tmp_path / "accounts.json")
    for name, role in PEOPLE.items():
        file.add(name, role, PASSWORD, 0.0)
    return file


@pytest.fixture
async def mission() -> ScriptedMission:
    return ScriptedMission(LoopClock())


@pytest.fixture
def app(mission: ScriptedMission, accounts: AccountFile, time: HandTime) -> FastAPI:
    return app_of(mission, operator_code="not used with accounts", accounts=accounts, now_s=time)


def client_of(app: FastAPI, address: str = HERE) -> OperatorClient:
    return OperatorClient(transport=httpx.ASGITransport(app, client=(address, 1)), base_url=BASE_URL)


@pytest.fixture
async def client(app: FastAPI) -> AsyncIterator[OperatorClient]:
    async with client_of(app) as client:
        yield client


async def sign_in(client: httpx.AsyncClient, name: str, password: str = PASSWORD) -> httpx.Response:
    return await client.post("/api/session", json={"name": name, "password": password})


# --- roles ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def routes() -> list[tuple[str, str]]:
    """Methods and paths of all routes, as the interface documents them."""
    return [(method.upper(), path) for path, item in make_document()["paths"].items() for method in item]


def test_the_table_names_every_route_that_changes_something_and_no_other(routes: list[tuple[str, str]]) -> None:
    documented = {(method, path.replace("/api/plans/{name}", "/api/plans/{name:path}")) for method, path in routes}
    assert {(method, path) for method, path in documented if method != "GET"} <= set(ROUTE_ROLES)
    assert set(ROUTE_ROLES) <= documented


@pytest.mark.parametrize("role", Role)
async def test_every_route_is_refused_to_lesser_roles_and_to_no_others(
    client: OperatorClient, role: Role, routes: list[tuple[str, str]]
) -> None:
    if role is not Role.VISITOR:
        name = next(name for name, its in PEOPLE.items() if its is role)
        assert (await sign_in(client, name)).json()["role"] == role
    for method, path in routes:
        if (method, path) == ("DELETE", "/api/session"):
            continue  # it would end the session
        asked = path.replace("{", "").replace("}", "")
        answer = await client.request(method, asked)
        is_refused = answer.status_code in {401, 403} and answer.json()["id"] in _NOT_ENOUGH
        assert is_refused is not role.may(needed_role(method, asked)), (method, path, answer.text)


def test_what_the_table_does_not_name_is_refused_rather_than_allowed() -> None:
    assert needed_role("POST", "/api/something/new") is Role.OPERATOR
    assert needed_role("PATCH", "/api/accounts/Ada/more") is Role.ADMINISTRATOR
    assert needed_role("GET", "/api/accounts/") is Role.ADMINISTRATOR
    assert needed_role("HEAD", "/api/accounts") is Role.ADMINISTRATOR
    assert needed_role("GET", "/api/mission/steps") is Role.OBSERVER
    assert needed_role("GET", "/") is Role.VISITOR
    assert needed_role("PATCH", "/api/findings/1") is Role.ANALYST
    assert needed_role("PUT", "/api/plans/a/b\nc") is Role.OPERATOR


async def test_an_analyst_judges_findings_under_their_name_and_cannot_fly(
    client: OperatorClient, mission: ScriptedMission
) -> None:
    await sign_in(client, "Anders")
    place = {"latitude_deg": 48.333, "longitude_deg": 14.324, "comment": "a jacket"}
    marked = (await client.post("/api/findings", json=place)).json()
    judged = await client.patch(f"/api/findings/{marked['finding_id']}", json={"status": "confirmed"})
    assert judged.json()["operator"] == "Anders"
    for action in ("hold", "start"):
        refused = await client.post("/api/mission/actions", json={"action": action})
        assert (refused.status_code, refused.json()["id"]) == (403, "role_required")
        assert "operator; you are signed in as analyst" in refused.json()["message"]
    assert mission.actions == []


async def test_the_operator_code_is_worth_nothing_where_there_are_accounts(client: OperatorClient) -> None:
    refused = await client.post("/api/session", json={"name": "Robin", "code": "not used with accounts"})
    assert refused.status_code == 422
    assert (await client.get("/api/session")).json()["role"] == "visitor"


async def test_anyone_observes_where_that_is_allowed(
    mission: ScriptedMission, accounts: AccountFile, time: HandTime
) -> None:
    async with client_of(app_of(mission, accounts=accounts, now_s=time, anyone_observes=True)) as client:
        assert (await client.get("/api/mission")).status_code == 200
        refused = await client.post("/api/mission/actions", json={"action": "hold"})
        assert (refused.status_code, refused.json()["id"]) == (401, "sign_in_required")


# --- sign-in ----------------------------------------------------------------------------------------------------------


async def test_a_person_signs_in_with_any_capitals_and_acts_under_the_accounts_name(
    client: OperatorClient, mission: ScriptedMission
) -> None:
    signed_in = await sign_in(client, "robin")
    assert signed_in.json() == {"role": "operator", "name": "Robin", "sign_in_required": True, "accounts": True}
    assert (await client.post("/api/mission/actions", json={"action": "start"})).status_code == 200
    assert mission.actions == [(Action.START, None)]


@pytest.mark.parametrize("name", ["Robin", "nobody"])
async def test_wrong_names_and_wrong_passwords_are_refused_alike(client: OperatorClient, name: str) -> None:
    refused = await sign_in(client, name, "wrong password")
    assert (refused.status_code, refused.json()) == (403, {"id": "wrong_code", "message": "Wrong name or password."})


async def test_a_thousand_wrong_passwords_from_fifty_addresses_open_nothing_and_disturb_nobody(
    accounts: AccountFile, time: HandTime
) -> None:
    access = Access(None, time, accounts=accounts)
    sessions = access.accounts
    assert sessions is not None
    robin = await access.sign_in_by(lambda: sessions.find("Robin", PASSWORD), HERE)
    access.note_address(HERE)  # as each request of an operator does
    compared, refused = [], 0

    async def guess(address: str, password: str) -> None:
        nonlocal refused

        async def find() -> Account | None:
            compared.append(password)
            await asyncio.sleep(0)
            return await sessions.find("Robin", password)

        try:
            await access.sign_in_by(find, address)
        except AccessDeniedError:
            refused += 1

    for round_number in range(20):
        async with asyncio.TaskGroup() as group:
            for number in range(50):
                group.create_task(guess(f"198.51.100.{number}", f"wrong password {round_number}"))
        assert access.session(robin).role is Role.OPERATOR
    assert (refused, len(compared)) == (1000, GUESSES_PER_MINUTE - 1)  # Robin's own sign-in was the first
    # Colleagues sign in meanwhile: on another device at the same address, and on the station itself.
    for address in (HERE, "127.0.0.1"):
        await access.sign_in_by(lambda: sessions.find("Ada", PASSWORD), address)
    with pytest.raises(TooManyGuessesError, match=r"Too many wrong passwords\. Wait 1 s"):
        await access.sign_in_by(lambda: sessions.find("Ada", PASSWORD), "203.0.113.1")


async def test_passwords_that_were_not_compared_do_not_fill_the_log(app: FastAPI, client: OperatorClient) -> None:
    for _ in range(FREE_GUESSES + 10):
        last = await sign_in(client, "Robin", "wrong password")
    assert (last.status_code, last.headers["Retry-After"]) == (429, "1")
    kinds = [entry.kind for entry in app.state.desk.log.latest]
    assert kinds == ["wrong password"] * (FREE_GUESSES + 1) + ["too many wrong passwords"]


async def test_guesses_that_arrive_together_are_counted_before_they_are_compared(app: FastAPI) -> None:
    async with client_of(app) as client, asyncio.TaskGroup() as group:
        guesses = [group.create_task(sign_in(client, "Robin", "wrong password")) for _ in range(40)]
    assert [guess.result().status_code for guess in guesses].count(403) == FREE_GUESSES + 1


async def test_a_session_ends_with_its_account_and_follows_its_role(
    client: OperatorClient, accounts: AccountFile
) -> None:
    await sign_in(client, "Robin")
    accounts.set_role("Robin", Role.ANALYST)
    assert (await client.get("/api/session")).json()["role"] == "analyst"
    accounts.remove("Robin")
    accounts.add("Robin", Role.ADMINISTRATOR, "another person altogether", 0.0)
    assert (await client.get("/api/session")).json()["role"] == "visitor"


async def test_a_session_that_nobody_uses_ends(client: OperatorClient, time: HandTime) -> None:
    await sign_in(client, "Robin")
    time.now_s += UNUSED_S - 1.0
    assert (await client.get("/api/session")).json()["role"] == "operator"
    time.now_s += UNUSED_S + 1.0
    assert (await client.get("/api/session")).json()["role"] == "visitor"


async def test_devices_of_one_person_replace_each_other_and_nobody_elses(app: FastAPI) -> None:
    async with client_of(app) as ada:
        await sign_in(ada, "Ada")
        clients = [client_of(app, f"192.0.2.{number}") for number in range(SESSIONS_PER_ACCOUNT + 1)]
        for one in clients:
            await sign_in(one, "Olga")
        roles = [(await one.get("/api/session")).json()["role"] for one in (ada, *clients)]
    assert roles == ["administrator", "visitor", *["observer"] * SESSIONS_PER_ACCOUNT]


async def test_another_password_ends_all_sessions_but_the_one_that_set_it(app: FastAPI) -> None:
    async with client_of(app) as stolen, client_of(app) as own:
        await sign_in(stolen, "Robin")
        await sign_in(own, "Robin")
        wrong = {"old_password": "wrong password", "new_password": "spruce and larch"}
        assert (await stolen.post("/api/session/password", json=wrong)).status_code == 403
        right = {"old_password": PASSWORD, "new_password": "spruce and larch"}
        assert (await own.post("/api/session/password", json=right)).json()["role"] == "operator"
        roles = [(await one.get("/api/session")).json()["role"] for one in (stolen, own)]
        assert roles == ["visitor", "operator"]
        assert (await sign_in(stolen, "Robin")).status_code == 403


async def test_sessions_outlast_a_restart(
    accounts: AccountFile, time: HandTime, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aos_gcs.api.access.operators._WRITTEN_WITHIN_S", scaled_s(30.0))
    file = tmp_path / "operators.json"
    before = Access("code", time, OperatorFile(file), accounts)

    async def robin() -> object:
        return accounts.find("Robin")

    token = await before.sign_in_by(robin, HERE)  # type: ignore[arg-type]
    await before.write_down()
    after = Access("code", time, OperatorFile(file), AccountFile(accounts.path))
    assert after.session(token).name == "Robin"
    assert Access("code", time, OperatorFile(file)).session(token).role is Role.OBSERVER


async def test_whoever_signs_out_is_a_visitor(client: OperatorClient) -> None:
    await sign_in(client, "Ada")
    assert (await client.delete("/api/session")).json()["role"] == "visitor"


# --- accounts ---------------------------------------------------------------------------------------------------------


async def test_an_invitation_makes_one_account_of_its_role(app: FastAPI, client: OperatorClient) -> None:
    await sign_in(client, "Ada")
    token = (await client.post("/api/accounts/invitations", json={"role": "analyst"})).json()["token"]
    body = {"token": token, "name": "Åsa", "password": "juniper and birch"}
    async with client_of(app, "192.0.2.9") as newcomer:
        short = await newcomer.post("/api/session/invitation", json={**body, "password": "short"})
        assert (short.status_code, short.json()["id"]) == (422, "unusable_data")
        taken = await newcomer.post("/api/session/invitation", json={**body, "name": "ROBIN"})
        assert (taken.status_code, taken.json()["id"]) == (409, "account_unchanged")
        joined = await newcomer.post("/api/session/invitation", json=body)
        assert (joined.json()["role"], joined.json()["name"]) == ("analyst", "Åsa")
        again = await newcomer.post("/api/session/invitation", json={**body, "name": "Eve"})
        assert (again.status_code, again.json()["id"]) == (403, "invitation_unusable")
    listed = (await client.get("/api/accounts")).json()
    assert {(one["name"], one["role"], one["sessions"]) for one in listed} >= {
        ("Åsa", "analyst", 1),
        ("Ada", "administrator", 1),
    }
    kinds = [entry["kind"] for entry in (await client.get("/api/accounts/sign-ins")).json()]
    assert kinds == ["account made by invitation", "invitation made", "signed in"]


async def test_the_clock_of_the_loop_is_asked_in_the_loop(mission: ScriptedMission, accounts: AccountFile) -> None:
    async with client_of(app_of(mission, accounts=accounts)) as client:
        await sign_in(client, "Ada")
        assert (await client.get("/api/session")).json()["name"] == "Ada"


def test_an_invitation_expires(accounts: AccountFile) -> None:
    token = accounts.invite(Role.OPERATOR, "Ada", utc_s=0.0, lasts_s=60.0)
    with pytest.raises(InvitationError, match="has expired"):
        accounts.accept(token, "Eve", "juniper and birch", utc_s=61.0)


async def test_the_last_administrator_stays(client: OperatorClient) -> None:
    await sign_in(client, "Ada")
    for request in (client.delete("/api/accounts/Ada"), client.patch("/api/accounts/Ada", json={"role": "operator"})):
        refused = await request
        assert (refused.status_code, "last administrator" in refused.json()["message"]) == (409, True)
    assert len((await client.patch("/api/accounts/Robin", json={"role": "administrator"})).json()) == 4
    assert len((await client.delete("/api/accounts/Ada")).json()) == 3
    assert (await client.get("/api/session")).json()["role"] == "visitor"


@pytest.mark.parametrize(
    ("name", "password"),
    [("", PASSWORD), ("a/b", PASSWORD), (" Eve", PASSWORD), ("E\nve", PASSWORD), (41 * "x", PASSWORD), ("Eve", "short"),
     ("Eve", "aaaaaaaaaaaa"), ("Eve Adams Smith", "eve adams smith"), ("Eve", 201 * "ab")],
)  # fmt: skip
def test_names_and_passwords_that_cannot_be_used(accounts: AccountFile, name: str, password: str) -> None:
    before = accounts.path.read_bytes()
    with pytest.raises(InputDataError, match=r"name:|password:"):
        accounts.add(name, Role.OBSERVER, password, 0.0)
    assert accounts.path.read_bytes() == before


def test_changes_of_another_process_are_seen_and_both_are_kept(accounts: AccountFile) -> None:
    other = AccountFile(accounts.path)
    other.add("Eve", Role.OBSERVER, PASSWORD, 0.0)
    accounts.add("Åsa", Role.OBSERVER, PASSWORD, 0.0)
    other.refresh()
    assert [one.name for one in other.all()] == ["Ada", "Anders", "Eve", "Olga", "Robin", "Åsa"]
    assert accounts.path.stat().st_mode & 0o777 == 0o600
    with pytest.raises(AccountError, match="no account 'Nobody'"):
        other.remove("Nobody")


@pytest.mark.parametrize("content", [b"", b"[]", b'{"accounts": [{}]}', b'{"accounts": [], "more": 1}', b"\xff"])
def test_a_damaged_file_is_refused_and_keeps_what_was_known(accounts: AccountFile, content: bytes) -> None:
    accounts.path.write_bytes(content)
    with pytest.raises(ConfigurationError, match=r"is no file of accounts .*aos-gcs accounts"):
        accounts.refresh()
    assert accounts.find("Robin") is not None


def test_a_service_whose_accounts_cannot_fly_does_not_start(tmp_path: Path) -> None:
    path = tmp_path / "accounts.json"
    config = ApiConfig(accounts=path)
    with pytest.raises(ConfigurationError, match=r"nobody in .* may fly.*--role administrator"):
        operator_secrets(config, tmp_path)
    AccountFile(path).add("Robin", Role.OPERATOR, PASSWORD, 0.0)
    assert operator_secrets(config, tmp_path).accounts is not None


def test_no_two_digests_of_a_password_are_equal() -> None:
    digests = {passwords.hash_password(PASSWORD) for _ in range(3)}
    assert len(digests) == 3
    assert all(passwords.is_password(one, PASSWORD) for one in digests)
    assert not any(passwords.is_password(one, PASSWORD + "x") for one in (*digests, None, "no digest"))
    assert all(one.startswith("$argon2id$") for one in digests)


def test_each_role_includes_the_ones_before_it() -> None:
    for (lower, one), (higher, other) in itertools.product(enumerate(Role), repeat=2):
        assert one.may(other) is (lower >= higher)
