"""Base maps of a server's tiles: what is asked of it, and what of its answers becomes of the map."""

from __future__ import annotations

import gc
import re
import sqlite3
import ssl
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import pytest

pytest.importorskip("PIL")
pytest.importorskip("pmtiles")

from aos_gcs.api.basemap_file import check_basemap
from aos_gcs.api.tls import own_certificate, server_context
from aos_gcs.basemaps.downloading import TileArea, download_basemap
from aos_gcs.basemaps.making import BasemapReport
from aos_gcs.basemaps.pyramid import Advance
from aos_gcs.basemaps.tiles.addresses import TileTemplate
from aos_gcs.basemaps.tiles.requests import CONNECTIONS, MAX_TILE_BYTES, Pace
from aos_gcs.basemaps.tiles.store import tile_store
from aos_gcs.errors import AosError, ConfigurationError, InputDataError, LinkError
from tests.fakes.command_line import exit_status
from tests.fakes.map_files import ShownMap
from tests.fakes.tile_server import Place, Reply, TileServer, picture, tile_server

AREA_DEG = (14.2, 47.4, 14.3, 47.5)
AREA = TileArea.checked(AREA_DEG, 8, 12)
PLACES = set(AREA.places())
FIRST = min(PLACES)
PLAN = """
[link]
urls = ["udpin://127.0.0.1:14550"]
[mission]
vehicles = 3
any_vehicles = true
origin_deg = [47.5, 14.25, 800.0]
area_enu_m = [[-60.0, -60.0], [60.0, -60.0], [60.0, 60.0], [-60.0, 60.0]]
"""


class FakeTime:
    """Time that passes while somebody waits, and at no other time."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    async def sleep(self, seconds: float) -> None:
        self.now_s += seconds


@contextmanager
def silent(_total: int) -> Iterator[Advance]:
    yield lambda _: None


@pytest.fixture
def server() -> Iterator[TileServer]:
    with tile_server() as serving:
        yield serving


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "map.pmtiles"


@pytest.fixture
def time() -> FakeTime:
    return FakeTime()


@pytest.fixture
def make(server: TileServer, out: Path, time: FakeTime) -> Callable[..., BasemapReport]:
    def made(area: TileArea = AREA, suffix: str = "", attribution: str = "© A survey") -> BasemapReport:
        template = TileTemplate.parsed(server.address + suffix)
        pace = Pace(4.0, time, time.sleep)
        report = download_basemap(out, template, area, attribution, pace=pace, progress=silent)
        check_basemap(out)
        return report

    return made


def at_first(reply: Reply) -> Callable[[Place, int], Reply]:
    """Return what answers the first request for each tile with a reply, and further ones with the tile."""
    return lambda place, count: reply if count == 0 else Reply(picture(place))


def the_error(make: Callable[..., BasemapReport], **options: str) -> AosError:
    """Return the error of a download; all of its connections have the same kind."""
    with pytest.raises((AosError, BaseExceptionGroup)) as caught:
        make(**options)
    error = caught.value
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    assert isinstance(error, AosError)
    return error


def test_every_tile_is_asked_for_once_and_kept_as_it_is(
    make: Callable[..., BasemapReport], server: TileServer, out: Path, time: FakeTime
) -> None:
    report = make()
    shown = ShownMap(out)
    assert sorted(server.asked) == sorted(PLACES)
    assert all(shown.tile(*place) == picture(place) for place in PLACES)
    assert (report.tiles, report.min_zoom, report.max_zoom) == (len(PLACES), 8, 12)
    assert (shown.header["min_zoom"], shown.header["max_zoom"], shown.header["tile_type"].name) == (8, 12, "PNG")
    assert (shown.header["min_lon_e7"], shown.header["max_lat_e7"]) == pytest.approx((14.2e7, 47.5e7), abs=2)
    assert shown.metadata["attribution"] == "© A survey"
    assert server.agents == {f"aos-gcs/{version('aos-gcs')} (aos-gcs basemap)"}
    assert server.most_at_once <= CONNECTIONS
    assert time.now_s - 100.0 == pytest.approx((len(PLACES) - 1) / 4.0)
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_tiles_that_the_server_does_not_have_stay_empty(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    lacking = {FIRST: 404, max(PLACES): 204}
    server.answer = lambda place, _: Reply(b"" if place in lacking else picture(place), lacking.get(place, 200))
    assert make().tiles == len(PLACES) - 2
    assert ShownMap(out).tile(*FIRST) is None
    server.answer = lambda _place, _count: Reply(status=404)
    error = the_error(make)
    assert isinstance(error, InputDataError)
    assert "has no tiles of this area" in str(error)


def test_kinds_that_a_server_mixes_become_one(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    endings = (".png", ".jpg", ".webp")
    server.answer = lambda place, _: Reply(picture(place, ending=endings[sum(place) % 3], side_px=512))
    make()
    shown = ShownMap(out)
    assert shown.header["tile_type"].name == "WEBP"
    assert all((shown.tile(*place) or b"")[8:12] == b"WEBP" for place in PLACES)


def test_an_interrupted_download_goes_on_where_it_was(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    out.write_bytes(b"the old one")
    server.answer = lambda place, _: Reply(picture(place), 403 if place[0] == 12 else 200)
    assert "refuses tile 12/" in str(the_error(make))
    assert out.read_bytes() == b"the old one"
    assert {path.name for path in out.parent.iterdir()} == {out.name, f"{out.name}.download"}
    done = {place for place in PLACES if place[0] < 12}
    server.asked.clear()
    server.answer = lambda place, _: Reply(picture(place))
    assert "another address in --tiles" in str(the_error(make, suffix="?key=other"))
    make()
    assert len(done.intersection(server.asked)) < CONNECTIONS  # others were under way when the first was refused
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    assert all(ShownMap(out).tile(*place) == picture(place) for place in PLACES)


def test_ctrl_c_keeps_what_was_sent_and_makes_no_map(server: TileServer, out: Path, time: FakeTime) -> None:
    template, pace = TileTemplate.parsed(server.address), Pace(4.0, time, time.sleep)

    @contextmanager
    def interrupted(_total: int) -> Iterator[Advance]:
        def advance(count: int) -> None:
            if count:
                raise KeyboardInterrupt

        yield advance

    with pytest.raises(KeyboardInterrupt):
        download_basemap(out, template, AREA, "© A survey", pace=pace, progress=interrupted)
    gc.collect()  # asyncio reports the interrupted task when it is collected: here, not on the stderr of a later test
    assert not out.exists()
    asked = set(server.asked)
    assert asked < PLACES
    download_basemap(out, template, AREA, "© A survey", pace=pace, progress=silent)
    assert len(server.asked) <= len(PLACES) + 1  # the one that was under way is asked for again
    assert ShownMap(out).tile(*FIRST) == picture(FIRST)


def test_tiles_beyond_the_area_that_an_earlier_run_has_kept_are_left_out(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    server.answer = lambda place, _: Reply(picture(place), 403 if place[0] == 12 else 200)
    the_error(make)
    make(area=TileArea.checked(AREA_DEG, 9, 10))
    assert ShownMap(out).header["min_zoom"] == 9
    assert ShownMap(out).header["max_zoom"] == 10


@pytest.mark.parametrize(
    ("headers", "waited_s"),
    [
        ({"Retry-After": "90"}, 90.0),
        ({"Date": "Sat, 28 Nov 2026 12:00:00 GMT", "Retry-After": "Sat, 28 Nov 2026 12:01:00 GMT"}, 60.0),
        ({"Retry-After": "1"}, 2.0),
        ({"Retry-After": "soon"}, 2.0),
        ({}, 2.0),
    ],
)
def test_a_server_is_left_alone_for_as_long_as_it_asks(
    make: Callable[..., BasemapReport], server: TileServer, time: FakeTime, headers: dict[str, str], waited_s: float
) -> None:
    area = TileArea.checked(AREA_DEG, 8, 8)
    for status in (429, 503):
        server.asked.clear()
        began_s = time.now_s
        server.answer = at_first(Reply(b"", status, headers))
        assert make(area=area).tiles == area.count == 1
        assert time.now_s - began_s == pytest.approx(waited_s)


def test_waiting_has_an_end(make: Callable[..., BasemapReport], server: TileServer, time: FakeTime) -> None:
    server.answer = lambda _place, _count: Reply(b"", 503)
    assert "status 503, 5 times" in str(the_error(make))
    assert len(server.asked) <= 10
    assert time.now_s < 100.0 + 200.0


def test_a_server_that_wants_an_hour_is_asked_no_more(make: Callable[..., BasemapReport], server: TileServer) -> None:
    server.answer = lambda _place, _count: Reply(b"", 429, {"Retry-After": "3600"})
    assert "no requests for 3,600 s; come back after that" in str(the_error(make))
    assert len(server.asked) <= CONNECTIONS


@pytest.mark.parametrize(
    ("reply", "expected"),
    [
        (Reply(b"<html>no key</html>"), (InputDataError, "is no PNG, JPEG or WebP picture")),
        (Reply(picture(side_px=300)), (InputDataError, "has 300 x 300 pixels")),
        (Reply(picture(ending=".jpg")[:-60]), (InputDataError, "is a damaged picture")),
        (Reply(picture()[:100]), (InputDataError, "is a damaged picture")),
        (Reply(bytes(MAX_TILE_BYTES + 1)), (InputDataError, "is larger than 1024 KiB")),
        (Reply(status=401), (ConfigurationError, r"status 401.*its key")),
        (Reply(status=302), (ConfigurationError, "status 302")),
        (Reply(status=302, headers={"Location": "http://127.0.0.2/a.png"}), (ConfigurationError, r"127\.0\.0\.2")),
        (Reply(status=302, headers={"Location": "https://127.0.0.1/a.png"}), (ConfigurationError, "another scheme")),
        (Reply(status=302, headers={"Location": "file:///etc/hostname"}), (ConfigurationError, "no address of HTTP")),
        (Reply(status=302, headers={"Location": "http://[oops"}), (ConfigurationError, "no address of HTTP")),
        (Reply(status=302, headers={"Location": "/tiles/0/0/0.png"}), (ConfigurationError, "more than 3 redirections")),
        (
            Reply(status=200, headers={"Content-Length": "999", "Connection": "close"}),
            (LinkError, "ClientPayloadError"),
        ),
    ],
)
def test_what_cannot_be_used_ends_the_download_and_no_key_is_shown(
    make: Callable[..., BasemapReport],
    server: TileServer,
    out: Path,
    reply: Reply,
    expected: tuple[type[AosError], str],
) -> None:
    server.answer = lambda _place, _count: reply
    error = the_error(make, suffix="?key=s3cret")
    assert isinstance(error, expected[0])
    assert re.search(expected[1], str(error))
    assert "s3cret" not in str(error)
    assert str(error).startswith("127.0.0.1")
    assert list(out.parent.iterdir()) == []


def test_a_redirection_within_the_server_is_followed(make: Callable[..., BasemapReport], server: TileServer) -> None:
    def answer(place: Place, _count: int) -> Reply:
        if server.paths[-1].startswith("/tiles") and place == (8, 138, 89):
            return Reply(status=301, headers={"Location": f"/moved/{place[0]}/{place[1]}/{place[2]}.png"})
        return Reply(picture(place))

    server.answer = answer
    area = TileArea.checked(AREA_DEG, 8, 8)
    assert set(area.places()) == {(8, 138, 89)}
    make(area=area)
    assert server.paths[-1] == "/moved/8/138/89.png"


def test_no_connection_and_unknown_certificates_are_named(out: Path, tmp_path: Path, time: FakeTime) -> None:
    with tile_server() as closed:
        pass
    context: ssl.SSLContext = server_context(own_certificate(tmp_path / "tls", datetime.now(UTC)))
    with tile_server(context) as unknown:
        for server, reason in ((closed, "no connection"), (unknown, "certificate cannot be verified")):
            template = TileTemplate.parsed(f"{server.address}?key=s3cret")
            with pytest.raises(BaseExceptionGroup) as caught:
                download_basemap(out, template, AREA, "© A survey", pace=Pace(4.0, time, time.sleep), progress=silent)
            (error, *_) = caught.value.exceptions
            assert isinstance(error, LinkError)
            assert reason in str(error)
            assert "s3cret" not in str(error)
        assert unknown.asked == []


def test_neither_map_nor_kept_tiles_hold_the_key(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    server.answer = lambda place, _: Reply(picture(place), 403 if place[0] == 12 else 200)
    the_error(make, suffix="?key=s3cret")
    assert b"s3cret" not in out.with_name(f"{out.name}.download").read_bytes()
    server.answer = lambda place, _: Reply(picture(place))
    make(suffix="?key=s3cret")
    assert b"s3cret" not in out.read_bytes()
    assert server.paths[-1].endswith("?key=s3cret")


@pytest.mark.parametrize("attribution", ["", "  ", "x" * 201])
def test_a_map_needs_an_attribution_that_can_be_shown(
    make: Callable[..., BasemapReport], server: TileServer, attribution: str
) -> None:
    with pytest.raises(ConfigurationError, match="--attribution needs the text"):
        make(attribution=attribution)
    assert server.asked == []


def test_kept_tiles_that_are_damaged_in_use_or_of_another_version_are_refused(
    make: Callable[..., BasemapReport], server: TileServer, out: Path
) -> None:
    kept = out.with_name(f"{out.name}.download")
    kept.write_bytes(b"no database" * 100)
    with pytest.raises(InputDataError, match="delete it to start anew"):
        make()
    assert kept.exists()
    kept.unlink()
    with closing(sqlite3.connect(kept)) as connection:
        connection.execute("PRAGMA user_version = 99")
    with pytest.raises(InputDataError, match="another version of the program"):
        make()
    kept.unlink()
    with tile_store(out, "another download"), pytest.raises(InputDataError, match="another download uses it"):
        make()
    assert server.asked == []


ENOUGH = ("--terms-allow-copies", "--area", "14.2,47.4,14.3,47.5", "--zoom", "8-9", "--attribution", "© A survey")


def test_the_command_says_what_it_will_ask_for_before_it_does(
    server: TileServer, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_status(["basemap", str(out), "--tiles", f"{server.address}?key=s3cret", "--rate", "10", *ENOUGH]) == 0
    told = capsys.readouterr()
    assert f"2 tiles of zooms 8 to 9 from {server.host.split(':')[0]}, at most 10 per second: 0 s or more" in told.err
    assert told.out.startswith(f"{out}: 2 tiles, zooms 8 to 9, ")
    assert "s3cret" not in told.out + told.err


def test_the_area_of_a_plan_is_taken_with_its_surroundings(server: TileServer, out: Path, tmp_path: Path) -> None:
    plan = tmp_path / "mission.toml"
    plan.write_text(PLAN)
    options = ("--terms-allow-copies", "--plan", str(plan), "--zoom", "13-13", "--attribution", "© A survey")
    assert exit_status(["basemap", str(out), "--tiles", server.address, "--rate", "10", *options]) == 0
    header = ShownMap(out).header
    assert header["min_lat_e7"] == pytest.approx((47.5 - 560.0 / 111_195.0) * 1e7, abs=200)
    assert header["max_lon_e7"] == pytest.approx((14.25 + 560.0 / 75_200.0) * 1e7, abs=2000)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (ENOUGH[1:], "read them, and add --terms-allow-copies"),
        ((*ENOUGH[:1], *ENOUGH[3:]), "needs either --area W,S,E,N or --plan"),
        ((*ENOUGH, "--plan", "mission.toml"), "needs either --area W,S,E,N or --plan"),
        ((*ENOUGH[:3], *ENOUGH[5:]), "needs --zoom MIN-MAX"),
        ((*ENOUGH, "--zoom", "8"), "--zoom needs MIN-MAX"),
        ((*ENOUGH, "--zoom", "0-22"), "are allowed"),
        ((*ENOUGH, "--area", "14.2,47.4"), "--area needs west,south,east,north"),
        ((*ENOUGH, "--area", "-1,50,-2,51"), "must be west,south,east,north"),
        (ENOUGH[:5], "--attribution needs the text"),
        ((*ENOUGH, "--max-zoom", "9"), "--zoom instead of --max-zoom"),
        (("ortho.tif", *ENOUGH), "leave the files out"),
    ],
)
def test_options_that_are_missing_or_wrong_are_named_and_nothing_is_asked(
    server: TileServer, out: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], reason: str
) -> None:
    assert exit_status(["basemap", str(out), "--tiles", f"{server.address}?key=s3cret", *options]) == 2
    told = capsys.readouterr().err
    assert reason in told
    assert "s3cret" not in told
    assert server.asked == []
    assert not out.exists()


def test_options_of_servers_are_refused_without_one(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status(["basemap", str(out), "ortho.tif", "--terms-allow-copies"]) == 2
    assert "--terms-allow-copies is for the tiles of a server" in capsys.readouterr().err
    assert exit_status(["basemap", str(out)]) == 2
    assert "Name the files" in capsys.readouterr().err
