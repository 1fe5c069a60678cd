"""Close look of a single vehicle."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.swarm.lone import LoneLook, LoneState
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.registry import strategy_for

SPACING_M = 4.2
LOOK = LoneLook("aos-apso", SPACING_M, 2.0)
RNG = np.random.default_rng(0)
NORTH = np.array([0.0, 1.0])


def observed(positions_m: list[list[float]], target_m: list[float] | None = None) -> Observation:
    return Observation(
        vehicle_ids=tuple(range(1, len(positions_m) + 1)),
        positions_enu_m=np.array(positions_m),
        fitness=np.zeros(len(positions_m)),
        target_in_view=target_m is not None,
        target_enu_m=None if target_m is None else np.array(target_m),
    )


def visit(state: LoneState, count: int, target_m: list[float] | None) -> tuple[NDArray[np.float64], LoneState]:
    """Return the places of so many steps, shape (count, 2)."""
    places = []
    for _ in range(count):
        (place,), state = LOOK.ask(LOOK.tell(state, observed([[0.0, 0.0]], target_m)), RNG)
        places.append(place)
    return np.array(places), state


def test_while_nothing_is_in_view_it_goes_on_along_the_leg() -> None:
    places, state = visit(LOOK.init(NORTH), 1, None)
    assert places.tolist() == [[0.0, 2.0]]
    assert LOOK.diagnostics(state).branch == "line"


def test_it_visits_the_places_around_a_target_from_the_middle_outwards_a_spacing_apart() -> None:
    target_m = [10.0, -5.0]
    places, state = visit(LOOK.init(NORTH), 19, target_m)
    distances_m = np.linalg.norm(places - target_m, axis=1)
    assert distances_m[0] == 0.0
    assert distances_m[1:7] == pytest.approx(SPACING_M)
    assert distances_m[7:].max() == pytest.approx(2 * SPACING_M)
    apart_m = np.linalg.norm(places[:, None] - places, axis=2)[~np.eye(19, dtype=bool)]
    assert apart_m.min() == pytest.approx(SPACING_M)
    assert LOOK.diagnostics(state).branch == "lone look"


def test_it_looks_on_where_the_target_was_seen_last_and_follows_one_that_walks() -> None:
    _, state = visit(LOOK.init(NORTH), 1, [10.0, 0.0])
    (hidden,), state = visit(state, 1, None)
    assert np.linalg.norm(hidden - [10.0, 0.0]) == pytest.approx(SPACING_M)
    (moved,), _ = visit(state, 1, [12.0, 0.0])
    assert np.linalg.norm(moved - [12.0, 0.0]) == pytest.approx(SPACING_M)


def test_one_that_joins_shares_the_places() -> None:
    state = LOOK.tell(LOOK.init(NORTH), observed([[0.0, 0.0], [5.0, 0.0]], [0.0, 0.0]))
    places, state = LOOK.ask(state, RNG)
    assert np.linalg.norm(places[1] - places[0]) == pytest.approx(SPACING_M)
    assert state.visited == 2


def test_nothing_is_asked_twice() -> None:
    with pytest.raises(RuntimeError, match="nothing has been told"):
        LOOK.ask(LOOK.init(NORTH), RNG)
    with pytest.raises(ValueError, match="needs a vehicle"):
        LOOK.tell(LOOK.init(NORTH), Observation((), np.zeros((0, 2)), np.zeros(0), target_in_view=False))


def test_only_a_single_vehicle_has_it_with_spacing_and_step_of_the_strategy() -> None:
    parameters = {"c4_m": 5.0, "c3_m": 3.0}
    alone = strategy_for(1, "aos-apso", parameters)
    assert isinstance(alone, LoneLook)
    assert alone.spacing_m == 5.0
    places, _ = alone.ask(alone.tell(alone.init(NORTH), observed([[0.0, 0.0]])), RNG)
    assert places.tolist() == [[0.0, 3.0]]
    assert not isinstance(strategy_for(2, "aos-apso", parameters), LoneLook)
