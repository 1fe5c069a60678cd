"""The list of findings: from targets and by hand, judged, written to files, through the API."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from dataclasses import replace
from typing import Any

import httpx
import pytest
from defusedxml import ElementTree

from aos_gcs.api.app import create_app
from aos_gcs.errors import MissionError
from aos_gcs.exports.finding_files import PlacedFinding, to_geojson, to_gpx, to_kml
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition
from aos_gcs.imaging.persons.decision import CLAIMED, FindingKind
from aos_gcs.mission.model.findings import ErrorEllipse, Finding, FindingChange, FindingStatus, TargetEstimate
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.search.targets.findings import MAX_FINDINGS, Findings
from aos_gcs.mission.search.targets.same_body import SAME_PLACE_M
from tests.fakes.app import app_of
from tests.fakes.mission import ScriptedMission
from tests.fakes.recording import HandClock


def target(track_id: int, east_m: float = 0.0, seen_at_s: float = 10.0, *, confirmed: bool = True) -> TargetEstimate:
    return TargetEstimate(
        position_enu_m=(east_m, 5.0, 0.0),
        sigma_m=0.4,
        sightings=4,
        track_id=track_id,
        confirmed=confirmed,
        ellipse=ErrorEllipse(0.5, 0.3, 1.0),
        seen_at_s=seen_at_s,
        person_confidence=0.9,
    )


def test_a_target_becomes_a_finding_once_it_is_confirmed_and_is_followed() -> None:
    findings = Findings()
    assert findings.observe([target(1, confirmed=False)], 1, 10.0) == ()
    assert findings.all() == ()
    (new,) = findings.observe([target(1)], 2, 10.0)
    assert (new.finding_id, new.status, new.step, new.track_id) == (1, FindingStatus.NEW, 2, 1)
    assert findings.observe([target(1, 0.5, 12.0)], 3, 12.0) == ()
    (finding,) = findings.all()
    assert finding.position_enu_m == (0.5, 5.0, 0.0)
    assert (finding.found_at_s, finding.seen_at_s, finding.step) == (10.0, 12.0, 3)


def test_a_finding_stays_with_the_step_that_showed_it_last() -> None:
    findings = Findings()
    findings.observe([target(1, seen_at_s=10.0)], 2, 10.0)
    findings.observe([target(1, seen_at_s=10.0)], 3, 12.0)
    findings.observe([], 4, 14.0)
    assert findings.all()[0].step == 2


def test_a_target_that_is_lost_and_seen_again_stays_one_finding() -> None:
    findings = Findings()
    findings.observe([target(1, 0.0)], 1, 1.0)
    findings.change(1, FindingChange(FindingStatus.CONFIRMED, comment="waves"), "Ann")
    assert findings.observe([target(2, 0.9 * SAME_PLACE_M, 20.0)], 9, 20.0) == ()
    (finding,) = findings.all()
    assert (finding.track_id, finding.status, finding.comment) == (2, FindingStatus.CONFIRMED, "waves")


def test_two_targets_apart_are_two_findings() -> None:
    findings = Findings()
    findings.observe([target(1, 0.0), target(2, 2.5)], 1, 1.0)
    assert [finding.track_id for finding in findings.all()] == [1, 2]


@pytest.mark.parametrize(
    ("kinds", "away_m", "sigma_m", "count"),
    [
        (("undecided", "undecided"), 0.3, 0.4, 1),
        (("undecided", "undecided"), 1.2, 0.4, 1),
        (("person", "person"), 1.2, 0.05, 1),
        (("person", "undecided"), 1.2, 0.05, 1),
        (("person", "person"), 1.8, 0.05, 2),
        (("person", "person"), 1.8, 0.7, 1),
        (("person", "person"), 3.2, 5.0, 2),
        (("person", "warm_object"), 1.2, 0.7, 2),
        (("person", "warm_object"), 0.3, 0.05, 1),
        (("undecided", "person"), 0.3, 0.05, 1),
        (("undecided", "person"), 1.2, 0.05, 1),
        (("warm_object", "person"), 0.3, 0.05, 2),
        (("animal", "anomaly"), 0.3, 0.05, 2),
    ],
)
def test_targets_that_may_be_one_body_are_one_finding(
    kinds: tuple[str, str], away_m: float, sigma_m: float, count: int
) -> None:
    findings = Findings()
    seen = [
        replace(target(number, east_m), sigma_m=sigma_m, kind=FindingKind(kind))
        for number, east_m, kind in ((1, 0.0, kinds[0]), (2, away_m, kinds[1]))
    ]
    for step in (1, 2):
        findings.observe(seen, step, float(step))
        assert len(findings.all()) == count
        assert bool(findings.persons()) == bool(CLAIMED.intersection(kinds)), "what was announced is in the list"


def test_a_second_track_gets_a_finding_once_it_is_something_else() -> None:
    findings, person, other = Findings(), replace(target(1), kind=FindingKind.PERSON), target(2, 1.2)
    assert len(findings.observe([person, other], 1, 1.0)) == 1
    assert findings.claimed_at(other, {1, 2}) is findings.all()[0]
    (new,) = findings.observe([person, replace(other, kind=FindingKind.WARM_OBJECT)], 2, 2.0)
    assert (new.finding_id, new.kind) == (2, FindingKind.WARM_OBJECT)


def test_a_finding_follows_the_track_that_was_announced_and_leaves_its_own_one_alone() -> None:
    """A kind that a finding only takes over would stay with a boar whose track was near a person's for a moment."""
    findings, boar, person = Findings(), target(1), replace(target(2, 1.2), kind=FindingKind.PERSON)
    findings.observe([boar], 1, 1.0)
    findings.observe([boar, person], 2, 2.0)
    person = replace(person, seen_at_s=12.0)
    findings.observe([replace(boar, position_enu_m=(-6.0, 5.0, 0.0), kind=FindingKind.ANIMAL), person], 3, 3.0)
    kinds = {finding.track_id: (finding.kind, finding.position_enu_m[0]) for finding in findings.all()}
    assert kinds == {2: (FindingKind.PERSON, 1.2), 1: (FindingKind.ANIMAL, -6.0)}


def test_what_is_decided_stays_until_there_is_another_decision() -> None:
    findings, stone = Findings(), replace(target(1), kind=FindingKind.WARM_OBJECT, person_confidence=0.1)
    findings.observe([stone], 1, 1.0)
    findings.observe([replace(stone, kind=FindingKind.UNDECIDED, person_confidence=0.4)], 2, 2.0)
    (finding,) = findings.all()
    assert (finding.kind, finding.person_confidence, finding.stands) == (FindingKind.WARM_OBJECT, 0.1, False)
    findings.observe([replace(stone, kind=FindingKind.PERSON, person_confidence=0.8)], 3, 3.0)
    (finding,) = findings.persons()
    assert (finding.kind, finding.person_confidence) == (FindingKind.PERSON, 0.8)
    findings.change(1, FindingChange(FindingStatus.REJECTED), "Ann")
    assert findings.persons() == ()
    findings.change(1, FindingChange(FindingStatus.CONFIRMED), "Ann")
    assert len(findings.persons()) == 1


def test_a_finding_stays_where_its_target_was_seen_last() -> None:
    findings = Findings()
    findings.observe([replace(target(1), seen_at_s=1.0)], 1, 1.0)
    findings.observe([replace(target(1, 40.0), seen_at_s=1.0, sigma_m=9.0)], 2, 30.0)  # out of view, gone on
    (finding,) = findings.all()
    assert (finding.position_enu_m, finding.sigma_m) == (target(1).position_enu_m, target(1).sigma_m)
    findings.observe([replace(target(1, 5.0), seen_at_s=60.0)], 3, 60.0)
    (finding,) = findings.all()
    assert (finding.position_enu_m, finding.step) == (target(1, 5.0).position_enu_m, 3)


def test_a_change_leaves_alone_what_it_does_not_name() -> None:
    findings = Findings()
    findings.add((1.0, 2.0, 0.0), "a jacket", "Ann", 3, 30.0)
    findings.change(1, FindingChange(assignee="Team 2"), "Bob")
    finding = findings.change(1, FindingChange(status=FindingStatus.REJECTED), "Cid")
    assert (finding.comment, finding.assignee, finding.status) == ("a jacket", "Team 2", FindingStatus.REJECTED)
    assert finding.operator == "Cid"
    with pytest.raises(MissionError, match="no finding 2"):
        findings.change(2, FindingChange(), "Ann")


def test_the_list_is_bounded() -> None:
    findings = Findings()
    for number in range(MAX_FINDINGS):
        findings.add((float(number), 0.0, 0.0), "", "", 0, 0.0)
    with pytest.raises(MissionError, match="the most that are kept"):
        findings.add((0.0, 0.0, 0.0), "", "", 0, 0.0)
    assert findings.observe([target(1)], 1, 1.0) == ()
    assert len(findings.all()) == MAX_FINDINGS


def placed() -> list[PlacedFinding]:
    findings = Findings()
    findings.observe([target(1)], 1, 10.0)
    findings.add((1.0, 2.0, 0.0), 'a <red> "jacket" & scarf', "Ann", 1, 11.0)
    return [PlacedFinding(one, GeodeticPosition(47.0, 8.0, 400.0)) for one in findings.all()]


def test_files_hold_longitude_first_where_their_format_says_so_and_no_unknown_values() -> None:
    collection: dict[str, Any] = json.loads(to_geojson(placed()))
    first, second = collection["features"]
    assert first["geometry"] == {"type": "Point", "coordinates": [8.0, 47.0, 400.0]}
    assert first["properties"]["person_confidence"] == 0.9
    assert second["properties"]["comment"] == 'a <red> "jacket" & scarf'
    assert None not in second["properties"].values()
    kml = ElementTree.fromstring(to_kml(placed()))
    space = {"k": "http://www.opengis.net/kml/2.2", "g": "http://www.topografix.com/GPX/1/1"}
    assert [node.text for node in kml.iterfind(".//k:coordinates", space)] == ["8.0,47.0,400.0"] * 2
    gpx = ElementTree.fromstring(to_gpx(placed()))
    points = gpx.findall("g:wpt", space)
    assert [(point.get("lat"), point.get("lon")) for point in points] == [("47.0", "8.0")] * 2
    assert "<red>" in str(points[1].findtext("g:desc", namespaces=space))


def test_files_tell_the_time_by_the_clock_and_who_has_decided() -> None:
    timed = [replace(one, started_utc_s=1_700_000_000.0) for one in placed()]
    first, second = (feature["properties"] for feature in json.loads(to_geojson(timed))["features"])
    assert (first["found_at"], second["found_at"]) == ("2023-11-14T22:13:30Z", "2023-11-14T22:13:31Z")
    assert (first.get("operator"), second["operator"]) == (None, "Ann")
    space = {"k": "http://www.opengis.net/kml/2.2", "g": "http://www.topografix.com/GPX/1/1"}
    whens = ElementTree.fromstring(to_kml(timed)).iterfind(".//k:TimeStamp/k:when", space)
    assert [when.text for when in whens] == [first["seen_at"], second["seen_at"]]
    points = ElementTree.fromstring(to_gpx(timed)).findall("g:wpt", space)
    assert [child.tag.rpartition("}")[2] for child in points[0]] == ["ele", "time", "name", "desc"]
    earlier = replace(timed[0], finding=replace(timed[0].finding, found_in="m0"))
    assert "time" not in to_gpx([earlier])
    assert "found_at" not in {*json.loads(to_geojson([earlier]))["features"][0]["properties"]}


def test_files_can_be_read_whatever_a_comment_holds() -> None:
    """Texts that are pasted from other programs have control characters, which XML has no way to write."""
    findings = Findings()
    findings.add((1.0, 2.0, 0.0), "page 1\x0bpage 2\x00\ufffe \U0001f6a9", "Ann", 1, 11.0)
    (finding,) = findings.all()
    files = [PlacedFinding(finding, GeodeticPosition(47.0, 8.0, 400.0))]
    for write in (to_kml, to_gpx):
        text = "".join(ElementTree.fromstring(write(files)).itertext())
        assert "page 1\ufffdpage 2\ufffd\ufffd \U0001f6a9" in text


class SearchedMission(ScriptedMission):
    """A mission with findings that can be changed."""

    def __init__(self) -> None:
        super().__init__(HandClock())
        self.findings = Findings()
        self.findings.observe([target(1)], 1, 10.0)

    def snapshot(self) -> MissionSnapshot:
        return replace(super().snapshot(), findings=self.findings.all())

    async def add_finding(self, position_enu_m: EnuPoint, comment: str, *, operator: str = "") -> Finding:
        return self.findings.add(position_enu_m, comment, operator, 1, 11.0)

    async def change_finding(self, finding_id: int, change: FindingChange, *, operator: str = "") -> Finding:
        return self.findings.change(finding_id, change, operator)


@pytest.fixture
async def client() -> AsyncIterator[httpx.AsyncClient]:
    mission = SearchedMission()
    app = app_of(mission)
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        yield client


async def test_findings_are_read_judged_and_added_through_the_api(client: httpx.AsyncClient) -> None:
    (finding,) = (await client.get("/api/findings")).json()
    assert finding["status"] == "new"
    assert finding["mgrs"]
    assert finding["ellipse"]["semi_major_m"] == 0.5
    changed = await client.patch("/api/findings/1", json={"status": "confirmed", "comment": "sits", "assignee": "T1"})
    assert changed.json()["status"] == "confirmed"
    assert (await client.get("/api/mission")).json()["findings"] == [changed.json()]
    place = {name: finding["position"][name] for name in ("latitude_deg", "longitude_deg")}
    added = await client.post("/api/findings", json=place | {"comment": "tent"})
    assert added.status_code == 201
    assert added.json()["position"]["east_m"] == pytest.approx(finding["position"]["east_m"], abs=0.02)
    assert added.json()["track_id"] is None


@pytest.mark.parametrize("suffix", ["geojson", "kml", "gpx"])
async def test_findings_can_be_downloaded(client: httpx.AsyncClient, suffix: str) -> None:
    response = await client.get(f"/api/findings.{suffix}")
    assert response.status_code == 200
    assert f'filename="findings.{suffix}"' in response.headers["Content-Disposition"]
    assert "Finding 1" in response.text


@pytest.mark.parametrize(
    ("method", "path", "body", "answer"),
    [
        ("PATCH", "/api/findings/9", {"status": "confirmed"}, (404, "no finding 9")),
        ("PATCH", "/api/findings/1", {"status": "maybe"}, (422, "status")),
        ("PATCH", "/api/findings/1", {"comment": "x" * 2001}, (422, "comment")),
        ("POST", "/api/findings", {"latitude_deg": 91, "longitude_deg": 8}, (422, "latitude_deg")),
        ("POST", "/api/findings", {"latitude_deg": 0, "longitude_deg": 0}, (422, "50 km")),
        ("POST", "/api/findings", {"latitude_deg": 47}, (422, "longitude_deg")),
        ("GET", "/api/findings.doc", None, (422, "suffix")),
        ("GET", "/api/findings/1/integral.png", None, (404, "not recorded")),
    ],
)
async def test_bad_requests_name_what_is_wrong(
    client: httpx.AsyncClient, method: str, path: str, body: dict[str, Any] | None, answer: tuple[int, str]
) -> None:
    status, text = answer
    response = await client.request(method, path, json=body)
    assert response.status_code == status
    assert text in response.json()["message"]


async def test_the_findings_of_a_record_cannot_be_changed() -> None:
    app = create_app(SearchedMission())
    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://localhost") as client:
        assert (await client.patch("/api/findings/1", json={"status": "rejected"})).status_code == 409


def test_who_decides_on_a_finding_is_who_changes_its_status() -> None:
    findings = Findings()
    findings.observe([target(1)], 1, 10.0)
    findings.take_edits()
    described = findings.change(1, FindingChange(comment="under a tree", assignee="team 2"), "Ann")
    assert (described.operator, described.decided_by) == ("", "")
    confirmed = findings.change(1, FindingChange(FindingStatus.CONFIRMED), "Bob")
    assert confirmed.decided_by == "Bob"
    again = findings.change(1, FindingChange(FindingStatus.CONFIRMED, comment="waves"), "Cleo")
    assert (again.comment, again.decided_by) == ("waves", "Bob")
    assert findings.take_edits() == (described, confirmed, again)
    assert findings.change(1, FindingChange(), "Dan") == again
    assert findings.take_edits() == (), "nothing was changed"
    marked = findings.add((9.0, 0.0, 0.0), "shoe", "Ann", 1, 11.0)
    assert (marked.operator, marked.decided_by) == ("Ann", "")


def test_older_records_name_who_has_commented_but_nobody_has_decided() -> None:
    (older,) = Findings().observe([target(1)], 1, 10.0)
    assert replace(older, operator="Ann", comment="under a tree").decided_by == ""
