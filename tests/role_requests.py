"""Requests of schemathesis as an observer and as an analyst, who must change nothing that their roles may not.

Run: python -m tests.role_requests --st PATH [--requests 10000] [--seed 18] [--roles observer analyst]

schemathesis (PyPI) makes them from the interface's document; ``--st`` names its program, which may be installed in an
environment of its own. It runs again, with the next seed, until each role has sent so many. The mission stands still
meanwhile, so that whatever differs afterwards was changed by a request. Left out is what ends the session itself.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import httpx
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from aos_gcs.api.access.accounts import AccountFile
from aos_gcs.api.access.roles import Role
from aos_gcs.api.openapi import make_document
from aos_gcs.api.server import serve
from aos_gcs.clock import LoopClock
from aos_gcs.mission.model.proposals import Proposal, ProposalShape
from aos_gcs.store.plan_folder import PlanFolder
from tests.fakes.app import app_of
from tests.fakes.handovers import ScriptedHandovers
from tests.fakes.mission import ScriptedMission
from tests.fakes.videos import ScriptedVideos

PASSWORD: Final = "larch and spruce"  # noqa: S105 - of the tests
PEOPLE: Final = {"Olga": Role.OBSERVER, "Anders": Role.ANALYST, "Ada": Role.ADMINISTRATOR}
ROUND_S: Final = 60
STEPS: Final = 20
RATE: Final = "80/s"
"""Fewer than the service takes from one address: those beyond are refused by the limit, and try nothing."""
TOO_MANY: Final = 429
BUSY: Final = 503
"""Answer of what does one thing at a time; no failure."""


PROPOSAL: Final = Proposal(
    uid="a",
    source="TAK",
    name="jacket",
    sender="Kim",
    kind="b-m-p-s-m",
    shape=ProposalShape.POINT,
    points_deg=((48.33, 14.32),),
    altitude_amsl_m=None,
    remarks="",
    sent_utc_s=0.0,
    stale_utc_s=1e10,
    received_utc_s=0.0,
)


class Counted:
    """Counts the answers of an application by their status."""

    def __init__(self, app: ASGIApp, statuses: Counter[int]) -> None:
        self._app = app
        self._statuses = statuses

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, counting."""

        async def counting(message: Message) -> None:
            if message["type"] == "http.response.start":
                self._statuses[int(message["status"])] += 1
            await send(message)

        await self._app(scope, receive, counting)


class Station:
    """A mission with findings and a proposal, a plan that is kept, and accounts."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.mission = ScriptedMission(LoopClock())
        self.videos = ScriptedVideos()
        self.accounts = AccountFile(folder / "accounts.json")
        for name, role in PEOPLE.items():
            self.accounts.add(name, role, PASSWORD, 0.0)
        self.plans = folder / "plans"
        for _ in range(STEPS):
            self.mission.make_step()
        if self.mission.proposals.take([PROPOSAL]) != 1:
            raise SystemExit("the proposal is refused")
        PlanFolder(self.plans).write("kept", "{}")

    def state(self) -> dict[str, Any]:
        """Return all that requests may change."""
        found = asdict(self.mission.snapshot()) | {"actions": list(map(str, self.mission.actions))}
        found |= {"settings": repr(self.mission.settings), "videos": len(self.videos.asked)}
        kept = [*self.plans.rglob("*"), self._folder / "accounts.json"]
        found |= {path.name: path.read_text(encoding="utf-8") for path in kept if path.is_file()}
        return json.loads(json.dumps(found, default=str))  # type: ignore[no-any-return]


def forbidden(before: dict[str, Any], after: dict[str, Any], role: Role, name: str) -> list[str]:
    """Return what differs and may not."""
    differing = {key for key in before.keys() | after.keys() if before.get(key) != after.get(key)}
    if role is Role.ANALYST:
        differing -= {"videos"}  # which analysts may have made
        known = {one["finding_id"]: one for one in before["findings"]}
        changed = [one for one in after["findings"] if one != known.get(one["finding_id"])]
        if len(after["findings"]) >= len(known) and all(one["operator"] == name for one in changed):
            differing -= {"findings"}
    return sorted(differing)


def count_of(statuses: Counter[int]) -> int:
    """Return the number of requests that have passed the limit of their rate."""
    return statuses.total() - statuses[TOO_MANY]


def say(text: str) -> None:
    """Print a line."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


async def send_all(options: argparse.Namespace, role: Role, folder: Path) -> bool:
    """Have one role send its requests; whether nothing went wrong."""
    station, statuses = Station(folder), Counter[int]()
    app = app_of(
        station.mission,
        accounts=station.accounts,
        plans_folder=station.plans,
        handovers=ScriptedHandovers(),
        videos=station.videos,
    )
    app.add_middleware(Counted, statuses=statuses)
    document = folder / "openapi.json"
    document.write_text(json.dumps(make_document()), encoding="utf-8")
    name = next(name for name, its in PEOPLE.items() if its is role)
    async with serve(app, port=0) as address:
        async with httpx.AsyncClient(base_url=address.url) as client:
            await client.post("/api/session", json={"name": name, "password": PASSWORD})
            cookie = "; ".join(f"{key}={value}" for key, value in client.cookies.items())
            seen = (await client.get("/api/mission")).headers["X-Seen"]
        before = station.state()
        statuses.clear()
        seed = options.seed
        while count_of(statuses) < options.requests:
            arguments = ["run", str(document), "--url", address.url, "--seed", str(seed), "--max-time", str(ROUND_S)]
            arguments += ["--checks", "not_a_server_error", "--continue-on-failure", "--phases", "coverage,fuzzing"]
            arguments += ["--header", f"Cookie: {cookie}", "--header", f"X-Seen: {seen}"]
            arguments += ["--exclude-path-regex", "^/api/session", "--rate-limit", RATE]
            # With words of its own for what it finds, of which the answers' statuses are counted here.
            process = await asyncio.create_subprocess_exec(
                options.st, *arguments, cwd=folder, stdout=asyncio.subprocess.DEVNULL
            )
            await process.wait()
            say(f"{role}, seed {seed}: {count_of(statuses)} requests")
            seed += 1
        async with httpx.AsyncClient(base_url=address.url, headers={"Cookie": cookie}) as client:
            is_signed_in = (await client.get("/api/session")).json()["role"] == role
    failed = {status: count for status, count in statuses.items() if status >= 500 and status != BUSY}
    wrong = forbidden(before, station.state(), role, name)
    say(f"{role}: {count_of(statuses)} requests, {dict(sorted(statuses.items()))}")
    say(f"{role}: signed in to the end: {is_signed_in}; failures: {failed or 'none'}; changed: {wrong or 'nothing'}")
    return is_signed_in and not failed and not wrong


def which(name: str) -> str:
    """Return the path of a program."""
    found = shutil.which(name)
    if found is None:
        raise argparse.ArgumentTypeError(f"{name} is not there: pip install schemathesis, in an environment of its own")
    return str(Path(found).absolute())


async def check(options: argparse.Namespace) -> bool:
    """Have all roles send their requests."""
    is_right = True
    for role in map(Role, options.roles):
        with tempfile.TemporaryDirectory() as folder:
            is_right = await send_all(options, role, Path(folder)) and is_right
    return is_right


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the options and check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--st", type=which, default="st", help="Program of schemathesis.")
    parser.add_argument("--requests", type=int, default=10_000, help="Requests of each role, at least.")
    parser.add_argument("--seed", type=int, default=18)
    parser.add_argument("--roles", nargs="*", choices=("observer", "analyst"), default=("observer", "analyst"))
    sys.exit(0 if asyncio.run(check(parser.parse_args(arguments))) else 1)


if __name__ == "__main__":
    main()
