"""Whatever a client sends, the server refuses it in words and goes on."""

from __future__ import annotations

import asyncio
import json
import re
from functools import cache
from pathlib import Path
from urllib.parse import quote

import httpx
import hypothesis.strategies as st
import numpy as np
import pytest
from fastapi import FastAPI
from hypothesis import example, given, settings

from aos_gcs.api.openapi import make_document
from aos_gcs.clock import LoopClock
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fuzz import SEED, damage

BASE_URL = "http://127.0.0.1:8080"
_WRITING = ("post", "put", "patch", "delete")


async def application() -> FastAPI:
    """Return the server of a scripted mission, whose clock needs a running loop."""
    return app_of(ScriptedMission(LoopClock()))


document = cache(make_document)


@cache
def targets() -> list[tuple[str, str]]:
    """Return method and path of every request that changes something."""
    return [(method, path) for path, methods in document()["paths"].items() for method in methods if method in _WRITING]


def readable() -> list[str]:
    """Return the paths that can be read."""
    return [path for path, methods in document()["paths"].items() if "get" in methods]


def words_of(key: str) -> list[str]:
    """Return what all schemas have under a key: ``properties`` or ``enum``."""
    return sorted({word for schema in document()["components"]["schemas"].values() for word in schema.get(key, [])})


scalars = (
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats()
    | st.text(max_size=20)
    | st.deferred(lambda: st.sampled_from(words_of("enum")))
    | st.sampled_from(["../../etc/passwd", "\x00", "1e999", "a" * 5000])
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.deferred(lambda: st.sampled_from(words_of("properties"))), inner, max_size=5)
        | st.dictionaries(st.text(max_size=5), inner, max_size=2)
    ),
    max_leaves=20,
)
bodies = values.map(lambda value: json.dumps(value).encode()) | st.binary(max_size=200)


@pytest.mark.filterwarnings("ignore::UserWarning")
@settings(max_examples=60, deadline=None)
@example(target=("post", "/api/mission/actions"), body=b"[" * 50_000, name="x")
@example(target=("post", "/api/mission/actions"), body=b'{"action": "hold", "vehicle_ids": [1e400]}', name="x")
@given(st.deferred(lambda: st.sampled_from(targets())), bodies, st.text(min_size=1, max_size=10))
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


GOOD_BODIES = (
    b'{"action": "return", "vehicle_ids": [1, 2]}',
    b'{"code": "larch-and-spruce", "name": "Ada"}',
    b'{"vehicle_id": 7, "check": "camera", "reason": "spare"}',
    b'{"notice_ids": [1]}',
    b'{"position": {"latitude_deg": 48.3358, "longitude_deg": 14.3263}, "comment": ""}',
    b'{"latitude_deg": 48.3358, "longitude_deg": 14.3263, "comment": "x"}',
    b'{"type": "FeatureCollection", "features": []}',
    b"",
)
GOOD_HEADERS: tuple[tuple[str, bytes], ...] = (
    ("host", b"127.0.0.1:8080"),
    ("origin", b"http://127.0.0.1:8080"),
    ("cookie", b"aos_gcs_8080=token"),
    ("x-seen", b"scripted-1/0/1000"),
    ("range", b"bytes=0-99"),
    ("if-none-match", b'"abc"'),
    ("content-type", b"application/json"),
    ("content-length", b"7"),
    ("x-forwarded-for", b"10.0.0.1"),
    ("accept-encoding", b"gzip"),
)


async def request_of(client: httpx.AsyncClient, rng: np.random.Generator) -> httpx.Response:
    """Send a request that is like a good one in some parts."""
    is_reading = rng.random() < 0.4
    paths = readable() if is_reading else [path for _, path in targets()]
    path = paths[rng.integers(len(paths))]
    if rng.random() < 0.2:
        path = damage(path.encode(), rng).decode("latin-1")
    path = re.sub(r"\{.*?\}", lambda _: quote(damage(b"1", rng) if rng.random() < 0.5 else b"1", safe=""), path)
    if rng.random() < 0.3:
        path += "?" + quote(damage(b"after=1&height_m=2.0&width_px=64", rng), safe="=&")
    body = GOOD_BODIES[rng.integers(len(GOOD_BODIES))]
    headers = [GOOD_HEADERS[0]] if rng.random() < 0.8 else []
    for index in rng.integers(1, len(GOOD_HEADERS), rng.integers(0, 4)):
        name, value = GOOD_HEADERS[index]
        if rng.random() < 0.5:
            value = damage(value, rng).translate(None, b"\r\n\0")
        headers.append((name, value))
    method = "GET" if is_reading else ("POST", "PUT", "PATCH", "DELETE", "OPTIONS", "HEAD")[rng.integers(6)]
    url = httpx.URL(BASE_URL).copy_with(raw_path=b"/" + quote(path.lstrip("/"), safe="/?=&%").encode())
    content = damage(body, rng) if rng.random() < 0.7 else body
    return await client.request(method, url, content=content, headers=[(name.encode(), v) for name, v in headers])


@pytest.mark.parametrize("code", [None, "larch-and-spruce"])
@pytest.mark.parametrize("count", [150, pytest.param(12_000, marks=[pytest.mark.slow, pytest.mark.timeout(3600)])])
async def test_no_damaged_request_breaks_the_server(tmp_path: Path, count: int, code: str | None) -> None:
    for number in range(count):
        seed = SEED + number
        if number % 100 == 0:
            app = app_of(ScriptedMission(LoopClock()), operator_code=code, plans_folder=tmp_path / str(number))
        transport = httpx.ASGITransport(app, client=(f"10.0.{seed // 250 % 250}.{seed % 250}", 5))
        async with httpx.AsyncClient(transport=transport, base_url=BASE_URL) as client:
            try:
                response = await request_of(client, np.random.default_rng(seed))
            except Exception as error:
                raise AssertionError(f"AOS_GCS_FUZZ_SEED={seed}") from error
        # 500 and above means that the program has failed; 503 would be a viewer that is busy, which there is none of.
        assert response.status_code < 500, (seed, response.text)
