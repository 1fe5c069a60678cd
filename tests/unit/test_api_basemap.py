"""The base map's routes and its setting."""

from __future__ import annotations

from pathlib import Path

import httpx
import pytest

from aos_gcs.api.app import create_app
from aos_gcs.clock import LoopClock
from aos_gcs.config import ApiConfig
from tests.fakes.mission import ScriptedMission

BASE_URL = "http://127.0.0.1:8080"


def client_of(file: Path | None) -> httpx.AsyncClient:
    app = create_app(ScriptedMission(LoopClock()), basemap_file=file)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url=BASE_URL)


async def test_browsers_read_the_ranges_that_they_show(tmp_path: Path) -> None:
    file = tmp_path / "area.pmtiles"
    file.write_bytes(bytes(range(200)))
    async with client_of(file) as client:
        url = (await client.get("/api/basemap")).json()["url"]
        response = await client.get(url, headers={"Range": "bytes=10-19"})
    assert response.status_code == 206
    assert response.content == bytes(range(10, 20))
    assert response.headers["content-range"] == "bytes 10-19/200"


async def test_without_a_base_map_the_page_is_told_so() -> None:
    async with client_of(None) as client:
        assert (await client.get("/api/basemap")).json() == {"url": None}
        response = await client.get("/api/basemap/tiles.pmtiles")
    assert response.status_code == 404
    assert "api.basemap" in response.json()["message"]


async def test_a_base_map_that_is_gone_is_told_like_one_that_never_was(tmp_path: Path) -> None:
    async with client_of(tmp_path / "unplugged.pmtiles") as client:
        assert (await client.get("/api/basemap/tiles.pmtiles")).status_code == 404


def test_a_file_that_does_not_exist_is_refused_in_the_configuration(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="basemap"):
        ApiConfig(basemap=tmp_path / "none.pmtiles")
