"""Initialisations: drawn, fixed and from files; where target and swarm are."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.initialisation import (
    EDGE_MARGIN_M,
    check_initialisation,
    draw_initialisations,
    load_initialisations,
    paper_initialisations,
    start_positions,
    target_walk,
)
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.walk import TRUNK_CLEARANCE_M, Route, clear_of_trunks
from tests.fakes.lab_world import FakeWorld

SCENARIO = Scenario()
WALKING = Scenario(target_speed_mps=4.0)


def test_a_longer_list_begins_with_the_shorter_one() -> None:
    assert draw_initialisations(5, 7, SCENARIO)[:3] == draw_initialisations(3, 7, SCENARIO)
    assert draw_initialisations(3, 8, SCENARIO) != draw_initialisations(3, 7, SCENARIO)


def test_there_are_three_of_the_paper() -> None:
    fixed = paper_initialisations()
    assert [initialisation.name for initialisation in fixed] == ["paper-1", "paper-2", "paper-3"]
    assert len({(i.world_seed, i.seed, i.target_offset_m) for i in fixed}) == 3
    for initialisation in fixed:
        check_initialisation(initialisation, SCENARIO)


def test_the_swarm_starts_in_line_before_the_target() -> None:
    initialisation = dataclasses.replace(paper_initialisations()[0], scan_heading_deg=90.0, aside_m=3.0)
    walk = target_walk(initialisation, SCENARIO, FakeWorld())
    offset_m = start_positions(initialisation, SCENARIO, walk) - walk.corners_enu_m[0]
    # Heading east: the line runs north, its middle 30 m west of the target and 3 m to the left, north.
    assert offset_m[:, 0] == pytest.approx(np.full(10, -30.0))
    assert offset_m[:, 1].mean() == pytest.approx(3.0)
    assert np.diff(offset_m[:, 1]) == pytest.approx(np.full(9, 4.2))


def test_a_target_that_stays_stays() -> None:
    initialisation = paper_initialisations()[1]
    walk = target_walk(initialisation, SCENARIO, FakeWorld())
    assert walk.at(0.0) == walk.at(20.0)
    assert walk.at(0.0)[0] == pytest.approx(initialisation.target_offset_m)
    assert walk.at(0.0)[1] == pytest.approx(math.radians(initialisation.target_heading_deg))


def test_a_walking_target_keeps_its_speed_and_the_middle_of_the_forest() -> None:
    walk = target_walk(paper_initialisations()[2], WALKING, FakeWorld())
    places_m = np.array([walk.at(time_s)[0] for time_s in np.linspace(0.0, 20.0, 2001)])
    steps_m = np.linalg.norm(np.diff(places_m, axis=0), axis=1)
    assert steps_m.max() == pytest.approx(0.04)
    # Cutting a corner is the only way to be shorter.
    assert np.count_nonzero(steps_m < 0.0399) <= len(walk.corners_enu_m)
    assert np.abs(places_m).max() <= 30.0


def test_a_walker_faces_where_it_goes_and_stays_at_the_end() -> None:
    walk = Route(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]), speed_mps=1.0, heading_rad=0.0)
    assert walk.at(1.0) == ((1.0, 0.0), pytest.approx(math.pi / 2))
    assert walk.at(5.0) == ((3.0, 2.0), pytest.approx(0.0))
    assert walk.at(100.0)[0] == (3.0, 4.0)


def test_places_near_trunks_are_left_and_others_kept() -> None:
    trunks_m = np.array([[0.0, 0.0], [6.0, 0.0]])
    rng = np.random.default_rng(0)
    kept = np.array([3.0, 0.5])
    assert np.array_equal(clear_of_trunks(rng, kept, trunks_m), kept)
    moved = clear_of_trunks(rng, np.array([0.1, 0.0]), trunks_m)
    assert np.linalg.norm(moved - trunks_m, axis=1).min() >= TRUNK_CLEARANCE_M


def test_a_target_outside_the_forest_is_refused() -> None:
    outside = dataclasses.replace(paper_initialisations()[0], target_offset_m=(0.0, 50.0 - EDGE_MARGIN_M + 0.1))
    with pytest.raises(ConfigurationError, match="target_offset_m of initialisation paper-1 lies outside the forest"):
        check_initialisation(outside, SCENARIO)


ENTRY = """[[initialisation]]
name = "a"
world_seed = 1
target_offset_m = [0.0, 1]
target_heading_deg = 0.0
scan_heading_deg = 0.0
aside_m = 0.0
seed = 3
"""


def test_files_hold_own_initialisations(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(ENTRY + ENTRY.replace('"a"', '"b"'))
    first, second = load_initialisations(path)
    assert (first.name, first.target_offset_m, second.name) == ("a", (0.0, 1.0), "b")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = ", "is not TOML"),
        ("x = 1", "must have tables"),
        (ENTRY + ENTRY, "same name"),
        (ENTRY.replace("seed = 3", ""), "missing or unknown fields: seed"),
        (ENTRY + "colour = 1\n", "missing or unknown fields: colour"),
        (ENTRY.replace('"a"', '"../a"'), "name in .* must be letters"),
        (ENTRY.replace("[0.0, 1]", "[0.0]"), "target_offset_m of a"),
        (ENTRY.replace("[0.0, 1]", '["x", 1]'), "target_offset_m east of a"),
        (ENTRY.replace("world_seed = 1", "world_seed = -1"), "world_seed of a"),
        (ENTRY.replace("aside_m = 0.0", "aside_m = nan"), "aside_m of a"),
    ],
)
def test_files_are_refused_with_the_field(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match=words):
        load_initialisations(path)


@pytest.mark.parametrize(("count", "seed", "words"), [(0, 0, "number of initialisations"), (3, -1, "seed")])
def test_draws_are_refused_with_the_field(count: int, seed: int, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        draw_initialisations(count, seed, SCENARIO)
