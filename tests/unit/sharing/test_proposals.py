"""What comes from TAK: marks and drawings become proposals, and nothing that strangers send becomes anything else."""

from __future__ import annotations

import math
from dataclasses import replace
from datetime import UTC, datetime
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.bridge.messages import SHARING_REQUESTS, pack, unpack
from aos_gcs.errors import InputDataError, MissionError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.mission.model.proposals import MAX_PROPOSALS, Proposal, ProposalShape, ProposalUse
from aos_gcs.mission.proposals import KEPT_S, MAX_KEPT_S, Proposals
from aos_gcs.ports import Notice
from aos_gcs.sharing.channel import ProposalChanges
from aos_gcs.sharing.tak.inbox import EVENTS_BURST, Inbox
from aos_gcs.sharing.tak.incoming import EventSplitter, parse_event
from aos_gcs.sharing.tak.marks import Withdrawal, read_mark
from aos_gcs.sharing.watch import PROPOSALS_S, ProposalWatch
from tests.fakes.sharing import UTC_S

SQUARE = ((48.0, 15.0), (48.0, 15.01), (48.01, 15.01), (48.01, 15.0))


def clock(ahead_s: float) -> str:
    return datetime.fromtimestamp(UTC_S + ahead_s, UTC).isoformat().replace("+00:00", "Z")


def event(
    kind: str = "b-m-p-s-m",
    detail: str = "",
    *,
    uid: str = "mark-1",
    how: str = "h-g-i-g-o",
    lat: str = "48.0",
    lon: str = "15.0",
    hae: str = "345.0",
    stale: str | None = None,
    callsign: str = "LKP",
) -> bytes:
    stale = clock(300.0) if stale is None else stale
    times = f"time='{clock(-5.0)}' start='{clock(-5.0)}' stale={quoteattr(stale)}"
    point = f"<point lat='{lat}' lon='{lon}' hae='{hae}' ce='9999999.0' le='9999999.0'/>"
    contact = f"<contact callsign={quoteattr(callsign)}/>"
    return (
        f"<event version='2.0' uid={quoteattr(uid)} type='{kind}' how='{how}' {times}>{point}"
        f"<detail>{contact}{detail}</detail></event>"
    ).encode()


def links(*points: tuple[float, float]) -> str:
    return "".join(f"<link point='{latitude},{longitude}'/>" for latitude, longitude in points)


def read(text: bytes, undulation_m: float | None = 45.0) -> Proposal | Withdrawal | None:
    geoid = None if undulation_m is None else lambda _latitude_deg, _longitude_deg: undulation_m
    return read_mark(parse_event(text), geoid, UTC_S)


def proposed(text: bytes) -> Proposal:
    found = read(text)
    assert isinstance(found, Proposal)
    return found


# --- marks and drawings -----------------------------------------------------------------------------------------------


def test_a_mark_has_its_sender_its_times_and_its_altitude_above_the_sea() -> None:
    detail = "<remarks>seen   here\nat noon</remarks><creator callsign='EAGLE 1' uid='x'/>"
    found = proposed(event(detail=detail))
    assert (found.name, found.sender, found.remarks, found.kind) == ("LKP", "EAGLE 1", "seen here at noon", "b-m-p-s-m")
    assert (found.shape, found.points_deg) == (ProposalShape.POINT, ((48.0, 15.0),))
    assert found.altitude_amsl_m == 345.0 - 45.0
    assert (found.sent_utc_s, found.stale_utc_s, found.received_utc_s) == (UTC_S - 5.0, UTC_S + 300.0, UTC_S)


@pytest.mark.parametrize(("hae", "undulation_m"), [("9999999.0", 45.0), ("345.0", None), ("5e8", 45.0)])
def test_heights_that_are_not_known_become_no_altitudes(hae: str, undulation_m: float | None) -> None:
    found = read(event(hae=hae), undulation_m)
    assert isinstance(found, Proposal)
    assert found.altitude_amsl_m is None


@pytest.mark.parametrize(
    ("kind", "detail", "shape", "points"),
    [
        ("u-d-f", links(*SQUARE, SQUARE[0]), ProposalShape.AREA, SQUARE),
        ("u-d-f", links(*SQUARE), ProposalShape.LINE, SQUARE),
        ("u-d-r", links(*SQUARE), ProposalShape.AREA, SQUARE),
        ("b-m-r", links(*SQUARE, SQUARE[0]), ProposalShape.LINE, (*SQUARE, SQUARE[0])),
        (
            "u-d-p",
            "<shape><polyline closed='true'>"
            + "".join(f"<vertex lat='{latitude}' lon='{longitude}'/>" for latitude, longitude in SQUARE)
            + "</polyline></shape>",
            ProposalShape.AREA,
            SQUARE,
        ),
    ],
)
def test_drawings_have_their_corners(
    kind: str, detail: str, shape: ProposalShape, points: tuple[tuple[float, float], ...]
) -> None:
    found = proposed(event(kind, detail))
    assert (found.shape, found.points_deg) == (shape, points)


@given(
    major_m=st.floats(1.0, 5000.0),
    ratio=st.floats(0.2, 1.0),
    angle_deg=st.floats(0.0, 360.0),
    latitude_deg=st.floats(-75.0, 75.0),
)
def test_the_polygon_of_a_circle_holds_all_of_it(
    major_m: float, ratio: float, angle_deg: float, latitude_deg: float
) -> None:
    minor_m = ratio * major_m
    detail = f"<shape><ellipse major='{major_m}' minor='{minor_m}' angle='{angle_deg}'/></shape>"
    found = proposed(event("u-d-c-c", detail, lat=repr(latitude_deg)))
    assert found.shape is ProposalShape.AREA
    frame = LocalFrame(GeodeticPosition(latitude_deg, 15.0, 0.0))
    heading_rad = math.radians(angle_deg)
    for one in found.points_deg:
        east_m, north_m, _ = map(float, frame.to_enu(GeodeticPosition(*one, 0.0)))
        along_m = east_m * math.sin(heading_rad) + north_m * math.cos(heading_rad)
        across_m = east_m * math.cos(heading_rad) - north_m * math.sin(heading_rad)
        # Corners stand off the ellipse by the secant of half the angle between them; degrees are rounded to 1 cm.
        assert math.hypot(along_m / major_m, across_m / minor_m) == pytest.approx(1.00484, abs=0.001 + 0.02 / minor_m)


@pytest.mark.parametrize(
    "text",
    [
        event("a-f-G-U-C", how="m-g"),
        event("a-f-G-U-C", "<takv platform='ATAK'/>"),
        event("u-d-f", links(*SQUARE), how="m-g"),
        event("b-m-p-s-p-i"),
        event("b-t-f"),
        event("t-x-c-t"),
    ],
)
def test_what_devices_report_of_themselves_is_not_proposed(text: bytes) -> None:
    assert read(text) is None


def test_a_mark_of_a_symbol_that_a_person_has_set_is_proposed() -> None:
    assert proposed(event("a-u-G")).shape is ProposalShape.POINT


def test_a_deletion_names_what_it_deletes() -> None:
    assert read(event("t-x-d-d", "<link uid='a' relation='none'/><link uid=''/>")) == Withdrawal(("a",))


# --- hostile input ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (event(lat="95"), "LKP: 95, 15 is no latitude and longitude"),
        (event(lat="NaN"), "latitude 'NaN' is no number"),
        (event(lon="1e999"), "longitude '1e999' is no number"),
        (event(lat="0", lon="0"), "it has no place"),
        (event(stale=clock(-1.0)), "it was out of date when it came"),
        (event(stale="tomorrow"), "stale 'tomorrow' is no time"),
        (event(uid=""), "a uid of 0 characters"),
        (event(uid="x" * 500), "a uid of 500 characters"),
        (event("u-d-f", links(*SQUARE * 60)), "it has 240 points; 200 at most"),
        (event("u-d-f", "<link point='48'/><link point='1,2'/>"), "longitude None is no number"),
        (event("u-d-f"), "It has 0 points; 2 to 200 are possible"),
        (event("u-d-c-c", "<shape><ellipse major='1e9' minor='1'/></shape>"), r"a circle of 1e\+09 by 1 m"),
        (event("u-d-c-c", "<shape><ellipse major='5' minor='-1'/></shape>"), "a circle of 5 by -1 m"),
        (b"<!DOCTYPE x [<!ENTITY a 'aa'><!ENTITY b '&a;&a;'>]><event uid='&b;'/>", "declares a document type"),
        (b"<event" + b" " * 70_000 + b"/>", "more than 64 KiB"),
        (b"<a/>", "XML that is no event"),
        (b"<event><<</event>", "an event that is no XML"),
    ],
)
def test_what_cannot_be_is_named_and_not_proposed(text: bytes, reason: str) -> None:
    with pytest.raises(InputDataError, match=reason):
        read(text)


def test_texts_are_short_and_on_one_line_and_have_no_control_characters() -> None:
    found = proposed(event(callsign="a\n\u202eb<b>" + "x" * 500, detail=f"<remarks>{'y ' * 5000}</remarks>"))
    assert found.name.startswith("a \\u202eb<b>xxx")
    assert (len(found.name), len(found.remarks)) == (80, 300)


@given(st.data())
def test_no_bytes_make_the_inbox_fail_or_grow(data: st.DataObject) -> None:
    box, splitter = inbox(), EventSplitter()
    good = data.draw(st.sampled_from([event(), event("u-d-f", links(*SQUARE, SQUARE[0])), event("t-x-d-d")]))
    cut = data.draw(st.integers(0, len(good)))
    noise = data.draw(st.binary(max_size=40) | st.text("<>&;/'\" =0eE-.", max_size=40).map(str.encode))
    for one in splitter.feed(good[:cut] + noise + good[cut:]):
        try:
            box.take(parse_event(one))
        except InputDataError as error:
            box.refuse(str(error))
    changes = box.changes()
    for one in changes.proposals:
        assert unpack(pack("proposals", "TAK", (one,), ())[4:], SHARING_REQUESTS)[1] == ("TAK", (one,), ())


# --- on the way -------------------------------------------------------------------------------------------------------


def inbox() -> Inbox:
    return Inbox("AOS", None, lambda: 0.0, lambda: UTC_S)


def test_the_own_echo_is_ignored_and_what_is_refused_is_counted_with_its_reason() -> None:
    box = inbox()
    for one in (event(uid="AOS.area"), event(uid="a"), event(uid="b", lat="99")):
        box.take(parse_event(one))
    changes = box.changes()
    assert [one.uid for one in changes.proposals] == ["a"]
    assert (box.received, box.refused, box.reason) == (1, 1, "LKP: 99, 15 is no latitude and longitude")
    assert box.changes() == ProposalChanges("TAK")


def test_a_flood_is_left_out_and_counted() -> None:
    box = inbox()
    admitted = [number for number in range(1000) if box.admits(event())]
    for number in admitted:
        box.take(parse_event(event(uid=f"mark-{number}")))
    assert len(admitted) == EVENTS_BURST
    assert len(box.changes().proposals) == MAX_PROPOSALS
    assert box.refused == 1000 - MAX_PROPOSALS


def test_what_devices_report_takes_nothing_of_the_rate() -> None:
    box = inbox()
    assert not any(box.admits(event("a-f-A-M-H-Q", how="m-g")) for _ in range(1000))
    assert box.refused == 0
    assert box.admits(event())
    assert box.admits(event("t-x-d-d", how="m-g"))


def test_a_mark_that_is_deleted_on_the_way_does_not_arrive() -> None:
    box = inbox()
    for one in (event(uid="a"), event(uid="b"), event("t-x-d-d", "<link uid='a'/>", uid="d")):
        box.take(parse_event(one))
    assert [one.uid for one in box.changes().proposals] == ["b"]


@pytest.mark.parametrize(
    "changes",
    [{"name": "x" * 100}, {"points_deg": ((98.0, 15.0),)}, {"shape": ProposalShape.AREA}, {"stale_utc_s": math.inf}],
)
def test_proposals_beyond_their_bounds_are_not_kept(changes: dict[str, object]) -> None:
    desk = Proposals()
    (crossed,) = unpack(pack("proposals", "TAK", (proposal("a", **changes),), ())[4:], SHARING_REQUESTS)[1][1]
    assert desk.take([crossed]) == 0
    assert (desk.all(), desk.refused) == ((), 1)


# --- the mission's side -----------------------------------------------------------------------------------------------


def proposal(uid: str, **changes: object) -> Proposal:
    return replace(proposed(event(uid=uid)), **changes)  # type: ignore[arg-type]


def test_a_decision_holds_while_a_mark_is_repeated_and_ends_when_it_changes() -> None:
    desk = Proposals()
    assert desk.take([proposal("a")]) == 1
    decided = desk.decide(1, ProposalUse.FINDING, "Ada", UTC_S)
    assert (decided.use, decided.operator) == (ProposalUse.FINDING, "Ada")
    assert desk.take([proposal("a", stale_utc_s=UTC_S + 900.0)]) == 0
    with pytest.raises(MissionError, match="Ada has decided"):
        desk.decide(1, ProposalUse.DISMISSED, "Bob", UTC_S)
    assert desk.take([proposal("a", points_deg=((48.0, 16.0),))]) == 1
    (record,) = desk.all()
    assert (record.proposal_id, record.use) == (2, None)
    with pytest.raises(MissionError, match="no proposal 1 any more"):
        desk.decide(1, ProposalUse.DISMISSED, "Bob", UTC_S)


def test_points_are_no_areas_and_lines_become_areas_if_they_have_corners() -> None:
    point = proposal("a")
    line = replace(point, shape=ProposalShape.LINE, points_deg=SQUARE[:2])
    allowed = {one: [use for use in ProposalUse if one.allows(use)] for one in (point, line)}
    assert allowed[point] == [ProposalUse.LAUNCH, ProposalUse.RETURN, ProposalUse.FINDING, ProposalUse.DISMISSED]
    assert allowed[line] == [ProposalUse.DISMISSED]
    assert replace(line, points_deg=SQUARE).allows(ProposalUse.NO_GO)
    desk = Proposals()
    desk.take([point])
    with pytest.raises(MissionError, match="cannot be used as no_go"):
        desk.decide(1, ProposalUse.NO_GO, "Ada", UTC_S)


def test_a_full_desk_gives_up_what_is_decided_and_refuses_the_rest() -> None:
    desk = Proposals()
    assert desk.take([proposal(f"m{number}") for number in range(MAX_PROPOSALS + 2)]) == MAX_PROPOSALS
    assert desk.refused == 2
    desk.decide(5, ProposalUse.DISMISSED, "Ada", UTC_S)
    assert desk.take([proposal("late")]) == 1
    assert len(desk.all()) == MAX_PROPOSALS
    assert 5 not in {record.proposal_id for record in desk.all()}


def test_who_floods_the_desk_takes_no_place_from_others() -> None:
    desk = Proposals()
    desk.take([replace(proposal(f"flood{number}"), sender="LOUD") for number in range(MAX_PROPOSALS)])
    assert desk.take([replace(proposal(f"team{number}"), sender="TEAM") for number in range(3)]) == 3
    waiting = [record.proposal.uid for record in desk.all()]
    assert len(waiting) == MAX_PROPOSALS
    assert waiting[-3:] == ["team0", "team1", "team2"]
    assert waiting[0] == "flood3"
    assert desk.take([replace(proposal("more"), sender="LOUD")]) == 0
    assert desk.refused == 4


def test_proposals_go_when_they_are_deleted_or_long_out_of_date() -> None:
    desk = Proposals()
    desk.take([proposal("a"), proposal("b"), proposal("c", stale_utc_s=UTC_S + 1e9)])
    desk.withdraw("TAK", ["b", "nobody"])
    desk.withdraw("other", ["a"])
    desk.expire(UTC_S + KEPT_S - 1.0)
    assert [record.proposal.uid for record in desk.all()] == ["a", "c"]
    desk.expire(UTC_S + KEPT_S + 1.0)
    assert [record.proposal.uid for record in desk.all()] == ["c"]
    desk.expire(UTC_S + MAX_KEPT_S + 1.0)
    assert desk.all() == ()


def test_a_restart_keeps_what_waits_and_what_was_decided() -> None:
    before, after = Proposals(), Proposals()
    before.take([proposal("a"), proposal("b"), proposal("c")])
    before.decide(2, ProposalUse.DISMISSED, "Ada", UTC_S)
    after.restore(before.all(), UTC_S + 60.0)
    assert after.all() == before.all()
    assert after.take([proposal("b"), proposal("d")]) == 1
    assert [(one.proposal_id, one.proposal.uid) for one in after.all()] == [(1, "a"), (2, "b"), (3, "c"), (4, "d")]
    with pytest.raises(MissionError, match="Ada has decided"):
        after.decide(2, ProposalUse.FINDING, "Bob", UTC_S)


def test_a_restart_leaves_what_has_expired_and_what_no_record_can_hold() -> None:
    before = Proposals()
    before.take([proposal("a"), proposal("b", received_utc_s=UTC_S + KEPT_S)])
    damaged = replace(before.all()[1], proposal=proposal("c", points_deg=((98.0, 15.0),)))
    many = tuple(replace(before.all()[1], proposal=proposal(f"m{number}")) for number in range(2 * MAX_PROPOSALS))
    after = Proposals()
    after.restore((*before.all(), damaged), UTC_S + KEPT_S + 1.0)
    assert [one.proposal.uid for one in after.all()] == ["b"]
    full = Proposals()
    full.restore(many, UTC_S)
    assert len(full.all()) == MAX_PROPOSALS


def test_a_proposal_of_a_clock_that_was_ahead_does_not_stay_for_longer_after_a_restart() -> None:
    before, after = Proposals(), Proposals()
    before.take([proposal("a", received_utc_s=UTC_S + 1e6)])
    after.restore(before.all(), UTC_S)
    after.expire(UTC_S + KEPT_S + 1.0)
    assert after.all() == ()


def test_operators_are_told_of_proposals_once_a_minute_at_most() -> None:
    now_s, notices, desk = [0.0], list[Notice](), Proposals()
    watch = ProposalWatch(desk, notices.append, lambda: now_s[0])
    watch.take("TAK", (proposal("a"), proposal("x", source="other")), ())
    watch.take("TAK", (proposal("b"), proposal("c")), ())
    now_s[0] = PROPOSALS_S
    watch.take("TAK", (proposal("a"),), ("c",))
    watch.take("TAK", (proposal("a"),), ())
    assert [notice.text for notice in notices] == [
        "From TAK: one proposal waits for the plan",
        "From TAK: 2 proposals wait for the plan",
    ]
    assert [record.proposal.uid for record in desk.all()] == ["a", "b"]
