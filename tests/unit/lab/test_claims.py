"""The rules behind the verdicts, on runs that are made to fulfil or to break them."""

from collections.abc import Callable

import numpy as np
import pyarrow as pa
import pytest

from aos_gcs.lab.claims import (
    AOS_PSO,
    PAPER_STRATEGIES,
    STABILISED,
    TUNED,
    paper_claims,
    plateau,
    positions_matter,
    projection_lines,
    stabilisation_centres,
    stabilisation_is_no_worse,
    tiny_factors_explode,
    tuned_gains,
    untuned_loses,
)
from aos_gcs.lab.report import Comparison, compare
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.tables import SCHEMA

STEPS = 81
TIME_S = np.linspace(0.0, 20.0, STEPS)
RING_M = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]])


def run(
    strategy: str,
    initialisation: int,
    *,
    visibility: np.ndarray,
    factor: np.ndarray | float = 0.3,
    factors_m: np.ndarray | float = 2.0,
    radius_m: np.ndarray | float = 5.0,
) -> pa.Table:
    """A run of four drones on a ring round the origin."""
    places_m = np.broadcast_to(radius_m, STEPS)[:, None, None] * RING_M
    columns = {
        "initialisation": [str(initialisation)] * STEPS,
        "strategy": [strategy] * STEPS,
        "step": np.arange(1, STEPS + 1),
        "time_s": TIME_S,
        "visibility": visibility,
        "evolutionary_factor": np.broadcast_to(factor, STEPS),
        "c_s_m": np.broadcast_to(factors_m, STEPS) * 2 / 3,
        "c_c_m": np.broadcast_to(factors_m, STEPS) / 3,
        "east_m": places_m[..., 0].tolist(),
        "north_m": places_m[..., 1].tolist(),
        "in_view": [True] * STEPS,
        "branch": ["pso"] * STEPS,
        "leader_id": [1] * STEPS,
        "evolutionary_state": [None] * STEPS,
        "height_m": [[35.0] * 4] * STEPS,
        "fitness": [[0.0] * 4] * STEPS,
    }
    numbers = {name: np.zeros(STEPS) for name in SCHEMA.names if name not in columns}
    return pa.table({name: (columns | numbers)[name] for name in SCHEMA.names}, schema=SCHEMA)


def campaign(make: Callable[[str, int], pa.Table], strategies: tuple[str, ...] = PAPER_STRATEGIES) -> Comparison:
    rows = pa.concat_tables([make(strategy, number) for strategy in strategies for number in range(5)])
    return compare(Scenario(drones=4), strategies, rows)


def level(number: int, mean: float) -> np.ndarray:
    """A curve that rises and stays, a little different in every initialisation."""
    return (mean + 0.01 * number) * np.clip(TIME_S / 4.0, 0.0, 1.0)


@pytest.mark.parametrize(("mean", "slope", "holds"), [(0.4, 0.0, True), (0.7, 0.0, False), (0.35, 0.02, False)])
def test_plateau_asks_for_the_level_and_for_standstill(mean: float, slope: float, *, holds: bool) -> None:
    rising = slope * np.clip(TIME_S - 8.0, 0.0, None)
    comparison = campaign(lambda name, n: run(name, n, visibility=level(n, mean) + rising), (AOS_PSO,))
    assert plateau(comparison).holds is holds


@pytest.mark.parametrize(("gain", "is_no_worse"), [(0.02, True), (-0.02, True), (-0.10, False)])
def test_gains_and_losses_are_seen_in_pairs(gain: float, *, is_no_worse: bool) -> None:
    def make(name: str, number: int) -> pa.Table:
        better = 0.0 if name == AOS_PSO else gain
        return run(name, number, visibility=level(number, 0.4 + better), factor=0.1 if name == STABILISED else 0.6)

    comparison = campaign(make)
    assert stabilisation_is_no_worse(comparison).holds is is_no_worse
    assert tuned_gains(comparison).holds is (gain > 0.0)
    assert untuned_loses(comparison).holds is (gain < 0.0)


def test_centring_needs_a_certain_difference() -> None:
    def make(name: str, number: int) -> pa.Table:
        wavering = 0.4 + 0.2 * (-1.0) ** number
        return run(name, number, visibility=level(number, 0.4), factor=wavering if name == STABILISED else 0.41)

    assert not stabilisation_centres(campaign(make, (AOS_PSO, STABILISED))).holds


@pytest.mark.parametrize("grows", [True, False])
def test_explosion_is_growth_where_both_factors_are_tiny(*, grows: bool) -> None:
    tiny = TIME_S > 15.0
    growth = np.where(tiny, TIME_S - 15.0, 0.0)

    def make(name: str, number: int) -> pa.Table:
        radius_m = 5.0 + growth * (1.0 + 0.01 * number) if grows else 5.0
        factors_m = np.where(tiny, 0.3, 3.0)
        return run(name, number, visibility=level(number, 0.4), factors_m=factors_m, radius_m=radius_m)

    assert tiny_factors_explode(campaign(make, (TUNED,))).holds is grows


def test_factors_that_never_get_tiny_prove_nothing() -> None:
    claim = tiny_factors_explode(campaign(lambda name, n: run(name, n, visibility=level(n, 0.4)), (TUNED,)))
    assert not claim.holds
    assert "0 of 5 runs" in claim.measured


def test_positions_matter_when_visibility_wavers_while_the_swarm_is_centred() -> None:
    def make(name: str, number: int) -> pa.Table:
        rng = np.random.default_rng(number)
        return run(name, number, visibility=rng.uniform(0.2, 0.6, STEPS), factor=np.where(TIME_S < 10.0, 0.05, 0.4))

    assert positions_matter(campaign(make, (TUNED,))).holds


def test_lines_by_projection_are_shorter_though_ways_may_cross() -> None:
    shorter, crossing_free = projection_lines(np.random.default_rng(1), swarms=60)
    assert shorter.holds
    assert not crossing_free.holds
    crossings, by_index = (int(text.split()[0]) for text in crossing_free.measured.split(", ")[:2])
    assert 0 < crossings < by_index / 3


def test_all_claims_come_with_what_was_measured() -> None:
    claims = paper_claims(campaign(lambda name, n: run(name, n, visibility=level(n, 0.4)), PAPER_STRATEGIES))
    assert len({claim.text for claim in claims}) == 9
    assert all(any(character.isdigit() for character in claim.measured) for claim in claims)
