"""The base map's routes and its setting."""

from __future__ import annotations

from pathlib import Path

import httpx
import pytest

from aos_gcs.api.basemap_file import MISSION_BASEMAP, check_basemap
from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError
from aos_gcs.runtime.dashboard.serving import open_dashboard
from aos_gcs.runtime.sign_in import OperatorSecrets
from tests.fakes.app import app_of, client_at
from tests.fakes.mission import ScriptedMission
from tests.fakes.tiles import MVT, PNG, pmtiles

BASE_URL = "http://127.0.0.1:8080"


def client_of(file: Path | None) -> httpx.AsyncClient:
    app = app_of(ScriptedMission(LoopClock()), basemap_file=file)
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


async def test_a_map_that_comes_later_is_shown_and_another_has_another_address(tmp_path: Path) -> None:
    """The demo's map is drawn beside its mission, and every sortie has its own."""
    file = tmp_path / MISSION_BASEMAP
    async with client_of(file) as client:
        assert (await client.get("/api/basemap")).json() == {"url": None}
        file.write_bytes(b"first")
        first = (await client.get("/api/basemap")).json()["url"]
        file.write_bytes(b"the second")
        second = (await client.get("/api/basemap")).json()["url"]
        assert (await client.get(second)).content == b"the second"
    assert first != second


@pytest.mark.parametrize("is_configured", [False, True])
async def test_the_map_of_the_mission_folder_is_shown_where_the_configuration_names_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_configured: bool
) -> None:
    (tmp_path / MISSION_BASEMAP).write_bytes(pmtiles(b"of the folder", PNG))
    (tmp_path / "team.pmtiles").write_bytes(pmtiles(b"of the team", PNG))
    addresses: list[str] = []
    monkeypatch.setattr("aos_gcs.runtime.dashboard.serving.announce", lambda address, *_: addresses.append(address.url))
    config = ApiConfig(basemap=tmp_path / "team.pmtiles" if is_configured else None, port=0)
    mission = ScriptedMission(LoopClock())
    async with open_dashboard(mission, config, OperatorSecrets("code"), folder=tmp_path):
        client = client_at(addresses[0])
        shown = await client.get((await client.get("/api/basemap")).json()["url"])
        await client.aclose()
    assert shown.content.endswith(b"of the team" if is_configured else b"of the folder")


async def test_without_a_base_map_the_page_is_told_so() -> None:
    async with client_of(None) as client:
        assert (await client.get("/api/basemap")).json() == {"url": None}
        response = await client.get("/api/basemap/tiles.pmtiles")
    assert response.status_code == 404
    assert "api.basemap" in response.json()["message"]


async def test_a_base_map_that_is_gone_is_told_like_one_that_never_was(tmp_path: Path) -> None:
    async with client_of(tmp_path / "unplugged.pmtiles") as client:
        assert (await client.get("/api/basemap/tiles.pmtiles")).status_code == 404


ARCHIVE = pmtiles(b"tile", PNG)


@pytest.mark.parametrize("tile_type", [MVT, PNG])
def test_pictures_and_vectors_can_be_shown(tmp_path: Path, tile_type: int) -> None:
    file = tmp_path / "area.pmtiles"
    file.write_bytes(pmtiles(b"tile", tile_type))
    check_basemap(file)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "not a PMTiles archive"),
        (b"PK\x03\x04" + bytes(500), "not a PMTiles archive; make one"),
        (ARCHIVE[:100], "not a PMTiles archive"),
        (ARCHIVE[:-1], "incomplete: its tiles end at byte .*copy it again"),
        (ARCHIVE[:7] + bytes([2]) + ARCHIVE[8:], "version 2; convert it"),
        (ARCHIVE[:97] + bytes([3]) + ARCHIVE[98:], "directories of .* compression brotli"),
        (ARCHIVE[:98] + bytes([4]) + ARCHIVE[99:], "tiles of .* compression zstd.* with gzip"),
        (ARCHIVE[:99] + bytes([9]) + ARCHIVE[100:], "unknown type 9, not MVT"),
    ],
)
def test_what_cannot_be_shown_is_refused_with_the_reason(tmp_path: Path, content: bytes, reason: str) -> None:
    file = tmp_path / "broken.pmtiles"
    file.write_bytes(content)
    with pytest.raises(ConfigurationError, match=reason):
        check_basemap(file)


@pytest.mark.parametrize("url", ["https://tiles.example.org/world.pmtiles", "s3://bucket/world.pmtiles"])
def test_remote_base_maps_are_refused(url: str) -> None:
    with pytest.raises(ConfigurationError, match="loads nothing from a network"):
        check_basemap(Path(url))


async def test_nothing_is_served_with_a_base_map_that_does_not_exist(tmp_path: Path) -> None:
    config = ApiConfig(basemap=tmp_path / "none.pmtiles", port=0)
    with pytest.raises(ConfigurationError, match=r"none\.pmtiles: No such file"):
        async with open_dashboard(ScriptedMission(LoopClock()), config, OperatorSecrets("code")):
            pass
