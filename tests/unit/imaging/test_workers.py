"""Threads of imaging: results come in the order of the items, whether there are threads or not."""

from __future__ import annotations

import threading

import pytest

from aos_gcs.imaging import workers
from tests.timing import scaled_s


def test_several_items_are_in_flight_at_once_and_come_back_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    workers._pool.cache_clear()
    all_there = threading.Barrier(2, timeout=scaled_s(30.0))

    def wait_for_other(item: int) -> int:
        all_there.wait()
        return 10 * item

    assert workers.parallel_map(wait_for_other, [2, 1]) == [20, 10]
    workers._pool().shutdown()
    workers._pool.cache_clear()


@pytest.mark.parametrize("items", [[], [3], [3, 1, 2]])
def test_one_core_needs_no_threads(items: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(workers, "_pool", lambda: pytest.fail("threads on one core"))
    assert workers.parallel_map(lambda item: (item, threading.current_thread()), items) == [
        (item, threading.main_thread()) for item in items
    ]


@pytest.mark.parametrize("count", [1, 3])
def test_results_are_computed_ahead_in_the_order_of_the_items(monkeypatch: pytest.MonkeyPatch, count: int) -> None:
    monkeypatch.setattr(workers, "_count", lambda: count)
    begun: list[int] = []

    def tenfold(item: int) -> int:
        begun.append(item)
        return 10 * item

    results = workers.ahead_map(tenfold, iter(range(20)))
    assert next(results) == 0
    # No more than the threads can do are held.
    assert len(begun) <= count + 1
    assert list(results) == [10 * item for item in range(1, 20)]
    assert sorted(begun) == list(range(20))


def test_an_error_comes_where_its_result_would(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "_count", lambda: 2)
    results = workers.ahead_map(lambda item: 1 // item, [1, 1, 0, 1])
    assert [next(results), next(results)] == [1, 1]
    with pytest.raises(ZeroDivisionError):
        next(results)
