"""Order of the tests, and which of them one worker runs one after another."""

from __future__ import annotations

import pytest
from xdist.scheduler import LoadFileScheduling

FIRST = (
    "tests/browser",
    "tests/integration/test_demo",
    "tests/integration/test_run",
    "tests/integration/test_sim",
    "tests/integration/test_mission",
    "tests/integration",
    "tests/contract",
    "tests/unit/sim_vehicle",
    "tests/unit/test_imaging",
)
"""Beginnings of paths, the longest work first, so that all workers end at about the same time."""

ALONE = ("tests/browser",)
"""Folders whose modules share one worker: two browsers at once would wait for each other."""


def rank(item: pytest.Item) -> int:
    """Return the place of a test in the order; tests of equal rank keep theirs."""
    return next((place for place, beginning in enumerate(FIRST) if item.nodeid.startswith(beginning)), len(FIRST))


class Scheduling(LoadFileScheduling):
    """One module is one unit of work, so that what a module builds is built once; :data:`ALONE` is one unit, too."""

    def _split_scope(self, nodeid: str) -> str:
        module = nodeid.partition("::")[0]
        return next((folder for folder in ALONE if module.startswith(folder)), module)


def make_scheduler(config: pytest.Config, log: object) -> Scheduling:
    """Return the scheduler of ``pytest -n``; it keeps the order of the tests."""
    config.option.loadscopereorder = False
    return Scheduling(config, log)
