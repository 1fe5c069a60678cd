from __future__ import annotations

import hypothesis.strategies as st
from hypothesis import given

from aos_gcs.token_bucket import TokenBucket


def test_a_burst_may_be_spent_at_once_and_grows_again() -> None:
    bucket = TokenBucket(per_s=2.0, burst=10.0)
    assert [bucket.take(5.0, 0.0) for _ in range(3)] == [True, True, False]
    assert bucket.take(3.0, 1.0) is False
    assert bucket.take(3.0, 1.5) is True
    assert bucket.left(1000.0) == 10.0


def test_a_debt_is_paid_off_first() -> None:
    bucket = TokenBucket(per_s=1.0, burst=4.0)
    bucket.spend(10.0)
    assert (bucket.left(0.0), bucket.left(5.0), bucket.left(7.0)) == (-6.0, -1.0, 1.0)


def test_what_is_given_back_does_not_exceed_the_burst() -> None:
    bucket = TokenBucket(per_s=1.0, burst=4.0)
    bucket.spend(1.0)
    bucket.spend(-9.0)
    assert bucket.left(0.0) == 4.0


def test_a_time_that_has_passed_already_earns_nothing_again() -> None:
    bucket = TokenBucket(per_s=1.0, burst=10.0)
    bucket.spend(10.0)
    for _ in range(5):
        assert [bucket.left(now_s) for now_s in (1.0, 0.5, 1.0)] == [bucket.left(1.0)] * 3
    assert bucket.left(2.0) == 1.0


@given(st.lists(st.tuples(st.floats(-1.0, 3.0), st.floats(0.0, 5.0)), max_size=50))
def test_no_more_is_taken_than_the_burst_and_the_rate_allow(takes: list[tuple[float, float]]) -> None:
    bucket, now_s, latest_s, taken, ran_s = TokenBucket(2.0, 6.0), 0.0, 0.0, 0.0, 0.0
    bucket.left(now_s)
    for pause_s, amount in takes:
        now_s += pause_s
        ran_s += max(0.0, now_s - latest_s)
        latest_s = now_s
        taken += amount if bucket.take(amount, now_s) else 0.0
        assert taken <= 6.0 + 2.0 * ran_s + 1e-9
