"""Cursor on Target: what marks say, which are due, and what a server's answers tell."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.heights import ellipsoidal_m, undulations
from aos_gcs.sharing.settings import TakSettings
from aos_gcs.sharing.tak.board import DELETIONS, MarkBoard
from aos_gcs.sharing.tak.events import Mark
from aos_gcs.sharing.tak.incoming import EventSplitter, parse_event, pong_utc_s
from aos_gcs.sharing.tak.scene import Scene, scene
from tests.fakes.elevation_files import PLACE_DEG, write_geoid
from tests.fakes.scripted_vehicle import ORIGIN
from tests.fakes.sharing import UTC_S, parsed, scripted, seen

PONG = b'<?xml version="1.0"?><event uid="takPong" type="t-x-c-t-r" time="2026-11-24T12:00:00.000Z"><detail/></event>'
PONG_UTC_S = 1_795_521_600.0


def snapshot(**changes: object) -> MissionSnapshot:
    return replace(scripted(), **changes)  # type: ignore[arg-type]


def finding(number: int = 1, **changes: object) -> Finding:
    made = Finding(number, FindingStatus.NEW, (10.0, 20.0, 1.0), 5.0, 8.0, 3, track_id=number, sigma_m=0.8, sightings=4)
    return replace(made, **changes)  # type: ignore[arg-type]


def marks(shown: MissionSnapshot, undulation_m: float | None = 45.0, now_s: float = 0.0) -> dict[str, ET.Element]:
    """Return the events of a state by their uids."""
    geoid = None if undulation_m is None else lambda _latitude_deg, _longitude_deg: undulation_m
    events = [parsed(mark.xml(UTC_S)) for mark in scene(seen(shown), "AOS", geoid, now_s).marks]
    return {event.get("uid", ""): event for event in events}


def point(event: ET.Element) -> dict[str, float]:
    found = event.find("point")
    assert found is not None
    return {name: float(value) for name, value in found.items()}


def attribute(event: ET.Element, path: str, name: str) -> str | None:
    found = event.find(path)
    return None if found is None else found.get(name)


# --- marks ------------------------------------------------------------------------------------------------------------


def test_a_vehicle_is_where_it_is_above_the_ellipsoid_with_its_course_and_its_errors_of_90_percent() -> None:
    shown = snapshot()
    vehicle = shown.vehicles[0]
    telemetry = replace(
        vehicle.telemetry,
        velocity_enu_mps=(-3.0, 0.0, 0.0),
        horizontal_accuracy_m=0.5,
        vertical_accuracy_m=2.0,
        battery_fraction=0.75,
    )
    vehicle = replace(vehicle, telemetry=telemetry, position_enu_m=(30.0, -40.0, 35.0))
    event = marks(replace(shown, vehicles=(vehicle,)))["AOS.vehicle.1"]
    position = LocalFrame(ORIGIN).to_geodetic((30.0, -40.0, 35.0))
    assert (event.get("type"), event.get("how")) == ("a-f-A-M-H-Q", "m-g")
    expected = {
        "lat": position.latitude_deg,
        "lon": position.longitude_deg,
        "hae": position.altitude_amsl_m + 45.0,
        "ce": 2.146 * 0.5,
        "le": 1.645 * 2.0,
    }
    assert point(event) == pytest.approx(expected, abs=0.01)
    assert point(event)["lat"] == pytest.approx(position.latitude_deg, abs=1e-7)
    assert attribute(event, "detail/track", "course") == "270.0"
    assert attribute(event, "detail/track", "speed") == "3.00"
    assert attribute(event, "detail/status", "battery") == "75"


def test_heights_are_unknown_without_a_geoid_and_never_above_the_sea() -> None:
    events = marks(snapshot(findings=(finding(),)), undulation_m=None)
    assert {point(event)["hae"] for event in events.values()} == {9999999.0}


def test_a_vehicle_that_is_not_heard_and_a_mission_that_is_silent_show_no_vehicles() -> None:
    shown = snapshot()
    silent = replace(shown.vehicles[0], link_age_s=5.1)
    assert [uid for uid in marks(replace(shown, vehicles=(silent, shown.vehicles[1]))) if "vehicle" in uid] == [
        "AOS.vehicle.2"
    ]
    assert not any("vehicle" in uid for uid in marks(shown, now_s=5.1))


def test_a_finding_has_the_error_of_its_longer_axis_and_keeps_its_name_in_the_next_sortie() -> None:
    found = finding(ellipse=ErrorEllipse(2.0, 0.5, 0.3), kind=FindingKind.PERSON, person_confidence=0.88)
    event = marks(snapshot(findings=(found,)))["AOS.scripted-1.finding.1"]
    assert point(event)["ce"] == pytest.approx(2.146 * 2.0, abs=0.01)
    assert point(event)["le"] == 9999999.0
    assert attribute(event, "detail/contact", "callsign") == "Finding 1: Possible person (88 %)"
    carried = replace(found, found_in="scripted-1", track_id=None)
    assert "AOS.scripted-1.finding.1" in marks(snapshot(findings=(carried,), mission_id="scripted-2"))


@given(st.text(max_size=200))
def test_comments_with_markup_arrive_as_they_are(comment: str) -> None:
    event = marks(snapshot(findings=(finding(comment=f"</event><a b='\"'>&{comment}"),)))["AOS.scripted-1.finding.1"]
    remarks = event.findtext("detail/remarks") or ""
    assert "</event><a b='\"'>&" in remarks
    assert len(event.findall("detail/remarks")) == 1


def test_a_finding_tells_the_time_of_day_at_which_it_was_last_seen() -> None:
    shown = snapshot(findings=(finding(seen_at_s=8.0),), started_utc_s=PONG_UTC_S)
    assert "last seen 12:00:08 UTC" in (marks(shown)["AOS.scripted-1.finding.1"].findtext("detail/remarks") or "")


def test_a_comment_of_ten_megabytes_is_cut() -> None:
    event = marks(snapshot(findings=(finding(comment="x" * 10**7),)))["AOS.scripted-1.finding.1"]
    assert len(event.findtext("detail/remarks") or "") == 2000


@pytest.mark.parametrize(
    ("changes", "is_shown"),
    [
        ({}, True),
        ({"status": FindingStatus.REJECTED}, False),
        ({"merged_into": 2}, False),
        ({"kind": FindingKind.ANIMAL}, False),
        ({"kind": FindingKind.ANIMAL, "status": FindingStatus.CONFIRMED}, True),
    ],
)
def test_searchers_see_what_may_be_a_person(changes: dict[str, object], is_shown: bool) -> None:
    shown = scene(seen(snapshot(findings=(finding(**changes),))), "AOS", None, 0.0)
    uid = "AOS.scripted-1.finding.1"
    assert (uid in {mark.uid for mark in shown.marks}, uid in shown.withdrawn) == (is_shown, not is_shown)


def test_the_search_area_the_legs_flown_and_the_places_looked_at_are_shown() -> None:
    legs = (((0.0, 0.0), (0.0, 50.0)), ((10.0, 0.0), (10.0, 50.0)))
    shown = snapshot(legs_enu_m=legs, leg=1)
    camera = shown.vehicles[0].camera
    assert camera is not None
    footprint = replace(camera, footprint_enu_m=((0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0)))
    events = marks(replace(shown, vehicles=(replace(shown.vehicles[0], camera=footprint),)))
    assert {uid.partition(".")[2] for uid in events} == {"vehicle.1", "look.1", "frame.1", "area", "leg.1"}
    look = LocalFrame(ORIGIN).to_geodetic((4.0, 3.0, 0.0))
    assert point(events["AOS.look.1"])["lon"] == pytest.approx(look.longitude_deg, abs=1e-7)
    assert attribute(events["AOS.look.1"], "detail/link", "uid") == "AOS.vehicle.1"
    corners = [link.get("point") for link in events["AOS.area"].iterfind("detail/link")]
    assert len(corners) == 5
    assert corners[0] == corners[-1]


def test_nothing_is_shown_before_the_origin_is_known() -> None:
    assert scene(seen(snapshot(origin=None)), "AOS", None, 0.0) == Scene()


# --- heights ----------------------------------------------------------------------------------------------------------


def test_heights_are_above_the_ellipsoid_within_a_decimetre(tmp_path: Path) -> None:
    undulation_m = undulations(str(write_geoid(tmp_path / "geoid.gtx", 45.0, slope_m_per_deg=10.0)))
    for north_deg in (0.0, 0.00049, 0.1234):
        place = GeodeticPosition(PLACE_DEG[0] + north_deg, PLACE_DEG[1], 800.0)
        assert ellipsoidal_m(place, undulation_m) == pytest.approx(845.0 + 10.0 * north_deg, abs=0.02)
    assert ellipsoidal_m(GeodeticPosition(-30.0, 100.0, 800.0), undulation_m) is None


def test_a_geoid_that_is_named_and_missing_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="does not exist"):
        undulations("/nowhere/geoid.gtx")


# --- which marks are due ----------------------------------------------------------------------------------------------


def mark(uid: str, *, north_deg: float = 48.0, is_live: bool = False) -> Mark:
    return Mark(uid, "a-f", "m-g", north_deg, 14.0, None, 10.0, "<detail/>", is_live=is_live)


def due(board: MarkBoard, now_s: float, *shown: Mark, withdrawn: Sequence[str] = ()) -> list[str]:
    events = board.due(Scene(shown, tuple(withdrawn)), now_s, UTC_S)
    return [parsed(event).get("uid", "") for event in events]


def test_vehicles_are_sent_once_a_second_and_others_when_they_change_and_now_and_then() -> None:
    board = MarkBoard()
    vehicle, area = mark("v", is_live=True), mark("a")
    times = [(number / 4, uid) for number in range(100) for uid in due(board, number / 4, vehicle, area)]
    assert [time_s for time_s, uid in times if uid == "v"] == [float(second) for second in range(25)]
    assert [time_s for time_s, uid in times if uid == "a"] == [0.0, 20.0]
    assert due(board, 25.0, mark("a", north_deg=49.0)) == ["a"]


def test_what_is_gone_is_deleted_three_times_but_vehicles_become_stale() -> None:
    board = MarkBoard()
    due(board, 0.0, mark("f"), mark("v", is_live=True))
    told = [uid for second in range(1, 60) for uid in due(board, float(second))]
    assert told == ["f.delete"] * DELETIONS


def test_a_new_connection_is_told_everything_that_it_may_have_missed() -> None:
    board = MarkBoard()
    due(board, 0.0, mark("a"), mark("f"))
    for second in range(30):
        due(board, float(second), mark("a"), withdrawn=["f"])
    board.start_over()
    assert due(board, 31.0, mark("a"), withdrawn=["f"]) == ["f.delete", "a"]


def test_a_finding_that_was_rejected_by_mistake_comes_back() -> None:
    board = MarkBoard()
    due(board, 0.0, mark("f"))
    assert due(board, 1.0, withdrawn=["f"]) == ["f.delete"]
    assert due(board, 2.0, mark("f")) == ["f"]
    assert due(board, 30.0, mark("f")) == ["f"]


# --- answers ----------------------------------------------------------------------------------------------------------


def pongs(stream: EventSplitter, data: bytes) -> list[float]:
    """Return the times of the answers to pings in further bytes of a stream."""
    found = []
    for event in stream.feed(data):
        with suppress(InputDataError):
            found.append(pong_utc_s(parse_event(event)))
    return [utc_s for utc_s in found if utc_s is not None]


@given(st.lists(st.sampled_from([PONG, b"\n", b'<event uid="x" type="a-f"><point/></event>']), max_size=8), st.data())
def test_answers_are_found_however_the_stream_is_cut(parts: list[bytes], data: st.DataObject) -> None:
    stream, splitter = b"".join(parts), EventSplitter()
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=5)))
    pieces = [stream[a:b] for a, b in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    assert [found for piece in pieces for found in pongs(splitter, piece)] == [PONG_UTC_S] * parts.count(PONG)


@pytest.mark.parametrize(
    "hostile",
    [
        b'<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><event type="t-x-c-t-r" time="&b;"></event>',
        b'<event type="t-x-c-t-r" time="tomorrow"></event>',
        b'<event type="t-x-c-t-r" <<<</event>',
        b"t-x-c-t-r</event>",
    ],
)
def test_hostile_answers_say_nothing(hostile: bytes) -> None:
    assert pongs(EventSplitter(), hostile) == []


def test_an_event_without_an_end_is_not_kept() -> None:
    splitter = EventSplitter()
    for _ in range(100):
        splitter.feed(b"x" * 10_000)
    assert len(splitter._buffer) <= 65_536
    assert pongs(splitter, b"</event>" + PONG) == [PONG_UTC_S]


# --- settings ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ({"url": "http://host:80"}, "url must begin with"),
        ({"url": "tcp://host"}, "needs a port"),
        ({"url": "tcp://host:99999"}, "needs a port"),
        ({"url": "tcp://:8087"}, "no host"),
        ({"url": "tls://host:8089"}, "ca_file"),
        ({"url": "tls://host:8089", "ca_file": "ca.pem", "key_file": "k.pem"}, "together"),
        ({"url": "tcp://host:8087", "ca_file": "ca.pem"}, "ca_file is for tls"),
        ({"url": "tcp://host:8087", "interface": "10.0.0.1"}, "interface is for udp"),
        ({"url": "tcp://host:8087", "name": "a<b"}, "name must"),
        ({"url": "udp://10.0.0.5:6969", "receive": True}, "receive needs an IPv4 multicast group"),
        ({"url": "udp://host:6969", "receive": True}, "receive needs an IPv4 multicast group"),
    ],
)
def test_settings_that_cannot_work_are_refused(fields: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigurationError, match=text):
        TakSettings(**fields)  # type: ignore[arg-type]
