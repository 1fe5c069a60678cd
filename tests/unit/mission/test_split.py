"""Vehicles that look closely and the group that scans on, what stops that group, and what is flown again afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.airspace.plans import TrafficSituation
from aos_gcs.errors import ConfigurationError
from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.decisions import Group, Situation, SwarmPlace
from aos_gcs.mission.model.phase import Phase
from aos_gcs.mission.search.decisions.decider import Decider
from aos_gcs.mission.search.decisions.split import Split, begin_split, places_of_both
from aos_gcs.mission.search.scan.progress import ScanProgress
from aos_gcs.mission.search.targets.claims import Claims
from aos_gcs.mission.search.targets.findings import Findings
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.search_settings import SearchMode, SearchSettings
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.ports import Severity
from tests.fakes.notices import Notices
from tests.fakes.target_sightings import analysis, seen

LINE_M = 4.2
TARGET = (10.0, 20.0, 0.0)
AREA = ((-30.0, 0.0), (30.0, 0.0), (30.0, 200.0), (-30.0, 200.0))


@dataclass
class Heard:
    """Journal that keeps its notices."""

    notices: list[str] = field(default_factory=list)

    def elapsed_s(self) -> float:
        return 0.0

    def notice(self, severity: Severity, text: str, *_: object) -> None:
        assert severity in {Severity.INFO, Severity.NEWS}
        self.notices.append(text)


def settings(n: int, **search: object) -> MissionSettings:
    chosen = SearchSettings(**({"split": True} | search))
    return MissionSettings(vehicles=n, area_enu_m=AREA, imaging=ImagingSettings(), search=chosen)


def in_line(n: int) -> Situation:
    """Vehicles 1, 2, … from west to east about the origin."""
    places = [
        SwarmPlace(one + 1, ((one - (n - 1) / 2) * LINE_M, 20.0, 35.0 + 2 * one), 35.0 + 2 * one) for one in range(n)
    ]
    return Situation(0.0, tuple(places), TrafficSituation(limits=UNLIMITED, arrival_radius_m=0.5))


def on_leg() -> ScanProgress:
    """20 m along the first one of three legs."""
    progress = ScanProgress(0.5)
    progress.plan([ScanLeg((20.0 * one, 0.0), (0.0, 1.0), 200.0) for one in range(3)])
    progress.advance(np.array([0.0, 20.0]))
    return progress


def begun(n: int, journal: Heard | None = None, leader_id: int | None = None, **search: object) -> Split | None:
    line_m = float(search.get("line_spacing_m", LINE_M))  # type: ignore[arg-type]
    return begin_split(
        settings(n, **search),
        in_line(n),
        TARGET,
        leader_id,
        line_m=line_m,
        progress=on_leg(),
        journal=journal or Heard(),
    )


def test_the_nearest_look_and_the_leader_among_them() -> None:
    split, led = begun(10), begun(10, leader_id=1)
    assert split is not None
    assert led is not None
    assert split.look_ids == {6, 7, 8, 9, 10}
    assert led.look_ids == {1, 6, 7, 8, 9}


def test_the_others_form_a_line_as_wide_as_that_of_all_where_the_leg_was_left() -> None:
    split, progress = begun(10), ScanProgress(0.5)
    assert split is not None
    progress.plan([ScanLeg((0.0, 0.0), (0.0, 1.0), 200.0)])
    progress.advance(np.array([0.0, 20.0]))
    looking_m = np.full((5, 2), 7.0)
    places_m = places_of_both(split, progress, in_line(10), looking_m)
    assert places_m[5:] == pytest.approx(looking_m)
    assert places_m[:5, 1] == pytest.approx([20.0] * 5)
    assert np.sort(places_m[:5, 0]) == pytest.approx(np.linspace(-4.5, 4.5, 5) * LINE_M)


@pytest.mark.parametrize(
    ("n", "search"),
    [(7, {}), (8, {"mode": SearchMode.STOPS}), (10, {"split": False}), (10, {"look_vehicles": 8})],
)
def test_with_too_few_or_without_a_sweep_all_look(n: int, search: dict[str, object]) -> None:
    assert begun(n, **search) is None


def test_no_line_is_wider_than_its_cameras_see() -> None:
    heard = Heard()
    assert begun(10, heard, line_spacing_m=12.0) is not None
    assert begun(10, heard, line_spacing_m=14.0) is None
    assert heard.notices[-1] == (
        "All vehicles look closely: the others would be 32 m apart in the line, too far to see all"
    )


def look(split: Split, others: Sequence[tuple[float, float]] = ()) -> None:
    step = analysis(seen(*TARGET[:2]), *(seen(*place) for place in others))
    split.note_look(step, [TARGET[:2]], [(0.0, 0.0)])


def test_what_is_looked_at_and_what_is_settled_do_not_stop_those_who_scan() -> None:
    split = begun(10)
    assert split is not None
    look(split)
    split.note_look(analysis(), [(11.0, 21.0)], [(0.0, 0.0), (5.0, 5.0)])
    assert split.passed_enu_m == ((0.0, 0.0), (5.0, 5.0), (10.0, 20.0), (11.0, 21.0))


def test_what_else_the_look_sees_is_not_passed_by() -> None:
    split = begun(10)
    assert split is not None
    look(split, [(12.0, 21.0)])
    assert not split.leaves_something([])
    look(split, [(18.0, 20.0)])
    assert split.leaves_something([TARGET[:2]])
    assert not split.leaves_something([TARGET[:2], (17.0, 20.0)])


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (analysis(seen(4.0, 60.0, area_m2=0.06)), "something is in view at 4.0 m east, 60.0 m north"),
        (analysis(), "the line cannot sweep on"),
    ],
)
def test_those_who_scan_stop_once_for_good_and_say_why(step: object, reason: str) -> None:
    heard, progress = Heard(), ScanProgress(0.5)
    split = begun(10, heard)
    assert split is not None
    progress.plan([ScanLeg((0.0, 0.0), (0.0, 1.0), 200.0)])
    for _ in range(2):
        assert not split.scan_on(progress, in_line(10), step, lambda _: ())  # type: ignore[arg-type]
        assert split.is_over
    assert heard.notices[1:] == [f"The vehicles that scan on stop and wait for the close look: {reason}"]


def test_something_settled_or_small_does_not_stop_them() -> None:
    heard, progress = Heard(), ScanProgress(0.5)
    split = begun(10, heard)
    assert split is not None
    progress.plan([ScanLeg((0.0, 0.0), (0.0, 1.0), 200.0)])
    step = analysis(seen(4.0, 60.0, area_m2=0.04), replace(seen(8.0, 60.0), settled=True))
    split.scan_on(progress, in_line(10), step, lambda _: ())
    assert "in view" not in heard.notices[-1]


def decider_with(split: Split) -> Decider:
    """A decider of ten vehicles whose look has no target left, with a split on the first of three legs."""
    decider = Decider(settings(10), Heard(), Findings(), forget=lambda: None, covered_fraction=lambda: None)
    decider.progress.plan(on_leg().legs)
    decider.progress.advance(np.array([0.0, 60.0]))
    decider.split = split
    return decider


def place_of(decider: Decider) -> tuple[int, float]:
    return decider.progress.leg, decider.progress.along_m


def scan_on(decider: Decider) -> Phase:
    traffic = in_line(10)
    step = analysis(seen(4.0, 60.0, area_m2=0.06))
    return decider.decide(Phase.SCAN, traffic, traffic.traffic.detours(), step, group=Group.SCAN).following


def test_a_look_that_is_over_at_the_end_of_the_leg_begins_the_next_one_once_however_often_its_step_is_made() -> None:
    split = begun(10)
    assert split is not None
    decider = decider_with(split)
    split.is_over = split.is_at_end = True
    for _ in range(3):
        assert decider.conclude(Phase.CONVERGE, {}) is Phase.LINE
        assert place_of(decider) == (1, 0.0)


def test_those_who_scan_begin_the_next_leg_once_behind_a_look_that_is_over() -> None:
    split = begun(10)
    assert split is not None
    decider = decider_with(split)
    split.is_over = split.is_at_end = split.is_catching_up = True
    for _ in range(3):
        assert scan_on(decider) is Phase.LINE
        assert place_of(decider) == (1, 0.0)
    decider.progress.take_up(decider.progress.legs[:1], 0)
    for _ in range(3):
        assert scan_on(decider) is Phase.RETURN
        assert decider.progress.is_over


def test_a_person_announced_while_a_look_ends_is_looked_at_before_the_next_leg(monkeypatch: pytest.MonkeyPatch) -> None:
    split = begun(10)
    assert split is not None
    decider = decider_with(split)
    split.is_over = split.is_at_end = True
    assert decider.conclude(Phase.CONVERGE, {}) is Phase.LINE
    monkeypatch.setattr(Claims, "announce", lambda *_, **__: 7)
    assert decider.conclude(Phase.LINE, {}) is Phase.FOUND
    assert place_of(decider) == (0, 200.0)
    assert not split.is_catching_up
    monkeypatch.setattr(Claims, "announce", lambda *_, **__: None)
    assert decider.conclude(Phase.CONVERGE, {}) is Phase.LINE
    assert place_of(decider) == (1, 0.0)


def test_what_a_look_leaves_is_flown_again_although_the_others_are_at_the_end_of_the_leg() -> None:
    split = begun(10)
    assert split is not None
    decider = decider_with(split)
    split.is_over = split.is_at_end = True
    look(split, [(18.0, 20.0)])
    for _ in range(2):
        assert decider.conclude(Phase.CONVERGE, {}) is Phase.LINE
        assert place_of(decider) == (0, 20.0)
        # The next look sees nothing more, and the ground between is still to be flown over.
        split.note_look(analysis(), [], [])


def test_a_split_that_ends_with_too_few_lookers_loses_no_ground_where_the_next_leg_was_begun() -> None:
    split = begun(10)
    assert split is not None
    decider = decider_with(split)
    split.is_over = split.is_at_end = True
    assert decider.conclude(Phase.CONVERGE, {}) is Phase.LINE
    traffic = in_line(10)
    decider.decide(Phase.FOUND, traffic, traffic.traffic.detours(), analysis())
    assert decider.split is None
    assert place_of(decider) == (0, 20.0)


@pytest.mark.parametrize(
    ("kind", "following"), [(FindingKind.UNDECIDED, Phase.CONVERGE), (FindingKind.PERSON, Phase.LINE)]
)
def test_what_comes_into_view_beside_a_watched_person_gets_a_look_of_its_own(
    kind: FindingKind, following: Phase
) -> None:
    """A stump that was seen in three steps of watching a person was announced with 72 %, and left with 4 %."""
    decider = Decider(settings(10), Heard(), Findings(), forget=lambda: None, covered_fraction=lambda: None)
    decider.progress.plan(on_leg().legs)
    traffic = in_line(10)
    for _ in range(settings(10).detection.hold_steps + 1):
        phase = decider.decide(Phase.FOUND, traffic, traffic.traffic.detours(), analysis(seen(8.0, 60.0))).following
        decider.tracker.settle(1, kind)
    assert [target.track_id for target in decider.tracker.estimates()] == [1]
    assert phase is following


@pytest.mark.parametrize(("probability", "is_announced"), [(0.7, True), (0.5, False)])
def test_a_person_whose_look_the_end_of_the_search_cuts_short_is_announced(
    probability: float, is_announced: bool
) -> None:
    heard = Notices()
    decider = Decider(settings(10), heard, Findings(), forget=lambda: None, covered_fraction=lambda: None)
    decider.progress.plan(on_leg().legs)
    judgement, phase = Judgement(Verdict(FindingKind.PERSON, probability, ())), Phase.CONVERGE
    over_s = settings(10).deadlines.search_s
    for now_s in (over_s - 8.0, over_s - 6.0, over_s - 4.0, over_s - 2.0, over_s + 1.0):
        traffic = replace(in_line(10), now_s=now_s)
        phase = decider.decide(Phase.CONVERGE, traffic, traffic.traffic.detours(), analysis(seen(8.0, 60.0))).following
        decider.conclude(phase, dict.fromkeys(decider.tracker.places_enu_m(), judgement))
    assert phase is Phase.RETURN
    assert any(text.startswith("Possible person (78 %)") for text in heard.texts) is is_announced


@pytest.mark.parametrize("looking", [1, 101])
def test_a_look_of_one_or_of_too_many_is_refused(looking: int) -> None:
    with pytest.raises(ConfigurationError, match="look_vehicles must lie within 2 and 100"):
        SearchSettings(split=True, look_vehicles=looking)
