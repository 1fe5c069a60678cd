"""Plans of a relay: batteries that were full together are relieved one after another, in time for all of them."""

import math
from itertools import pairwise

import numpy as np
import pytest

from aos_gcs.mission.fleet.reinforcements.approach import Moving, meeting_place_m
from aos_gcs.mission.fleet.reinforcements.relief_plan import relief_times_s


def test_without_replacements_each_leaves_by_its_battery() -> None:
    assert relief_times_s({3: 100.0, 1: 40.0}, 0, 200.0, 20.0) == {1: 40.0, 3: 100.0}


def test_two_replacements_relieve_six_in_three_turns() -> None:
    plan_s = relief_times_s(dict.fromkeys(range(1, 7), 1000.0), 2, 200.0, 20.0)
    assert list(plan_s) == [1, 2, 3, 4, 5, 6]
    assert list(plan_s.values()) == [580.0, 600.0, 780.0, 800.0, 980.0, 1000.0]


def test_who_has_least_left_is_relieved_first_and_nobody_later_than_its_battery() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        lasts_s = {key: float(rng.uniform(0.0, 900.0)) for key in range(1, int(rng.integers(2, 9)))}
        spares, turnaround_s = int(rng.integers(0, 4)), float(rng.uniform(30.0, 300.0))
        plan_s = relief_times_s(lasts_s, spares, turnaround_s, 10.0)
        times_s = list(plan_s.values())
        assert all(plan_s[key] <= last_s for key, last_s in lasts_s.items())
        assert list(plan_s) == sorted(lasts_s, key=lambda key: (lasts_s[key], key))
        if spares:
            assert all(after - before >= 10.0 - 1e-9 for before, after in pairwise(times_s))
            turns = zip(times_s, times_s[spares:], strict=False)
            assert all(after - before >= turnaround_s - 1e-9 for before, after in turns)


def test_a_battery_that_does_not_drain_needs_no_relief() -> None:
    assert relief_times_s({1: math.inf, 2: 50.0}, 1, 10.0, 5.0) == {2: 50.0, 1: math.inf}


def moving(place_m: tuple[float, float], velocity_mps: tuple[float, float], end_m: tuple[float, float]) -> Moving:
    return Moving(np.array(place_m), np.array(velocity_mps), np.array(end_m))


def test_a_vehicle_meets_the_line_on_its_way() -> None:
    # 60 m abeam at 10 m/s: after 7.5 s both have reached 45 m along the leg, 75 m away.
    meets_m = meeting_place_m(np.array([60.0, 0.0]), moving((0.0, 0.0), (0.0, 6.0), (0.0, 90.0)), 10.0)
    assert meets_m == pytest.approx([0.0, 45.0])
    assert meeting_place_m(np.zeros(2), moving((0.0, 50.0), (0.0, 0.0), (0.0, 50.0)), 10.0) == pytest.approx(
        [0.0, 50.0]
    )


def test_nobody_is_aimed_beyond_the_waypoints_of_the_line() -> None:
    ahead = moving((0.0, 50.0), (0.0, 6.0), (0.0, 80.0))
    assert meeting_place_m(np.zeros(2), ahead, 10.0) == pytest.approx([0.0, 80.0])
    assert meeting_place_m(np.zeros(2), ahead, 5.0) == pytest.approx([0.0, 80.0])
