"""Many missions side by side, and the report on them."""

from __future__ import annotations

import logging
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Iterable

from tests.campaign.faults import KNOWN_DEFECTS
from tests.campaign.flight import FlightVerdict, fly
from tests.campaign.scenario import draw
from tests.campaign.shrink import shrink

TRACE_LINES = 60
"""Number of the latest notices that are printed of a failure."""
PROGRESS = 20
"""Number of missions after which one line tells how far it is."""


def repeat(seed: int, *, is_shrunk: bool) -> int:
    """Fly the mission of one seed and print its trace; return the exit status."""
    _be_quiet()
    verdict = fly(draw(seed))
    _print(describe(shrink(verdict) if is_shrunk and verdict.violations else verdict))
    return _status(failed=bool(verdict.violations), launched=0 if verdict.refused else 1)


def fly_all(seeds: Iterable[int], jobs: int, is_shrunk: bool) -> int:
    """Fly the missions of many seeds and print what failed; return the exit status."""
    _be_quiet()
    started_s, results, cpu_s = time.monotonic(), Counter[str](), 0.0
    failed: list[FlightVerdict] = []
    with multiprocessing.get_context("spawn").Pool(jobs, initializer=_be_quiet) as pool:
        for verdict, took_s in pool.imap_unordered(_fly_seed, [(seed, is_shrunk) for seed in seeds]):
            cpu_s += took_s
            results["refused" if verdict.refused else verdict.outcome] += 1
            if results.total() % PROGRESS == 0:
                _print(f"{results.total()} missions after {time.monotonic() - started_s:.0f} s, {len(failed)} failed")
            if verdict.violations:
                failed.append(verdict)
                _print(describe(verdict) + "\n")
    flown, wall_s = results.total(), time.monotonic() - started_s
    kinds = Counter(violation.kind for verdict in failed for violation in verdict.violations)
    _print(f"{flown} missions in {wall_s:.0f} s, {cpu_s / max(1, flown):.1f} s of CPU each: {_counts(results)}")
    for kind, reason in KNOWN_DEFECTS.items():
        _print(f"not drawn: {kind.__name__}: {reason}")
    _print(f"{len(failed)} failed{': ' if failed else ''}{_counts(kinds)}")
    if failed:
        _print("seeds: " + " ".join(str(verdict.scenario.seed) for verdict in failed))
    return _status(failed=bool(failed), launched=flown - results["refused"])


def _status(*, failed: bool, launched: int) -> int:
    """Return the exit status: a campaign of which nothing was launched has tested nothing."""
    if not launched:
        _print("No mission was launched: preflight has refused them all")
    return 1 if failed or not launched else 0


def _be_quiet() -> None:
    logging.getLogger().setLevel(logging.WARNING)
    logging.lastResort = None


def _fly_seed(task: tuple[int, bool]) -> tuple[FlightVerdict, float]:
    seed, is_shrunk = task
    before_s = time.process_time()
    verdict = fly(draw(seed))
    took_s = time.process_time() - before_s
    return (shrink(verdict) if is_shrunk and verdict.violations else verdict), took_s


def _counts(counts: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counts.most_common())


def describe(verdict: FlightVerdict) -> str:
    """Return the scenario of a mission, its latest notices, and what must not have happened."""
    trace = [f"    {line}" for line in verdict.trace[-TRACE_LINES:]]
    violations = [f"  => {violation}" for violation in verdict.violations]
    return "\n".join([verdict.scenario.describe(), *trace, *violations, f"  {verdict.refused or verdict.outcome}"])


def _print(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
