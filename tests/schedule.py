"""Order of the tests, and which of them one worker runs one after another."""

from __future__ import annotations

from collections.abc import Iterable

import pytest
from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

BROWSER = "tests/browser"
"""Folder whose modules share one worker but for those that wait: two busy browsers would wait for each other."""

WAITING = (
    "tests/integration/test_demo",
    "tests/contract/test_drivers.py [mavsdk]",
    "tests/contract/test_take_overs.py [mavsdk]",
    "tests/contract/test_vehicle_port.py [mavsdk]",
    "tests/integration/test_sim_",
    "tests/integration/test_api_process",
    "tests/integration/test_run_service",
    "tests/integration/test_sharing_tak",
    "tests/integration/test_replay_command",
    "tests/integration/test_frames_",
    "tests/contract/test_workers",
    "tests/browser/test_browser_failures",
)
"""Beginnings of units that mostly wait for other processes and threads. One worker runs them, one after another, while
the others compute: at the same time, they would leave the cores idle first and have all workers compute later."""

FIRST = (
    BROWSER,
    *WAITING,
    "tests/integration/test_mission",
    "tests/integration",
    "tests/faults",
    "tests/contract",
    "tests/unit/sim/vehicle",
    "tests/unit/imaging",
)
"""Beginnings of units, the longest work first, so that all workers end at about the same time."""

PROMPT_WORKERS = 2
"""Workers that begin with the browser and with what waits; no other work may make these late."""
_NICENESS = 5

_THREADED = "mavsdk"
"""Part of the name of a contract's case whose driver waits for threads, where others run in virtual time."""


def unit_of(nodeid: str) -> str:
    """Return the unit of work of a test: its module, all of :data:`BROWSER`, or the cases of a contract that wait."""
    module, _, test = nodeid.partition("::")
    if module.startswith(BROWSER) and not module.startswith(WAITING):
        return BROWSER
    is_threaded = module.startswith("tests/contract") and _THREADED in test.partition("[")[2]
    return f"{module} [{_THREADED}]" if is_threaded else module


def next_unit(units: Iterable[str], others: Iterable[str]) -> str:
    """Return which of the remaining units a worker takes: one that waits, unless another worker has such a one.

    Args:
        units: What is left, at least one, in the order of :func:`rank`.
        others: What the other workers have not ended yet.
    """
    left = list(units)
    must_compute = any(unit.startswith(WAITING) for unit in others)
    return next((unit for unit in left if unit == BROWSER or unit.startswith(WAITING) is not must_compute), left[0])


def niceness(worker_id: str) -> int:
    """Return by how much a worker gives way to others: those that only compute take what the others leave."""
    return _NICENESS if int(worker_id.removeprefix("gw")) >= PROMPT_WORKERS else 0


def rank(item: pytest.Item) -> int:
    """Return the place of a test in the order; tests of equal rank keep theirs."""
    unit = unit_of(item.nodeid)
    return next((place for place, beginning in enumerate(FIRST) if unit.startswith(beginning)), len(FIRST))


class Scheduling(LoadFileScheduling):
    """Gives out work by units, so that what a module builds is built once, and what waits beside what computes."""

    @property
    def nodes(self) -> list[WorkerController]:
        """Workers in the order of their names, so that the first ones begin with :data:`BROWSER` and what waits."""
        return sorted(super().nodes, key=lambda node: int(node.gateway.id.removeprefix("gw")))

    def _split_scope(self, nodeid: str) -> str:
        return unit_of(nodeid)

    def _assign_work_unit(self, node: WorkerController) -> None:
        others = (
            unit
            for other, work in self.assigned_work.items()
            for unit, tests in work.items()
            if other is not node and not all(tests.values())
        )
        self.workqueue.move_to_end(next_unit(self.workqueue, others), last=False)
        super()._assign_work_unit(node)


def make_scheduler(config: pytest.Config, log: object) -> Scheduling:
    """Return the scheduler of ``pytest -n``; it keeps the order of the tests."""
    config.option.loadscopereorder = False
    return Scheduling(config, log)
