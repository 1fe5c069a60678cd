"""The application around a scripted mission."""

from __future__ import annotations

from typing import Any

import httpx
from fastapi import FastAPI
from websockets.asyncio.client import connect

from aos_gcs.api.app import create_app
from tests.fakes.mission import ScriptedMission
from tests.timing import scaled_s


def app_of(mission: ScriptedMission, *args: Any, **options: Any) -> FastAPI:
    """Make the application of a mission that can be commanded."""
    return create_app(mission, *args, commands=mission, **options)


def client_at(url: str = "", **options: Any) -> httpx.AsyncClient:
    """Make a client of a server on a socket, which a busy machine may let wait for longer than httpx's own 5 s."""
    return httpx.AsyncClient(base_url=url, timeout=scaled_s(30.0), **options)


def stream_at(url: str, **options: Any) -> connect:
    """Open an event stream with the same patience."""
    return connect(url, open_timeout=scaled_s(30.0), **options)


class OperatorClient(httpx.AsyncClient):
    """Client that names the state by which it commands, as the page does."""

    async def request(self, method: str, url: Any, **options: Any) -> httpx.Response:
        if method == "POST":
            seen = (await super().request("GET", "/api/mission")).headers.get("X-Seen", "")
            options["headers"] = {"X-Seen": seen} | dict(options.get("headers") or {})
        return await super().request(method, url, **options)
