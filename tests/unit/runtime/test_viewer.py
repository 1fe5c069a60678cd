"""Recorded steps on other focal planes, and their single frames, directly and through the API."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from pathlib import Path
from typing import ParamSpec, TypeVar

import cv2
import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError, WorkerError
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.viewing import FrameKind, PictureFormat, ViewerBusyError, ViewKind, ViewWindow
from aos_gcs.runtime.processes.workers import VIEWS
from aos_gcs.runtime.recorded.viewer import MAX_WAITING, Viewer, open_viewer
from aos_gcs.store.reader import MissionReader
from aos_gcs.workers.process import open_worker
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.viewed_step import CAMERA, FLYING_HEIGHT_M, SPOT_HEIGHT_M, record_viewed_step

P = ParamSpec("P")
T = TypeVar("T")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return asyncio.run(record_viewed_step(tmp_path_factory.mktemp("missions")))


@pytest.fixture
def viewer(folder: Path) -> Viewer:
    return Viewer(folder, ImagingSettings(), focus_reach_m=10.0)


@pytest.fixture
async def client(viewer: Viewer) -> AsyncIterator[httpx.AsyncClient]:
    app = app_of(ScriptedMission(HandClock()), viewer=viewer)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        yield client


def decoded(png: bytes) -> NDArray[np.uint8]:
    image = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    assert image is not None
    return np.asarray(image, dtype=np.uint8)


def warm_width_m(png: bytes, width_m: float) -> float:
    """Return the extent of what is warm from west to east, of a picture of that width."""
    shades = decoded(png)[..., :3].sum(axis=2, dtype=int)
    columns = np.flatnonzero((shades > 0.5 * shades.max()).any(axis=0))
    return float(np.ptp(columns) + 1) * width_m / shades.shape[1]


async def test_the_spot_is_sharp_on_its_own_plane_and_parts_elsewhere(viewer: Viewer) -> None:
    def peak(png: bytes) -> int:
        return int(np.count_nonzero(decoded(png)[..., :3].max(axis=2) >= 240))

    sharp = await viewer.view(1, ViewKind.ANOMALY, SPOT_HEIGHT_M)
    ground = await viewer.view(1, ViewKind.ANOMALY, None)
    assert ground.height_m == 0.0
    # On the ground the four views lie 1.3 m apart: each is a blob of its own.
    assert sharp.visibility_m2 < 0.5 * ground.visibility_m2 * 4
    assert peak(sharp.data) < peak(ground.data)
    assert sharp.west_m < 0.0 < sharp.east_m
    assert sharp.south_m < 0.0 < sharp.north_m


@pytest.mark.parametrize("kind", ViewKind)
async def test_every_kind_can_be_seen(viewer: Viewer, kind: ViewKind) -> None:
    view = await viewer.view(1, kind, SPOT_HEIGHT_M)
    assert decoded(view.data).shape[2] == 4


async def test_a_draft_shows_the_same_in_fewer_bytes(viewer: Viewer) -> None:
    exact = await viewer.view(1, ViewKind.INTEGRAL, SPOT_HEIGHT_M)
    draft = await viewer.view(1, ViewKind.INTEGRAL, SPOT_HEIGHT_M, picture_format=PictureFormat.JPEG)
    assert len(draft.data) < 0.5 * len(exact.data)
    assert replace(draft, data=b"") == replace(exact, data=b"")
    shown, rgba = decoded(draft.data).astype(np.float32), decoded(exact.data)
    covered = rgba[..., 3] > 0
    inner = cv2.erode(covered.astype(np.uint8), np.ones((17, 17))) > 0
    # Noise is coded coarsely: what it stands for is the same in the mean of each neighbourhood.
    blurred, wanted = (cv2.blur(image, (9, 9)) for image in (shown, rgba[..., :3].astype(np.float32)))
    assert np.abs(blurred - wanted)[inner].mean() < 3.0
    assert shown[cv2.dilate(covered.astype(np.uint8), np.ones((17, 17))) == 0].max(initial=0.0) < 8.0


@pytest.mark.parametrize("kind", [ViewKind.INTEGRAL, ViewKind.THERMAL])
async def test_a_close_up_is_as_sharp_as_the_frames(
    viewer: Viewer, kind: ViewKind, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The raster of all that the frames see is coarser than their pixels.
    monkeypatch.setattr("aos_gcs.runtime.recorded.step_views.MAX_CELLS", 400)
    view = await viewer.view(1, kind, SPOT_HEIGHT_M, ViewWindow(0.5, 0.0, 2.0))
    shades = decoded(view.data)
    assert (view.west_m, view.east_m, view.south_m, view.north_m) == (-1.5, 2.5, -2.0, 2.0)
    cell_m = 4.0 / shades.shape[0]
    assert cell_m == pytest.approx((FLYING_HEIGHT_M - SPOT_HEIGHT_M) / CAMERA.fx_px, rel=0.06)
    blue, green, red, _ = np.moveaxis(shades.astype(np.float32), 2, 0)
    spot = cv2.blur(red - green if kind is ViewKind.INTEGRAL else red + green + blue, (3, 3))
    row, column = np.unravel_index(spot.argmax(), spot.shape)
    assert (column + 0.5) * cell_m == pytest.approx(1.5, abs=2 * cell_m)
    assert (row + 0.5) * cell_m == pytest.approx(2.0, abs=2 * cell_m)
    with pytest.raises(ConfigurationError, match="no frame of the step looks at this place"):
        await viewer.view(1, kind, SPOT_HEIGHT_M, ViewWindow(500.0, 0.0, 2.0))


async def test_the_nearest_camera_alone_shows_the_spot_once_where_all_spread_it(viewer: Viewer) -> None:
    everybody, nearest = ViewWindow(0.0, 0.0, 4.0), ViewWindow(0.0, 0.0, 4.0, nearest_only=True)
    assert warm_width_m((await viewer.view(1, ViewKind.THERMAL, 0.0, everybody)).data, 8.0) > 2.0
    assert warm_width_m((await viewer.view(1, ViewKind.THERMAL, 0.0, nearest)).data, 8.0) < 1.4


async def test_a_finding_is_seen_on_planes_above_it(viewer: Viewer) -> None:
    mission = ScriptedMission(HandClock())
    await mission.add_finding((0.0, 0.0, 0.0), "")
    mission.findings.adopt([replace(mission.findings.all()[0], step=1)])
    app = app_of(mission, viewer=viewer)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:

        async def width_m(query: str) -> float:
            response = await client.get(f"/api/findings/1/thermal.png{query}")
            assert response.status_code == 200, response.text
            return warm_width_m(response.content, 8.0)

        assert await width_m("") > 2.0
        assert await width_m("?nearest=true") < 1.4
        assert await width_m(f"?above_m={SPOT_HEIGHT_M}") < 1.4
        refused = await client.get("/api/findings/1/thermal.png?above_m=nan")
        assert refused.status_code == 422
        assert "above_m" in refused.json()["message"]


async def test_a_step_tells_what_can_be_seen_of_it(viewer: Viewer) -> None:
    viewed = await viewer.describe(1)
    assert (viewed.step, viewed.focal_height_m) == (1, 0.0)
    assert viewed.max_height_m == pytest.approx(FLYING_HEIGHT_M - 1.0, abs=0.01)
    assert [frame.vehicle_id for frame in viewed.frames] == [1, 2, 3, 4]
    assert viewed.frames[0].kinds == (FrameKind.COLOUR, FrameKind.THERMAL)
    np.testing.assert_allclose(viewed.frames[0].position_enu_m, [-6.0, 0.0, FLYING_HEIGHT_M], atol=0.01)


async def test_frames_are_shown_as_they_were_taken_or_smaller(viewer: Viewer) -> None:
    whole = decoded(await viewer.frame(1, 2, FrameKind.COLOUR, None))
    assert whole.shape == (128, 128, 4)
    assert decoded(await viewer.frame(1, 2, FrameKind.THERMAL, 32)).shape == (32, 32, 4)
    redness = cv2.blur(whole[..., 2].astype(np.float32) - whole[..., 1], (3, 3))
    row, column = np.unravel_index(redness.argmax(), redness.shape)
    assert column == pytest.approx(CAMERA.cx_px + 2.0 * CAMERA.fx_px / 30.0, abs=2.0)
    assert row == pytest.approx(CAMERA.cy_px, abs=2.0)


async def test_what_is_not_there_is_refused(viewer: Viewer) -> None:
    with pytest.raises(InputDataError, match="no step 7"):
        await viewer.describe(7)
    with pytest.raises(ConfigurationError, match="vehicle 9"):
        await viewer.frame(1, 9, FrameKind.COLOUR, None)
    with pytest.raises(ConfigurationError, match="height_m must lie within"):
        await viewer.view(1, ViewKind.INTEGRAL, FLYING_HEIGHT_M)


async def test_only_so_many_may_wait(viewer: Viewer) -> None:
    waiting = [asyncio.create_task(viewer.describe(1)) for _ in range(MAX_WAITING)]
    await asyncio.sleep(0)
    with pytest.raises(ViewerBusyError, match="try again"):
        await viewer.describe(1)
    assert all(viewed.step == 1 for viewed in await asyncio.gather(*waiting))
    await viewer.describe(1)


class BrokenWorker:
    async def run(self, function: Callable[P, T], /, *_args: P.args, **_kwargs: P.kwargs) -> T:
        raise WorkerError(f"Viewing has ended ({function.__name__})")


async def test_a_worker_that_fails_answers_busy(folder: Path) -> None:
    viewer = Viewer(folder, ImagingSettings(), focus_reach_m=10.0, worker=BrokenWorker())
    for _ in range(MAX_WAITING + 1):
        with pytest.raises(ViewerBusyError, match=r"Viewing has ended \(describe_step\); try again in a moment"):
            await viewer.describe(1)


@pytest.mark.realtime
async def test_views_of_a_process_are_those_of_a_thread(folder: Path, viewer: Viewer) -> None:
    async with open_worker(VIEWS) as worker:
        await worker.ready()
        apart = Viewer(folder, ImagingSettings(), focus_reach_m=10.0, worker=worker)
        assert await apart.describe(1) == await viewer.describe(1)
        wanted = await viewer.view(1, ViewKind.INTEGRAL, SPOT_HEIGHT_M)
        assert await apart.view(1, ViewKind.INTEGRAL, SPOT_HEIGHT_M) == wanted
        assert await apart.frame(1, 2, FrameKind.THERMAL, 32) == await viewer.frame(1, 2, FrameKind.THERMAL, 32)
        assert await apart.autofocus(1, (0.0, 0.0), 3.0) == await viewer.autofocus(1, (0.0, 0.0), 3.0)
        with pytest.raises(InputDataError, match="no step 7"):
            await apart.describe(7)


def test_a_record_with_foreign_settings_is_seen_with_the_usual_ones(folder: Path) -> None:
    with MissionReader(folder) as reader:
        assert isinstance(open_viewer(reader), Viewer)


async def test_the_api_shows_integrals_with_their_place(client: httpx.AsyncClient) -> None:
    response = await client.get("/api/viewer/1/integrals/integral.png", params={"height_m": SPOT_HEIGHT_M})
    assert response.status_code == 200
    west_m, south_m, east_m, north_m = map(float, response.headers["X-Bounds-M"].split(","))
    rows, columns = decoded(response.content).shape[:2]
    assert (east_m - west_m) / (north_m - south_m) == pytest.approx(columns / rows, rel=0.02)
    assert float(response.headers["X-Height-M"]) == SPOT_HEIGHT_M
    draft = await client.get("/api/viewer/1/integrals/integral.jpg", params={"height_m": SPOT_HEIGHT_M})
    assert draft.headers["Content-Type"] == "image/jpeg"
    assert draft.headers["X-Bounds-M"] == response.headers["X-Bounds-M"]
    described = (await client.get("/api/viewer/1")).json()
    assert described["kinds"] == ["integral", "thermal", "anomaly", "coverage"]
    frame = await client.get("/api/viewer/1/frames/3/colour.png", params={"width_px": 64})
    assert decoded(frame.content).shape == (64, 64, 4)


async def test_autofocus_answers_with_a_height_or_a_reason(client: httpx.AsyncClient) -> None:
    answer = (await client.get("/api/viewer/1/autofocus", params={"east_m": 0, "north_m": 0, "half_width_m": 3})).json()
    assert answer["found"] or answer["reason"]
    assert -10.0 <= answer["height_m"] <= 10.0
    nowhere = (await client.get("/api/viewer/1/autofocus", params={"east_m": 9000, "north_m": 0})).json()
    assert not nowhere["found"]
    assert nowhere["reason"]


@pytest.mark.parametrize(
    ("path", "status", "text"),
    [
        ("/api/viewer/7", 422, "no step 7"),
        ("/api/viewer/0", 422, "step"),
        ("/api/viewer/1/integrals/smell.png", 422, "kind"),
        ("/api/viewer/1/integrals/integral.gif", 422, "picture_format"),
        ("/api/viewer/1/integrals/integral.png?height_m=nan", 422, "height_m"),
        ("/api/viewer/1/integrals/integral.png?height_m=99", 422, "height_m"),
        ("/api/viewer/1/frames/1/colour.png?width_px=3", 422, "width_px"),
        ("/api/viewer/1/frames/9/colour.png", 422, "vehicle 9"),
        ("/api/viewer/1/autofocus?east_m=1e9&north_m=0", 422, "east_m"),
    ],
)
async def test_bad_requests_name_what_is_wrong(client: httpx.AsyncClient, path: str, status: int, text: str) -> None:
    response = await client.get(path)
    assert response.status_code == status
    assert text in response.json()["message"]


async def test_a_mission_without_a_record_has_nothing_to_look_at() -> None:
    app = app_of(ScriptedMission(HandClock()))
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        assert (await client.get("/api/viewer/1")).status_code == 404
