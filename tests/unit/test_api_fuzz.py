"""Whatever a client sends, the server refuses it in words and goes on."""

from __future__ import annotations

import asyncio
import json
import re
from urllib.parse import quote

import httpx
import hypothesis.strategies as st
import pytest
from fastapi import FastAPI
from hypothesis import example, given, settings

from aos_gcs.api.openapi import make_document
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission

BASE_URL = "http://127.0.0.1:8080"
_WRITING = ("post", "put", "patch", "delete")


async def application() -> FastAPI:
    """Return the server of a scripted mission, whose clock needs a running loop."""
    return app_of(ScriptedMission(LoopClock()))


DOCUMENT = make_document()
TARGETS = [(method, path) for path, methods in DOCUMENT["paths"].items() for method in methods if method in _WRITING]
NAMES = sorted({name for schema in DOCUMENT["components"]["schemas"].values() for name in schema.get("properties", {})})
WORDS = sorted({word for schema in DOCUMENT["components"]["schemas"].values() for word in schema.get("enum", [])})

scalars = (
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(WORDS)
    | st.sampled_from(["../../etc/passwd", "\x00", "1e999", "a" * 5000])
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(NAMES), inner, max_size=5)
        | st.dictionaries(st.text(max_size=5), inner, max_size=2)
    ),
    max_leaves=20,
)
bodies = values.map(lambda value: json.dumps(value).encode()) | st.binary(max_size=200)


@pytest.mark.filterwarnings("ignore::UserWarning")
@settings(max_examples=60, deadline=None)
@example(target=("post", "/api/mission/actions"), body=b"[" * 50_000, name="x")
@example(target=("post", "/api/mission/actions"), body=b'{"action": "hold", "vehicle_ids": [1e400]}', name="x")
@given(st.sampled_from(TARGETS), bodies, st.text(min_size=1, max_size=10))
def test_no_request_breaks_the_server(target: tuple[str, str], body: bytes, name: str) -> None:
    method, path = target

    async def send() -> httpx.Response:
        transport = httpx.ASGITransport(await application(), raise_app_exceptions=True)
        async with httpx.AsyncClient(transport=transport, base_url=BASE_URL) as client:
            place = re.sub(r"\{.*?\}", quote(name, safe=""), path)
            return await client.request(method, place, content=body, headers={"content-type": "application/json"})

    response = asyncio.run(send())
    assert response.status_code < 500, response.text
    if response.status_code >= 400:
        assert response.json()
