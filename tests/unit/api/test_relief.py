"""The relief about the mission through the API: shading and contour lines, made once."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

import httpx
import numpy as np
import pytest

pytest.importorskip("rasterio")

from aos_gcs.api import relief_maps
from aos_gcs.api.app import create_app
from aos_gcs.clock import LoopClock
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.planning.settings import TerrainSettings
from aos_gcs.planning.terrain.relief import HeightUnit
from tests.fakes.app import app_of
from tests.fakes.mission import ORIGIN, ScriptedMission
from tests.fakes.relief import hill, terrain, write_relief

BASE_URL = "http://127.0.0.1:8080"
NONE = {"shading_url": None, "contours_url": None, "contours_ft_url": None, "corners": []}


@pytest.fixture
def ground(tmp_path: Path) -> TerrainSettings:
    return terrain(write_relief(tmp_path / "ground.tif", hill(0.0, 40.0, 30.0, 80.0), origin=ORIGIN))


def client_of(settings: TerrainSettings | None, *, recorded: bool = False) -> httpx.AsyncClient:
    if recorded:
        app = create_app(ScriptedMission(LoopClock()), terrain=settings)
    else:
        app = app_of(ScriptedMission(LoopClock(), terrain=settings))
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url=BASE_URL)


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[None]:
    """One entry for every relief that was computed."""
    entries: list[None] = []
    original: Callable[..., relief_maps.ReliefMap] = relief_maps._make

    def counted(*args: object) -> relief_maps.ReliefMap:
        entries.append(None)
        return original(*args)

    monkeypatch.setattr(relief_maps, "_make", counted)
    return entries


@pytest.mark.parametrize("recorded", [False, True])
async def test_the_relief_is_where_the_ground_is(ground: TerrainSettings, recorded: bool) -> None:
    async with client_of(ground, recorded=recorded) as client:
        relief = (await client.get("/api/relief")).json()
        shading = await client.get(relief["shading_url"])
        contours, in_feet = [(await client.get(relief[name])).json() for name in ("contours_url", "contours_ft_url")]
        wrong = await client.get("/api/relief/contours?unit=yard")
    assert shading.headers["content-type"] == "image/png"
    assert shading.content.startswith(b"\x89PNG")
    assert (relief["corners"][0]["east_m"], relief["corners"][0]["north_m"]) == (-800.0, 800.0)
    highest = max(contours["lines"], key=lambda line: line["altitude_amsl_m"])
    assert highest["altitude_amsl_m"] % contours["interval_m"] == 0
    assert 0 < ORIGIN.altitude_amsl_m + 30.0 - highest["altitude_amsl_m"] <= contours["interval_m"]
    assert {round(line["altitude_amsl_m"] / 0.3048, 6) % 5.0 for line in in_feet["lines"]} == {0.0}
    assert wrong.status_code == 422
    top = LocalFrame(ORIGIN).to_geodetic((0.0, 40.0, 0.0))
    assert np.mean(highest["latitude_deg"]) == pytest.approx(top.latitude_deg, abs=3e-5)
    assert np.mean(highest["longitude_deg"]) == pytest.approx(top.longitude_deg, abs=3e-5)


async def test_all_clients_share_one_relief(ground: TerrainSettings, made: list[None]) -> None:
    async with client_of(ground) as client:
        paths = ("/api/relief", "/api/relief/shading.png", "/api/relief/contours", "/api/relief")
        answers = await asyncio.gather(*(client.get(path) for path in paths))
        again = await client.get("/api/relief/shading.png", headers={"If-None-Match": answers[1].headers["ETag"]})
    assert [answer.status_code for answer in answers] == [200] * 4
    assert again.status_code == 304
    assert len(made) == 1


async def test_a_model_that_is_replaced_has_another_relief(
    ground: TerrainSettings, tmp_path: Path, made: list[None]
) -> None:
    async with client_of(ground) as client:
        before = (await client.get("/api/relief")).json()
        write_relief(tmp_path / "ground.tif", hill(0.0, 0.0, 80.0, 80.0), origin=ORIGIN)
        after = (await client.get("/api/relief")).json()
    assert before["shading_url"] != after["shading_url"]
    assert len(made) == 2


async def test_without_an_elevation_model_there_is_none() -> None:
    async with client_of(None) as client:
        assert (await client.get("/api/relief")).json() == NONE
        for path in ("shading.png", "contours"):
            missing = await client.get(f"/api/relief/{path}")
            assert missing.status_code == 404
            assert "[terrain]" in missing.json()["message"]


async def test_a_model_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    async with client_of(terrain(tmp_path / "gone.tif")) as client:
        answer = await client.get("/api/relief")
    assert answer.status_code == 422
    assert "gone.tif" in answer.json()["message"]


async def test_lines_of_a_relief_that_was_replaced_meanwhile_are_its_own(
    ground: TerrainSettings, tmp_path: Path
) -> None:
    reliefs, snapshot = relief_maps.ReliefMaps(), ScriptedMission(LoopClock()).snapshot()
    former = await reliefs.about(snapshot, ground)
    assert former is not None
    lines = await reliefs.contours_json(former, HeightUnit.METRE)
    write_relief(tmp_path / "ground.tif", hill(0.0, 0.0, 80.0, 80.0), origin=ORIGIN)
    present = await reliefs.about(snapshot, ground)
    assert present is not None
    assert await reliefs.contours_json(former, HeightUnit.METRE) == lines
    assert await reliefs.contours_json(present, HeightUnit.METRE) != lines
