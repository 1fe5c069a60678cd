"""Patience of the tests: limits of waiting that follow the speed of the machine, and what took how long."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterable
from functools import cache
from pathlib import PurePosixPath

import pytest

VARIABLE = "AOS_GCS_TEST_PATIENCE"
DEFAULT_LIMIT_S = 120.0
"""Time that one test may take on the machine of reference, unless its marker says otherwise."""
_LOOPS = 400_000
_REFERENCE_S = 0.02
"""Duration of the measured work on the machine of reference, two cores of an AMD EPYC with nothing else to do."""
_LEAST, _MOST = 2.0, 30.0
_IDLE_CYCLES = 2
"""Empty cycles of an event loop before its virtual time advances; the 42 that are usual take a third of the work."""


@cache
def patience() -> float:
    """Factor by which limits of waiting are longer than written: measured once per process, or from the environment.

    It is never below 2, because a machine that is idle while it is measured may be busy later. A long limit costs
    nothing where tests pass.
    """
    if VARIABLE in os.environ:
        return float(os.environ[VARIABLE])
    start_s = time.perf_counter()
    total = 0
    for number in range(_LOOPS):
        total += number
    return min(_MOST, max(_LEAST, _LEAST * (time.perf_counter() - start_s) / _REFERENCE_S))


def scaled_s(limit_s: float) -> float:
    """Return a limit of waiting, given for the machine of reference, as it holds on this machine."""
    return limit_s * patience()


def limit(item: pytest.Item) -> None:
    """Give a test as much time as its marker says, or the default, scaled to this machine."""
    marker = item.get_closest_marker("timeout")
    limit_s = float(marker.args[0]) if marker is not None else DEFAULT_LIMIT_S
    item.add_marker(pytest.mark.timeout(scaled_s(limit_s)), append=False)


def advance_promptly(item: pytest.Item) -> None:
    """Let virtual time advance as soon as nothing is left to do, where a test runs in virtual time."""
    if item.get_closest_marker("looptime") is not None:
        item.add_marker(pytest.mark.looptime(noop_cycles=_IDLE_CYCLES))


def by_folder(reports: Iterable[pytest.TestReport]) -> list[str]:
    """Return one line per folder of tests: its seconds and its number of tests, the longest first."""
    seconds: Counter[str] = Counter()
    tests: Counter[str] = Counter()
    for report in reports:
        folder = str(PurePosixPath(report.nodeid.partition("::")[0]).parent)
        seconds[folder] += report.duration
        tests[folder] += report.when == "call"
    return [f"{seconds[folder]:8.1f} s  {tests[folder]:5d} tests  {folder}" for folder, _ in seconds.most_common()]
