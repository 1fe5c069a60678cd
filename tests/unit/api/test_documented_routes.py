"""docs/api.md against the service: every route is there, and every route that is there exists."""

from __future__ import annotations

import re
from pathlib import Path

from fastapi import FastAPI
from fastapi.routing import APIRoute
from starlette.routing import WebSocketRoute

from aos_gcs.api.openapi import add_routes

PAGE = Path(__file__).resolve().parents[3] / "docs" / "api.md"
METHODS = "GET|POST|PUT|PATCH|DELETE"
ROUTE = re.compile(rf"((?:`(?:{METHODS})`, )*)`({METHODS}) (/api/[^`?]+)")
SOCKET = re.compile(r"`(/api/[^`]+)` is a WebSocket")


def without_names(path: str) -> str:
    """Return a path whose parameters have no names."""
    return re.sub(r"\{[^}]*\}", "{}", path)


def documented() -> set[tuple[str, str]]:
    text = PAGE.read_text(encoding="utf-8")
    found = {("WEBSOCKET", path) for path in SOCKET.findall(text)}
    for others, method, path in ROUTE.findall(text):
        found |= {(one, without_names(path)) for one in (*re.findall(METHODS, others), method)}
    return found


def offered() -> set[tuple[str, str]]:
    app = FastAPI(docs_url=None, redoc_url=None)
    add_routes(app)
    routes = [route for route in app.routes if isinstance(route, APIRoute)]
    sockets = {("WEBSOCKET", route.path) for route in app.routes if isinstance(route, WebSocketRoute)}
    return sockets | {(method, without_names(route.path)) for route in routes for method in route.methods}


def test_the_page_has_every_route_and_no_other() -> None:
    assert documented() == offered()
