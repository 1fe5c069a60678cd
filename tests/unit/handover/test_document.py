"""The hand-over on paper: its flights, its words, and what it makes of hostile ones; PDFium reads it back."""

from __future__ import annotations

import asyncio
import contextlib
import csv
import errno
import io
import os
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from pathlib import Path
from typing import ParamSpec, TypeVar

import httpx
import numpy as np
import pypdfium2 as pdfium
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.notations import Notation, dms, mgrs_text, utm_text, written
from aos_gcs.handover.contents import read_handover
from aos_gcs.handover.flights import COLUMNS, FlightLog, to_csv
from aos_gcs.handover.model import HandoverOptions, LoggedFlight, Paper
from aos_gcs.handover.styles import paragraph
from aos_gcs.handover.texts import make_writer, markup, shortened
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.runtime.recorded import handover as runtime
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes import records
from tests.fakes.app import app_of
from tests.fakes.command_line import exit_status
from tests.fakes.handed_over import FOUND, START_UTC_S, record_handed_over, snapshot_of, state
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock
from tests.fakes.viewed_step import record_viewed_step

P = ParamSpec("P")
T = TypeVar("T")

PRINTED_UTC_S = START_UTC_S + 3600.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return asyncio.run(record_handed_over(tmp_path_factory.mktemp("missions")))


def text_of(pdf: bytes) -> str:
    with pdfium.PdfDocument(pdf) as document:
        return "\n".join(page.get_textpage().get_text_bounded() for page in document).replace("\r\n", "\n")


def printed(folder: Path, **options: object) -> str:
    return text_of(runtime.make_handover(folder, HandoverOptions(**options), PRINTED_UTC_S))  # type: ignore[arg-type]


def flights_of(*states: object) -> list[LoggedFlight]:
    log = FlightLog()
    for event in states:
        log.add(event.utc_s, snapshot_of(event))  # type: ignore[attr-defined, arg-type]
    return [flight for flight, _ in log.finish()]


# --- flights


def test_a_flight_has_its_way_and_its_battery() -> None:
    (flight,) = flights_of(
        state(0.0, up_m=0.0, battery=1.0),
        state(2.0, up_m=12.0, battery=0.9),
        state(8.0, up_m=12.0, battery=None),
        state(10.0, up_m=0.0, battery=0.7),
    )
    assert (flight.takeoff_utc_s, flight.landing_utc_s) == (START_UTC_S + 2.0, START_UTC_S + 10.0)
    assert flight.duration_s == 8.0
    assert flight.distance_m == pytest.approx(3.0 + np.hypot(1.0, 12.0))
    assert flight.max_height_m == 12.0
    assert flight.battery_used == pytest.approx(0.2)


def test_a_record_that_ends_in_the_air_has_no_landing() -> None:
    (flight,) = flights_of(state(0.0, up_m=5.0, battery=None), state(4.0, up_m=5.0, battery=None))
    assert (flight.landing_utc_s, flight.duration_s, flight.battery_used) == (None, 4.0, None)


def test_two_flights_of_a_vehicle_are_two_lines_of_the_log() -> None:
    flights = flights_of(*(state(float(second), up_m=up_m) for second, up_m in enumerate((0, 9, 0, 9, 0))))
    table = list(csv.DictReader(io.StringIO(to_csv(flights, 'the "ridge", north', 2))))
    assert tuple(table[0]) == COLUMNS
    assert [line["takeoff_utc"] for line in table] == ["2026-05-03T09:20:01Z", "2026-05-03T09:20:03Z"]
    assert [line["landing_utc"] for line in table] == ["2026-05-03T09:20:02Z", "2026-05-03T09:20:04Z"]
    assert (table[0]["operation"], table[0]["battery_used_percent"]) == ('the "ridge", north', "0")


# --- content and document


def test_a_decision_has_its_operator_and_its_time(folder: Path) -> None:
    with MissionReader(folder) as reader:
        handover = read_handover(reader)
    (reported,) = handover.findings
    assert reported.finding.status is FindingStatus.CONFIRMED
    assert (reported.found_utc_s, reported.decided_utc_s) == (START_UTC_S + 2.0, START_UTC_S + 5.0)
    assert handover.operators == ("Kim", "Robin")
    assert [entry.text.split(":")[0] for entry in handover.log] == ["Robin", "Kim", "Kim"]


@pytest.mark.parametrize("status", FindingStatus)
def test_a_comment_decides_nothing(tmp_path: Path, status: FindingStatus) -> None:
    folder = asyncio.run(record_handed_over(tmp_path, comment="wet", operator="Robin", status=status))
    with MissionReader(folder) as reader:
        (reported,) = read_handover(reader).findings
    is_decided = status is not FindingStatus.NEW
    assert reported.decided_utc_s == (START_UTC_S + 5.0 if is_decided else None)
    text = " ".join(text_of(runtime.make_handover(folder, HandoverOptions(), PRINTED_UTC_S)).split())
    assert ("Robin at" in text, "nobody yet" in text) == (is_decided, not is_decided)


@pytest.mark.parametrize("paper", Paper)
def test_the_document_says_what_was_found_decided_and_flown(folder: Path, paper: Paper) -> None:
    pdf = runtime.make_handover(folder, HandoverOptions(paper, Notation.MGRS, "Europe/Vienna"), PRINTED_UTC_S)
    with pdfium.PdfDocument(pdf) as document:
        assert document[0].get_size() == pytest.approx(
            {Paper.A4: (595.3, 841.9), Paper.LETTER: (612, 792)}[paper], 1e-3
        )
    text = " ".join(text_of(pdf).split())
    with MissionReader(folder) as reader:
        frame = read_handover(reader).frame
    assert frame is not None
    place = frame.to_geodetic(FOUND.position_enu_m)
    assert mgrs_text(place.latitude_deg, place.longitude_deg) in text
    assert "± 0.6 m x 0.4 m" in text
    assert "Robin at 2026-05-03 11:20:05 CEST" in text
    assert "Kim: start refused: it has begun" in text
    assert "Vehicle 1 Kim: hold refused: no link for 9 s" in text
    assert "20260503-092000-ridge (m), sortie 2" in text
    assert "Audit log: intact, 4 entries, digest " in text
    assert "Probability of success by the prior, all sorties so far: 41%." in text
    segment = "Segment A 1, all sorties so far: 70% of 1.20 ha seen, detection of a standing person 55%, success 33%."
    assert segment in text
    for title in ("Assignment (after ICS 204)", "Activity log (after ICS 214)", "Printed 2026-05-03 12:20:00 CEST"):
        assert title in text


def test_markup_in_names_and_comments_is_shown_as_it_is(tmp_path: Path) -> None:
    comment = "<b>left</b> &amp; <img src='file:///etc/passwd'/> </para> \x00\x1b[31m \u202e end"
    folder = asyncio.run(record_handed_over(tmp_path, comment=comment, operator="<a href='x'>Eve</a>"))
    text = " ".join(printed(folder).split())
    assert "<b>left</b> &amp; <img src='file:///etc/passwd'/> </para>" in text
    assert "<a href='x'>Eve</a>" in text


def test_ten_megabytes_of_comment_are_shortened(tmp_path: Path) -> None:
    folder = asyncio.run(record_handed_over(tmp_path, comment="x" * 10_000_000))
    pdf = runtime.make_handover(folder, HandoverOptions(), PRINTED_UTC_S)
    assert len(pdf) < 200_000
    assert "shortened from 10,000,000 characters" in " ".join(text_of(pdf).split())


def test_findings_have_pictures_where_frames_show_them(tmp_path: Path) -> None:
    folder = asyncio.run(record_viewed_step(tmp_path))
    found = replace(FOUND, position_enu_m=(0.0, 0.0, 0.0), step=1)
    asyncio.run(_with_finding(folder, found))
    pdf = runtime.make_handover(folder, HandoverOptions(), PRINTED_UTC_S)
    with pdfium.PdfDocument(pdf) as document:
        images = [one for page in document for one in page.get_objects(filter=[pdfium.raw.FPDF_PAGEOBJ_IMAGE])]
        assert len(images) == 2
        colour = images[0].get_bitmap().to_numpy()
    assert (colour[..., :3].max() > 200, colour[..., :3].min() < 80) == (True, True)


async def _with_finding(folder: Path, finding: object) -> None:
    with MissionReader(folder) as reader:
        (event,) = reader.events()
    shown = replace(snapshot_of(event), findings=(finding,))  # type: ignore[arg-type]
    async with MissionRecorder.reopen(folder, 1, notify=lambda _: None) as recorder:
        await recorder.record_event(replace(event, seq=2, data=shown))


def test_a_survey_has_no_flights_and_no_times_of_its_examination(tmp_path: Path) -> None:
    async def record() -> None:
        decided = replace(FOUND, status=FindingStatus.CONFIRMED, operator="Robin")
        shown = replace(records.snapshot(), vehicles=(), findings=(decided,))
        async with MissionRecorder.create(tmp_path, "m", {}, notify=lambda _: None) as recorder:
            await recorder.record_event(Event(1, START_UTC_S, EventKind.SNAPSHOT, shown))

    asyncio.run(record())
    with MissionReader(tmp_path / "m") as reader:
        handover = read_handover(reader)
    (reported,) = handover.findings
    assert (handover.flights, reported.found_utc_s, reported.seen_utc_s) == ((), None, None)
    assert reported.decided_utc_s == START_UTC_S
    text = " ".join(printed(tmp_path / "m").split())
    assert "none: recorded flight" in text
    assert "No flight is in the record." in text


def test_a_record_without_any_state_is_refused(tmp_path: Path) -> None:
    async def record() -> None:
        async with MissionRecorder.create(tmp_path, "m", {}, notify=lambda _: None):
            pass

    asyncio.run(record())
    with pytest.raises(InputDataError, match="holds no state of the mission"):
        runtime.make_handover(tmp_path / "m", HandoverOptions(), PRINTED_UTC_S)


# --- texts


@given(st.text(max_size=80))
@settings(max_examples=30, deadline=None)
def test_any_text_can_be_laid_out(text: str) -> None:
    shown = paragraph(text)
    width, height = shown.wrap(60.0, 10_000.0)
    assert (width, height >= 0.0) == (60.0, True)


def test_a_shortened_text_says_so() -> None:
    assert shortened("a  b\n c", 100) == "a b c"
    assert shortened("abcdef", 3) == "abc … (shortened from 6 characters)"
    assert markup("a<b>\x00") == "a&lt;b&gt;\ufffd"


@pytest.mark.parametrize("name", ["Europe/Vienne", "../../etc/passwd", "/etc/localtime", "", "x" * 300])
def test_an_unknown_time_zone_is_named(name: str) -> None:
    with pytest.raises(ConfigurationError, match="time_zone: "):
        make_writer(name, Notation.UTM, None)


def test_places_are_written_in_the_notation_of_the_team() -> None:
    place = 48.33, -14.33
    assert written(*place, Notation.DECIMAL) == "48.330000° N, 14.330000° W"
    assert written(*place, Notation.DMS) == dms(*place)
    assert written(*place, Notation.UTM) == utm_text(*place)
    assert written(*place, Notation.MGRS) == mgrs_text(*place)
    assert written(85.0, 10.0, Notation.UTM) == "85.000000° N, 10.000000° E"


# --- command


def run(*arguments: object) -> int:
    return exit_status(["report", *arguments])


def test_the_command_writes_document_and_flight_log(folder: Path, tmp_path: Path) -> None:
    out, flights = tmp_path / "handover.pdf", tmp_path / "flights.csv"
    assert run(folder, "--out", out, "--flights", flights, "--notation", "utm", "--paper", "letter") == 0
    assert "33U " in text_of(out.read_bytes())
    (line,) = csv.DictReader(flights.read_text(encoding="utf-8").splitlines())
    assert (line["vehicle"], line["duration_s"], line["battery_used_percent"]) == ("1", "4", "20")


def test_a_full_disk_leaves_the_former_document(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "handover.pdf"
    out.write_bytes(b"before")

    def full(_descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    assert run(folder, "--out", out) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("handover.pdf", b"before")]


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "Nothing to write"),
        (["--out", "/nowhere/handover.pdf"], "does not exist"),
        (["--out", "h.pdf", "--time-zone", "Mars"], "time_zone: 'Mars'"),
        (["--out", "r.txt"], "--out r.txt: the name must end in .pdf"),
        (["--out", "h.pdf", "--flights", "f.pdf"], "--flights f.pdf: the name must end in .csv"),
        (["--out", "h.pdf", "--flights", "h.pdf"], "named for two results"),
    ],
)
def test_what_cannot_be_printed_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], reason: str
) -> None:
    with contextlib.chdir(tmp_path):
        assert run(folder, *arguments) == 2
    assert reason in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_the_record_itself_is_not_overwritten(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(folder, "--out", folder / "mission.sqlite") == 2
    assert "file of the recording" in capsys.readouterr().err


# --- service


class InThisProcess:
    """A worker for tests of the routes: computes in this process, once it may."""

    def __init__(self) -> None:
        self.has_begun, self.may_go_on = asyncio.Event(), asyncio.Event()
        self.may_go_on.set()

    async def ready(self) -> None:
        pass

    async def run(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        self.has_begun.set()
        await self.may_go_on.wait()
        return function(*args, **kwargs)

    async def __aenter__(self) -> InThisProcess:
        return self

    async def __aexit__(self, *_: object) -> None:
        pass


@pytest.fixture
async def worker(monkeypatch: pytest.MonkeyPatch) -> InThisProcess:
    worker = InThisProcess()
    monkeypatch.setattr(runtime, "open_worker", lambda _: worker)
    return worker


@pytest.fixture
async def client(folder: Path, worker: InThisProcess) -> AsyncIterator[httpx.AsyncClient]:  # noqa: ARG001 - is used
    printer = runtime.HandoverPrinter(lambda: folder, lambda: PRINTED_UTC_S)
    app = app_of(ScriptedMission(HandClock()), handovers=printer, operator_code="x")
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        yield client


async def test_observers_may_download_both(client: httpx.AsyncClient) -> None:
    answer = await client.get("/api/handover.pdf", params={"notation": "utm", "time_zone": "Asia/Tokyo"})
    assert (answer.status_code, answer.headers["content-type"]) == (200, "application/pdf")
    assert "2026-05-03 18:20:05 JST" in text_of(answer.content)
    table = await client.get("/api/handover/flights.csv")
    assert table.text.splitlines()[0].startswith("operation,sortie,vehicle")


async def test_one_document_is_made_at_a_time(client: httpx.AsyncClient, worker: InThisProcess) -> None:
    worker.may_go_on.clear()
    async with asyncio.TaskGroup() as group:
        first = group.create_task(client.get("/api/handover.pdf"))
        await worker.has_begun.wait()
        assert (await client.get("/api/handover.pdf")).status_code == 503
        worker.may_go_on.set()
    assert first.result().status_code == 200
    assert (await client.get("/api/handover.pdf")).status_code == 200


async def test_an_unknown_zone_and_a_missing_record_are_explained(client: httpx.AsyncClient) -> None:
    answer = await client.get("/api/handover.pdf", params={"time_zone": "Mars"})
    assert (answer.status_code, "Mars" in answer.json()["message"]) == (422, True)
    without = httpx.ASGITransport(app_of(ScriptedMission(HandClock())))
    async with httpx.AsyncClient(transport=without, base_url="http://localhost") as other:
        assert (await other.get("/api/handover.pdf")).status_code == 404


async def test_a_missing_library_is_named(client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "reportlab", None)
    answer = await client.get("/api/handover.pdf")
    assert answer.status_code == 422
    assert "pip install 'aos-gcs[report]'" in answer.json()["message"]
