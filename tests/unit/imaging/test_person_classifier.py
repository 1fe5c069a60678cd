"""Telling persons from other warm bodies."""

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.persons.classifier import (
    PersonModel,
    default_model,
    fit_person_model,
    person_confidence,
    read_model,
    write_model,
)
from aos_gcs.imaging.persons.decision import DECISION, FindingKind, decide
from aos_gcs.imaging.persons.evidence import Evidence

PERSON = Evidence(
    views=24,
    vehicles=9,
    area_m2=0.25,
    extent_m=0.8,
    contrast_median_k=14.5,
    contrast_peak_k=20.5,
)
DEER = replace(PERSON, area_m2=0.45, extent_m=1.4, contrast_median_k=8.0, contrast_peak_k=13.0)
STONE = replace(PERSON, area_m2=0.5, extent_m=0.9, contrast_median_k=12.0, contrast_peak_k=13.5)


def sample(of: Evidence, count: int, seed: int) -> list[Evidence]:
    """Scatter evidence round an example; contrasts scatter less than sizes, which leaves hide."""
    factors = np.random.default_rng(seed).lognormal(0.0, (0.08, 0.08, 0.04, 0.04), (count, 4))
    return [
        replace(
            of,
            area_m2=of.area_m2 * a,
            extent_m=of.extent_m * b,
            contrast_median_k=of.contrast_median_k * c,
            contrast_peak_k=of.contrast_peak_k * d,
        )
        for a, b, c, d in factors
    ]


@pytest.fixture(scope="module")
def model() -> PersonModel:
    persons, others = sample(PERSON, 40, 1), sample(DEER, 20, 2) + sample(STONE, 20, 3)
    return fit_person_model(persons + others, [True] * 40 + [False] * 40, odds=1.0)


def test_a_fitted_model_tells_new_bodies_apart(model: PersonModel) -> None:
    assert all(person_confidence(one, model) > DECISION for one in sample(PERSON, 20, 4))
    assert all(person_confidence(one, model) < DECISION for one in sample(DEER, 20, 5) + sample(STONE, 20, 6))


def test_rare_classes_weigh_as_much_as_common_ones() -> None:
    persons, others = sample(PERSON, 4, 1), sample(DEER, 200, 2)
    model = fit_person_model(persons + others, [True] * 4 + [False] * 200)
    assert all(person_confidence(one, model) > DECISION for one in persons)


def test_what_no_stone_reaches_is_a_person_even_without_skin() -> None:
    """A coarse camera shows clothes only; tops of stones are up to 15 K warmer than the ground, clothes up to 17."""
    clothes_only = replace(PERSON, contrast_median_k=16.5, contrast_peak_k=17.0, vehicles=4)
    assert person_confidence(clothes_only) > DECISION


def test_a_model_needs_both_classes() -> None:
    for is_person in (True, False):
        with pytest.raises(InputDataError, match="both kinds"):
            fit_person_model([PERSON], [is_person])
    with pytest.raises(InputDataError, match="both kinds"):
        fit_person_model([], [])


def test_what_one_vehicle_sees_is_no_evidence(model: PersonModel) -> None:
    assert person_confidence(replace(PERSON, vehicles=1, views=3), model) == 0.0


def test_the_programs_own_model_knows_persons_animals_and_stones() -> None:
    assert person_confidence(PERSON) > 0.8
    assert person_confidence(DEER) < 0.2
    assert person_confidence(STONE) < 0.35


def test_a_face_above_a_blanket_and_clothes_without_skin_are_persons() -> None:
    assert person_confidence(replace(PERSON, contrast_median_k=6.5, contrast_peak_k=20.0)) > DECISION
    assert person_confidence(replace(PERSON, contrast_median_k=15.0, contrast_peak_k=15.5)) > DECISION


def test_a_stone_as_warm_as_clothes_is_told_by_its_length() -> None:
    """Evidence of missions: a stone of 26 °C, and a person without skin to be seen."""
    stone = replace(PERSON, contrast_median_k=13.1, contrast_peak_k=14.4, extent_m=1.25)
    covered = replace(PERSON, contrast_median_k=14.0, contrast_peak_k=14.7, extent_m=0.67)
    assert person_confidence(stone) < 0.4
    assert person_confidence(covered) > 0.7
    assert person_confidence(replace(stone, contrast_peak_k=19.5)) > DECISION, "whose face shows may lie stretched out"


def test_clothes_beside_a_blanket_are_a_person_even_without_skin() -> None:
    blanket = replace(PERSON, contrast_median_k=4.6, contrast_peak_k=13.7)
    boar = replace(PERSON, contrast_median_k=4.8, contrast_peak_k=10.7)
    assert person_confidence(blanket) > DECISION
    assert person_confidence(boar) < 0.1


def test_temperatures_of_another_day_make_nothing_sure() -> None:
    """Form must be able to outweigh what some kelvin would change."""

    def on_a_day(of: Evidence, day_k: float) -> float:
        warmer = replace(of, contrast_median_k=of.contrast_median_k + day_k, contrast_peak_k=of.contrast_peak_k + day_k)
        return person_confidence(warmer)

    assert on_a_day(STONE, 2.0) < 0.85, "a stone after hours of sun"
    assert on_a_day(PERSON, -4.0) > 0.1, "a person on a hot day"
    assert on_a_day(PERSON, 0.0) > on_a_day(PERSON, -2.0) > on_a_day(PERSON, -4.0)


def test_stones_in_the_sun_are_hotter_than_skin() -> None:
    """Clear days, a forest of 17 °C: a stone, and a person whose face is as warm as it is anywhere."""
    stone = replace(STONE, contrast_median_k=19.0, contrast_peak_k=21.0)
    assert person_confidence(stone) > 0.9, "on a cool day, when nothing else is so warm"
    assert person_confidence(replace(stone, background_c=17.0)) < 0.1
    assert "21 K at its warmest, 5 K hotter than skin" in decide(replace(stone, background_c=17.0)).reasons[0]


def test_spots_of_sun_on_clothes_make_nobody_a_stone() -> None:
    """A sunny day: dark clothes are 12 K hotter than skin in spots, and a stone is hot all over."""
    person = replace(PERSON, background_c=17.0, contrast_median_k=12.0, contrast_peak_k=28.0)
    assert person_confidence(person) < 0.01
    in_sun = replace(person, in_sun=True)
    assert person_confidence(in_sun) > DECISION
    assert person_confidence(replace(in_sun, contrast_peak_k=45.0)) == person_confidence(in_sun)
    assert "hotter" not in decide(in_sun).reasons[0]
    stone = replace(STONE, background_c=17.0, contrast_median_k=21.0, contrast_peak_k=24.0, in_sun=True)
    assert person_confidence(stone) < 0.1
    assert "24 K at its warmest, 7 K hotter than clothes" in decide(stone).reasons[0]


@pytest.mark.parametrize(("background_c", "median_k", "peak_k"), [(17.0, 12.0, 16.0), (25.5, 7.0, 8.2)])
def test_of_a_warm_forest_persons_stand_out_less(background_c: float, median_k: float, peak_k: float) -> None:
    person = replace(PERSON, contrast_median_k=median_k, contrast_peak_k=peak_k)
    on_that_day = replace(person, background_c=background_c)
    assert person_confidence(on_that_day) > DECISION > person_confidence(person)
    assert decide(on_that_day).reasons == decide(person).reasons


@given(background_c=st.floats(-30.0, 45.0), peak_k=st.floats(4.0, 45.0))
def test_the_day_changes_nothing_in_a_cool_forest_and_makes_no_person_of_what_is_far_too_hot(
    background_c: float, peak_k: float
) -> None:
    body = replace(PERSON, contrast_median_k=0.7 * peak_k, contrast_peak_k=peak_k)
    confidence = person_confidence(replace(body, background_c=background_c))
    if background_c <= 13.0 and background_c + peak_k <= 33.0:
        assert confidence == person_confidence(body)
    if background_c + peak_k > 40.0:
        assert confidence < 0.01


def test_rarer_persons_take_more_evidence(model: PersonModel) -> None:
    doubtful = replace(PERSON, contrast_median_k=11.5, contrast_peak_k=16.0)
    rare, common = (person_confidence(doubtful, replace(model, odds=odds)) for odds in (0.1, 1.0))
    assert rare < 0.5 * common


@pytest.mark.parametrize("odds", ["0", "-1", "NaN"])
def test_odds_of_a_model_must_be_above_zero(model: PersonModel, tmp_path: Path, odds: str) -> None:
    write_model(tmp_path / "model.json", model)
    text = (tmp_path / "model.json").read_text(encoding="utf-8").replace('"odds": 1.0', f'"odds": {odds}')
    (tmp_path / "model.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputDataError, match="odds"):
        read_model(tmp_path / "model.json")


@pytest.mark.parametrize(("swarm", "sure"), [(2, False), (3, True)])
def test_what_three_vehicles_do_not_see_warm_is_surely_no_person(swarm: int, sure: bool) -> None:
    cold = Evidence(0, 0, 0.0, 0.0, 0.0, 0.0, frames=3 * swarm, swarm=swarm)
    assert decide(cold).is_surely_other is sure


@pytest.mark.parametrize(
    ("views", "frames", "thorough"), [(9, 9, True), (9, 15, True), (9, 16, False), (8, 8, False), (15, 15, True)]
)
def test_a_look_is_thorough_where_most_frames_of_three_steps_show_what_is_no_person(
    views: int, frames: int, thorough: bool
) -> None:
    boar = replace(DEER, contrast_median_k=6.0, contrast_peak_k=9.0, vehicles=3, swarm=5, views=views, frames=frames)
    assert decide(boar).is_surely_other
    assert decide(boar).is_thorough is thorough
    assert not decide(replace(PERSON, vehicles=3, swarm=5, views=views, frames=frames)).is_thorough
    assert not decide(Evidence(0, 0, 0.0, 0.0, 0.0, 0.0, frames=frames, swarm=5)).is_thorough


def test_what_was_seen_in_flight_alone_is_surely_no_person_only_where_nothing_of_it_is_as_warm_as_clothes() -> None:
    """Evidence of missions at 5 m/s: a person of 14 K without skin to be seen, and a stone of 9 K."""
    person = replace(PERSON, vehicles=5, swarm=5, frames=24, contrast_median_k=7.3, contrast_peak_k=13.8)
    stone = replace(person, contrast_median_k=5.0, contrast_peak_k=9.5)
    in_flight = decide(replace(person, is_smeared=True))
    assert (in_flight.is_surely_other, in_flight.is_thorough, in_flight.is_evidence) == (False, False, False)
    assert decide(person).is_evidence, "what hovering cameras show counts"
    assert decide(replace(stone, is_smeared=True)).is_surely_other
    skin = decide(replace(person, contrast_median_k=9.0, contrast_peak_k=19.0, is_smeared=True))
    assert skin.kind is FindingKind.PERSON
    assert skin.is_evidence


def test_something_as_hot_as_an_engine_is_no_person() -> None:
    assert person_confidence(replace(PERSON, contrast_median_k=60.0, contrast_peak_k=70.0)) == 0.0


def test_models_survive_a_file(model: PersonModel, tmp_path: Path) -> None:
    for one in (model, replace(model, fitted_to="80 scenes", fitted_on="2026-11-21")):
        write_model(tmp_path / "model.json", one)
        assert read_model(tmp_path / "model.json") == one


def test_the_programs_own_model_names_its_data_and_date() -> None:
    model = default_model()
    assert "scenes" in model.fitted_to
    assert date.fromisoformat(model.fitted_on)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "damaged"),
        ("{}", "damaged"),
        ('{"features": ["smell"], "centres": [], "scales": [], "weights": [], "bias": 0}', "other features"),
    ],
)
def test_damaged_models_are_named(text: str, reason: str, tmp_path: Path) -> None:
    file = tmp_path / "model.json"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputDataError, match=rf"model\.json.*{reason}"):
        read_model(file)


def test_a_missing_model_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputDataError, match=r"nowhere\.json"):
        read_model(tmp_path / "nowhere.json")


@pytest.mark.parametrize(
    ("vehicles", "swarm", "sure"), [(9, 10, True), (6, 10, True), (5, 10, False), (2, 2, False), (3, 3, True)]
)
def test_no_person_is_sure_once_most_vehicles_see_it(vehicles: int, swarm: int, sure: bool) -> None:
    boar = replace(DEER, contrast_median_k=6.0, contrast_peak_k=9.0, vehicles=vehicles, swarm=swarm)
    assert decide(boar).is_surely_other is sure
    assert not decide(replace(PERSON, vehicles=vehicles, swarm=swarm)).is_surely_other
