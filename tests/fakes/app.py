"""The application around a scripted mission."""

from __future__ import annotations

from typing import Any

import httpx
from fastapi import FastAPI

from aos_gcs.api.app import create_app
from tests.fakes.mission import ScriptedMission


def app_of(mission: ScriptedMission, *args: Any, **options: Any) -> FastAPI:
    """Make the application of a mission that can be commanded."""
    return create_app(mission, *args, commands=mission, **options)


class OperatorClient(httpx.AsyncClient):
    """Client that names the state by which it commands, as the page does."""

    async def request(self, method: str, url: Any, **options: Any) -> httpx.Response:
        if method == "POST":
            seen = (await super().request("GET", "/api/mission")).headers.get("X-Seen", "")
            options["headers"] = {"X-Seen": seen} | dict(options.get("headers") or {})
        return await super().request(method, url, **options)
