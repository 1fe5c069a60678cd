"""The study of missions: keys, false convergences, figures, and its folder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.lab.missions.model import MissionKey, MissionResult, MissionsSettings, missing, mission_keys
from aos_gcs.lab.missions.pairs import pair_missions, pairs_as_markdown
from aos_gcs.lab.missions.report import BEGIN_MARK, as_markdown, missions_frame, summarise, write_document
from aos_gcs.lab.missions.store import MISSIONS_FILE, MissionsFolder, reference_missions
from aos_gcs.mission.model.decisions import ConclusionRecord
from aos_gcs.mission.model.findings import Finding, FindingStatus, TargetEstimate
from aos_gcs.mission.model.phase import Phase
from aos_gcs.runtime.simulated.mission_study import false_approaches, judge
from aos_gcs.runtime.simulated.virtual_mission import FlownMission
from tests.fakes.records import snapshot, step_record

PERSON = (0.0, 0.0)
FOUND = MissionResult(
    key=MissionKey(300.0, "cool", "rtk", True, 1),
    persons=1,
    claims=2,
    true_claims=1,
    persons_found=1,
    errors_m=(0.2,),
    claimed_after_s=(90.0,),
    coverage=0.5,
    area_ha=0.4,
    false_convergences=1,
    false_convergence_s=30.0,
    min_separation_m=2.1,
    landed=3,
    outcome="found",
    duration_s=300.0,
    steps=40,
    processor_s=9.0,
)
EMPTY = replace(
    FOUND,
    key=replace(FOUND.key, has_person=False),
    persons=0,
    claims=1,
    true_claims=0,
    persons_found=0,
    errors_m=(),
    claimed_after_s=(),
    min_separation_m=1.9,
    landed=2,
)


def test_every_kind_has_the_same_seeds() -> None:
    keys = mission_keys([300.0, 400.0], ["cool"], ["rtk", "gnss"], 7, with_person=2, without_person=1)
    assert len(keys) == len(set(keys)) == 12
    assert [(key.has_person, key.seed) for key in keys[:3]] == [(True, 7), (True, 8), (False, 7)]
    assert missing(keys, [replace(FOUND, key=keys[0])]) == keys[1:]


@pytest.mark.parametrize(("with_person", "without_person", "seed"), [(0, 0, 0), (-1, 2, 0), (1, 1, -1)])
def test_studies_of_nothing_are_refused(with_person: int, without_person: int, seed: int) -> None:
    with pytest.raises(ConfigurationError, match="--seed, --missions and --no-person"):
        mission_keys([300.0], ["cool"], ["rtk"], seed, with_person=with_person, without_person=without_person)


@pytest.mark.parametrize("values", [{"vehicles": 0}, {"side_m": 5.0}, {"image_size_px": 8}])
def test_settings_out_of_range_name_the_field(values: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(values))):
        MissionsSettings(**values)


def approach(number: int, phase: Phase, place: tuple[float, float] | None) -> object:
    target = None if place is None else (*place, 0.0)
    return replace(step_record(number), phase=phase, target_enu_m=target, elapsed_s=10.0 * number)


def test_convergences_on_what_is_no_person_are_counted_with_their_time() -> None:
    steps = [
        approach(1, Phase.SCAN, None),
        approach(2, Phase.CONVERGE, (20.0, 0.0)),
        approach(3, Phase.CONVERGE, None),  # out of view: the same
        approach(4, Phase.CONVERGE, (21.0, 0.0)),
        approach(5, Phase.CONVERGE, (0.5, 0.0)),  # the person
        approach(6, Phase.CONVERGE, (-20.0, 0.0)),
        approach(7, Phase.CONVERGE, (30.0, 0.0)),
        approach(8, Phase.SCAN, None),
        approach(9, Phase.CONVERGE, (30.0, 0.0)),  # the last step lasts for no time
    ]
    assert false_approaches(steps, lambda _: [PERSON]) == (3, 50.0)
    assert false_approaches(steps, lambda _: []) == (4, 60.0)
    assert false_approaches(steps, lambda after_s: [(0.5, 20.0) if after_s < 60.0 else (-20.0, 0.0)]) == (3, 50.0)


class Walked:
    """Flight past a person who walks east at 1 m/s from the world's beginning on, 60 s before the start."""

    persons_enu_m = ((0.0, 0.0),)
    min_separation_m, min_height_above_ground_m, landed = 4.0, None, 3
    area_enu_m = ((0.0, 0.0), (100.0, 0.0), (100.0, 100.0))

    def persons_at(self, utc_s: float) -> list[tuple[float, float]]:
        return [(utc_s - 940.0, 0.0)]


@pytest.mark.parametrize(("seen_at_s", "is_right"), [(10.0, True), (30.0, False)])
def test_what_is_seen_of_one_who_walks_is_compared_with_where_the_person_was_then(
    seen_at_s: float, is_right: bool
) -> None:
    place = (71.0, 0.0, 0.0)  # where the person was 10 s after the start, but for a metre
    claim = Finding(
        1, FindingStatus.NEW, place, 5.0, seen_at_s, 2, track_id=1, person_confidence=0.9, kind=FindingKind.PERSON
    )
    target = TargetEstimate(place, 0.3, 6, kind=FindingKind.PERSON, seen_at_s=seen_at_s)
    last = replace(snapshot(), started_utc_s=1000.0, findings=(claim,))
    concluded = ConclusionRecord(3, 40.0, True, Phase.FOUND, (target,))
    steps = (
        approach(1, Phase.CONVERGE, place[:2]),
        approach(3, Phase.CONVERGE, place[:2]),
        approach(4, Phase.SCAN, None),
    )
    result = judge(FOUND.key, Walked(), FlownMission(last, steps, {3: concluded}), 1.0)
    assert (result.persons, result.claims, result.true_claims, result.persons_found) == (1, 1, is_right, is_right)
    assert result.errors_m == ((1.0,) if is_right else ())
    assert result.claimed_after_s == ((40.0,) if is_right else ())
    assert result.is_person == (is_right,)
    assert (result.false_convergences, result.persons_noticed) == (1, 1), "the second step looks where nobody is now"


def test_figures_have_their_intervals() -> None:
    (group,) = summarise([FOUND, EMPTY, replace(EMPTY, key=replace(EMPTY.key, seed=2), claims=0)], vehicles=3)
    assert (group.with_person, group.without_person) == (1, 2)
    assert (group.precision.hits, group.precision.trials) == (1, 3)
    assert (group.recall.hits, group.recall.trials) == (1, 1)
    assert group.recall.low == pytest.approx(0.2065, abs=1e-3)  # Wilson
    assert (group.false_per_ha.events, group.false_per_ha.hectares) == (1, pytest.approx(0.4))
    assert group.false_per_ha.low == pytest.approx(0.0253 / 0.4, rel=0.01)  # exact Poisson
    assert group.false_per_ha.high == pytest.approx(5.572 / 0.4, rel=0.01)
    assert group.error_m.value == 0.2
    assert group.coverage.low == group.coverage.high == 0.5
    assert (group.min_separation_m, group.not_landed) == (1.9, 2)
    text = as_markdown([group])
    assert "| 300 | cool | rtk | 1, 2 | 1 of 3: 33 % (6 to 79) | 1 of 1: 100 % (21 to 100) |" in text
    assert "1 in 0.40 ha: 2.50 (0.06 to 13.93) | 0.20 | 90 |" in text


def test_probabilities_are_compared_with_the_truth_where_there_are_enough_findings() -> None:
    honest = replace(FOUND, probabilities=(0.75,) * 16 + (0.0,) * 4, is_person=(True,) * 12 + (False,) * 8)
    boastful = replace(honest, probabilities=(1.0,) * 20)
    (group,) = summarise([honest], vehicles=3)
    assert group.calibration_error == pytest.approx(0.0)
    assert "| 0.000 (n = 20) |" in as_markdown([group])
    (group,) = summarise([boastful], vehicles=3)
    assert group.calibration_error == pytest.approx(0.4)
    (group,) = summarise([replace(honest, probabilities=(0.9,), is_person=(True,))], vehicles=3)
    assert as_markdown([group]).splitlines()[2].endswith("| - |")


def test_nothing_claimed_and_nothing_searched_are_dashes() -> None:
    (group,) = summarise([replace(FOUND, claims=0, persons_found=0, errors_m=(), claimed_after_s=())], vehicles=3)
    assert "| 1, 0 | - | 0 of 1: 0 % (0 to 79) | - | - | - |" in as_markdown([group])


def test_a_study_goes_on_where_it_was_cut(tmp_path: Path) -> None:
    settings = MissionsSettings(vehicles=3)
    folder = MissionsFolder(tmp_path, settings)
    folder.append(FOUND)
    folder.append(EMPTY)
    with (tmp_path / MISSIONS_FILE).open("a", encoding="utf-8") as file:
        file.write('{"key": {"tre')
    folder = MissionsFolder(tmp_path, settings)
    assert folder.results() == [EMPTY, FOUND]
    with pytest.raises(ConfigurationError, match="other settings"):
        MissionsFolder(tmp_path, MissionsSettings(vehicles=4))
    (tmp_path / MISSIONS_FILE).write_text('{"key": {}}\n', encoding="utf-8")
    with pytest.raises(InputDataError, match=r"Line 1 of .* is damaged"):
        folder.results()


def test_the_document_keeps_what_stands_around_the_figures(tmp_path: Path) -> None:
    path = tmp_path / "missions.md"
    groups = summarise([FOUND, EMPTY], vehicles=3)
    write_document(path, missions_frame(path), MissionsSettings(vehicles=3), groups, as_markdown(groups))
    first = path.read_text(encoding="utf-8")
    assert first.startswith(f"# Missions\n\n{BEGIN_MARK}\n\nn = 2 missions of 3 vehicles")
    path.write_text(f"Before\n{first}After\n", encoding="utf-8")
    write_document(path, missions_frame(path), MissionsSettings(vehicles=3), groups, as_markdown(groups))
    text = path.read_text(encoding="utf-8")
    assert text.startswith("Before\n# Missions")
    assert text.endswith("After\n")
    path.write_text("By hand\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match="lacks the lines"):
        missions_frame(path)


def flown(seed: int, *, found: bool, minutes: float) -> MissionResult:
    return replace(
        FOUND,
        key=replace(FOUND.key, seed=seed),
        claims=2 if found else 1,
        true_claims=int(found),
        persons_found=int(found),
        errors_m=(0.2 * seed,) if found else (),
        claimed_after_s=(90.0,) if found else (),
        duration_s=60.0 * minutes,
    )


def test_strategies_are_compared_mission_by_mission() -> None:
    mine = [flown(seed, found=True, minutes=4.0 + seed) for seed in range(1, 7)]
    # Seed 6 was flown by one of them only, and the order does not matter.
    theirs = [flown(seed, found=seed < 4, minutes=5.0 + seed) for seed in (5, 4, 3, 2, 1)]
    figures = {one.title: one for one in pair_missions(mine, theirs)}
    found, duration = figures["persons found, share"], figures["duration, min"]
    assert (found.reference_mean, found.difference.mean, found.difference.count) == (0.6, 0.4, 5)
    assert (duration.reference_mean, duration.difference.mean) == (8.0, -1.0)
    # Where both found the person, three pairs, the errors are the same.
    errors = figures["position error, m, where both find the person"]
    assert (errors.reference_mean, errors.difference.mean, errors.difference.count) == (pytest.approx(0.4), 0.0, 3)
    assert duration.p_corrected == min(
        1.0, 0.0625 * len(figures)
    )  # Wilcoxon's least p of five pairs, and Holm's factor
    text = pairs_as_markdown(tuple(figures.values()), "aos-apso", "aos-pso")
    assert "| per mission | pairs | aos-pso | aos-apso | difference | p, corrected |" in text
    assert "| duration, min | 5 | 8.00 | 7.00 | -1.00 (-1.00 to -1.00) | 0.5 |" in text


def test_figures_without_a_pair_are_dashes_and_nothing_in_common_is_refused() -> None:
    text = pairs_as_markdown(pair_missions([EMPTY], [EMPTY]), "a", "b")
    assert "| persons found, share | 0 | - | - | - | - |" in text
    assert "| false claims | 1 | 1.00 | 1.00 | +0.00 |" in text
    with pytest.raises(InputDataError, match="none of these missions"):
        pair_missions([FOUND], [EMPTY])


def test_only_the_strategy_of_a_reference_may_differ(tmp_path: Path) -> None:
    MissionsFolder(tmp_path, MissionsSettings(strategy="aos-pso", vehicles=3)).append(FOUND)
    assert reference_missions(tmp_path, MissionsSettings(vehicles=3)) == ("aos-pso", [FOUND])
    with pytest.raises(ConfigurationError, match="other settings"):
        reference_missions(tmp_path, MissionsSettings(vehicles=4))
    with pytest.raises(ConfigurationError, match="no study of missions"):
        reference_missions(tmp_path / "nothing", MissionsSettings())
