"""Findings whose places come together as the evidence grows: one is left, and the other points to it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from aos_gcs.errors import MissionError
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.findings import Finding, FindingChange, FindingStatus, TargetEstimate
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.same_body import distinct


def person(track_id: int, east_m: float, *, kind: FindingKind = FindingKind.PERSON) -> TargetEstimate:
    return TargetEstimate((east_m, 5.0, 0.0), 0.1, 4, track_id, seen_at_s=10.0, kind=kind, person_confidence=0.9)


class Search:
    """Findings of a search in which two targets come together, seen in each step."""

    def __init__(self) -> None:
        self.findings = Findings()
        self.step = 0

    def see(self, *targets: TargetEstimate) -> tuple[Finding, ...]:
        """Return the findings that are merged by a step, or no longer merged."""
        self.step += 1
        seen = [replace(target, seen_at_s=10.0 + self.step) for target in targets]
        self.findings.observe(seen, self.step, 10.0 + self.step)
        return self.findings.merge(seen)

    def judge(self, finding_id: int, status: FindingStatus) -> None:
        self.findings.change(finding_id, FindingChange(status, comment=f"comment {finding_id}"), "Ann")

    def merged(self) -> list[int | None]:
        return [finding.merged_into for finding in self.findings.all()]

    def persons(self) -> list[int]:
        return [finding.finding_id for finding in self.findings.persons()]


@pytest.fixture
def search() -> Search:
    search = Search()
    assert search.see(person(1, 0.0), person(2, 4.0)) == ()
    assert search.persons() == [1, 2]
    return search


def test_findings_that_come_together_are_one_and_the_later_points_to_the_earlier(search: Search) -> None:
    (later,) = search.see(person(1, 0.0), person(2, 1.2))
    assert (later.finding_id, later.merged_into) == (2, 1)
    assert search.persons() == [1]
    assert search.see(person(1, 0.0), person(2, 1.6)) == ()
    assert search.merged() == [None, 1]


def test_the_one_that_is_left_keeps_what_is_known_of_the_other(search: Search) -> None:
    search = Search()
    search.see(person(1, 0.0, kind=FindingKind.UNDECIDED), person(2, 4.0))
    search.see(person(1, 0.0, kind=FindingKind.UNDECIDED), person(2, 1.2))
    assert search.findings.all()[0].kind is FindingKind.PERSON
    search.see(person(2, 1.3))  # the first target is lost
    first, second = search.findings.all()
    assert (first.step, first.seen_at_s, second.position_enu_m[0]) == (3, 13.0, 1.3)
    assert search.findings.at(person(2, 1.3), FindingStatus.NEW) == first


def test_the_one_that_is_left_stands_where_the_better_known_does(search: Search) -> None:
    drifted = replace(person(1, 0.0), position_enu_m=(1.0, 2.9, 0.0), sigma_m=3.0)
    search.see(drifted, person(2, 0.0))
    assert search.merged() == [None, 1]
    first, second = search.findings.all()
    assert first.position_enu_m == second.position_enu_m == (0.0, 5.0, 0.0)
    assert first.sigma_m == 0.1
    search.see(drifted, person(2, 0.1))
    assert search.findings.all()[0].position_enu_m == (0.1, 5.0, 0.0)
    assert search.persons() == [1]


def test_an_older_place_does_not_hold_back_a_person_who_walks_on(search: Search) -> None:
    def walking(east_m: float) -> TargetEstimate:
        return replace(person(1, east_m), sigma_m=0.3)

    search.see(walking(0.0), person(2, 0.0))
    lost = replace(person(2, 0.0), seen_at_s=12.0)
    for step in range(30):
        search.findings.observe([replace(walking(0.05 * step), seen_at_s=12.5 + step), lost], 3 + step, 12.5 + step)
        search.findings.merge([walking(0.05 * step), lost])
    assert search.findings.all()[0].position_enu_m[0] == pytest.approx(0.05 * 29)


def test_two_that_part_again_are_two(search: Search) -> None:
    search.see(person(1, 0.0), person(2, 1.2))
    (later,) = search.see(person(1, 0.0), person(2, 2.2))
    assert (later.finding_id, later.merged_into) == (2, None)
    assert search.persons() == [1, 2]


def test_a_confirmation_survives_and_operators_have_the_last_word(search: Search) -> None:
    search.judge(2, FindingStatus.CONFIRMED)
    search.see(person(1, 0.0), person(2, 1.2))
    first, second = search.findings.all()
    assert (first.status, first.operator, first.comment) == (FindingStatus.CONFIRMED, "Ann", "comment 2")
    assert second.status is FindingStatus.CONFIRMED
    search.judge(1, FindingStatus.REJECTED)
    search.see(person(1, 0.0), person(2, 1.2))
    assert search.findings.all()[0].status is FindingStatus.REJECTED
    assert search.persons() == []


@pytest.mark.parametrize(
    ("first", "second", "persons"),
    [
        (FindingStatus.REJECTED, FindingStatus.NEW, [2]),
        (FindingStatus.NEW, FindingStatus.REJECTED, [1]),
        (FindingStatus.CONFIRMED, FindingStatus.CONFIRMED, [1, 2]),
    ],
)
def test_what_operators_have_rejected_or_confirmed_both_is_left_alone(
    search: Search, first: FindingStatus, second: FindingStatus, persons: list[int]
) -> None:
    search.judge(1, first)
    search.judge(2, second)
    assert search.see(person(1, 0.0), person(2, 1.2)) == ()
    assert search.persons() == persons


def test_a_person_beside_something_else_and_a_place_marked_by_hand_stay_apart(search: Search) -> None:
    search.findings.add((0.2, 5.0, 0.0), "a jacket", "Ann", 1, 11.0)
    assert search.see(person(1, 0.0), person(2, 4.0)) == ()
    search = Search()
    search.see(person(1, 0.0), person(2, 4.0, kind=FindingKind.WARM_OBJECT))
    assert search.see(person(1, 0.0), person(2, 0.3, kind=FindingKind.WARM_OBJECT)) == ()


def test_of_three_all_point_to_the_first(search: Search) -> None:
    search.see(person(1, 0.0), person(2, 4.0), person(3, 8.0))
    search.see(person(1, 0.0), person(2, 4.0), person(3, 5.2))
    assert search.merged() == [None, None, 2]
    search.see(person(1, 0.0), person(2, 1.0), person(3, 1.4))
    assert search.merged() == [None, 1, 1]


def test_a_merged_finding_is_judged_by_the_one_that_it_points_to(search: Search) -> None:
    search.see(person(1, 0.0), person(2, 1.2))
    with pytest.raises(MissionError, match="the same as finding 1: judge finding 1"):
        search.judge(2, FindingStatus.REJECTED)
    search.findings.change(2, FindingChange(comment="waves"), "Ann")
    assert search.findings.all()[1].comment == "waves"


def test_pieces_of_one_body_are_shown_as_one_target_and_the_target_itself_stays() -> None:
    first, piece, other = person(1, 10.0), person(2, 10.3), person(3, 12.0)
    assert distinct((first, piece, other), piece) == (piece, other)
    assert distinct((first, piece, other), None) == (first, other)
    assert distinct((), None) == ()
