"""What is known of a body goes on with its next track, however long it was out of view."""

from __future__ import annotations

import numpy as np
import pytest

from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.imaging.persons.form import FormSums
from aos_gcs.mission.search.targets.pool import MAX_FORMER, Pool, Pools

PERSON = Verdict(FindingKind.PERSON, 0.99, ("warm",))
IN_FLIGHT = Verdict(FindingKind.ANIMAL, 0.01, ("smeared",), is_evidence=False)


def look(verdict: Verdict, east_m: float = 0.0) -> Pool:
    return Pool((verdict,), np.array([east_m, 10.0]), (), FormSums())


def looks_of(pools: Pools, track_id: int) -> int:
    pool = pools.get(track_id)
    return 0 if pool is None else len(pool.verdicts)


def ended(verdict: Verdict, *, stays: bool = True) -> Pools:
    """Return the pools after the end of track 1, of which two looks were had."""
    pools = Pools()
    for _ in range(2):
        pools.follow({1: stays})
        pools.add(1, look(verdict))
    pools.follow({})
    return pools


@pytest.mark.parametrize(("east_m", "looks"), [(0.3, 3), (0.8, 1)])
def test_a_new_track_goes_on_with_the_body_that_was_seen_at_its_place(east_m: float, looks: int) -> None:
    pools = ended(PERSON)
    assert pools.get(1) is None
    pools.add(2, look(PERSON, east_m))
    assert looks_of(pools, 2) == looks


def test_a_body_goes_on_with_one_track_only() -> None:
    pools = ended(PERSON)
    pools.follow({2: True})
    pools.add(2, look(PERSON))
    pools.follow({})
    pools.add(3, look(PERSON))
    assert looks_of(pools, 3) == 4, "all looks"
    pools.add(4, look(PERSON, 0.6))
    assert looks_of(pools, 4) == 1, "what was known of the body has gone to the other track"


@pytest.mark.parametrize(("verdict", "stays"), [(PERSON, False), (IN_FLIGHT, True)])
def test_what_walks_and_what_only_frames_in_flight_have_shown_is_looked_at_anew(verdict: Verdict, stays: bool) -> None:
    pools = ended(verdict, stays=stays)
    pools.add(2, look(PERSON))
    assert looks_of(pools, 2) == 1


def test_the_bodies_seen_last_are_kept() -> None:
    pools = Pools()
    for number in range(MAX_FORMER + 1):
        pools.follow({number: True})
        pools.add(number, look(PERSON, 10.0 * number))
    pools.follow({})
    pools.add(1000, look(PERSON, 0.0))
    pools.add(1001, look(PERSON, 10.0))
    assert (looks_of(pools, 1000), looks_of(pools, 1001)) == (1, 2)
