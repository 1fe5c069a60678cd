"""The threads that imaging shares; OpenCV, BLAS and NumPy release the interpreter while they work."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

MAX_WORKERS = 4
"""More would wait for memory, and for each other in Python."""

_limits = [MAX_WORKERS]
"""Upper bounds of the number of threads."""

Item = TypeVar("Item")
Result = TypeVar("Result")


def parallel_map(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return the function's results in the order of the items, so that they do not depend on which thread is faster.

    All items are in flight at once: pass them in batches where results are large. The function must not call
    ``parallel_map`` itself, as its inner call could wait for the threads that the outer ones hold.
    """
    items = list(items)
    if len(items) < 2 or _count() < 2:
        return [function(item) for item in items]
    return list(_pool().map(function, items))


def ahead_map(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield the function's results in the order of the items, and compute the next ones while the caller works on one.

    As many results are held as there are threads. As for ``parallel_map``, the function must not use these threads
    itself; the caller may.
    """
    if _count() < 2:
        yield from map(function, items)
        return
    begun: deque[Future[Result]] = deque()
    for item in items:
        begun.append(_pool().submit(function, item))
        if len(begun) > _count():
            yield begun.popleft().result()
    while begun:
        yield begun.popleft().result()


def use_one_thread() -> None:
    """Do without threads in this process from now on: for one of several that share the cores."""
    _limits.append(1)


def _count() -> int:
    return min(os.cpu_count() or 1, *_limits)


@cache
def _pool() -> ThreadPoolExecutor:
    # One for the process: starting threads for every integral would cost a tenth of it.
    return ThreadPoolExecutor(_count(), thread_name_prefix="imaging")
