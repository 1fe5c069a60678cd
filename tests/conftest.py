"""Settings of the whole test suite."""

from __future__ import annotations

import asyncio
import gc
import inspect
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from aos_gcs.runtime.simulated import virtual_time
from tests import schedule, timing

# Tests run side by side on all cores: further threads of each process would only wait for one another. Processes that
# tests start inherit this; it is too late once NumPy and OpenCV are imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OPENCV_FOR_THREADS_NUM", "1")

_BUILD_KERNELS = Path(__file__).resolve().parents[1] / "scripts" / "build_kernels.py"

# A property that fails must fail for everybody; HYPOTHESIS_PROFILE=explore looks for new examples.
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.register_profile("thorough", derandomize=True, deadline=None, max_examples=500)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_configure() -> None:
    """Keep looptime from making an event loop, which nobody closes, in synchronous tests that run before others."""
    asyncio.set_event_loop(None)
    gc.disable()


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernels of imaging, as make does: later, some processes would work with them and others without."""
    if not hasattr(session.config, "workerinput"):
        subprocess.run([sys.executable, _BUILD_KERNELS], check=True)  # noqa: S603


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=schedule.rank)
    for item in items:
        timing.limit(item)
        timing.advance_promptly(item)


def pytest_collection_finish() -> None:
    """Collect garbage from here on, and none of what is here: looking through all modules is a tenth of the work.

    Workers that only compute give way from here on: before, all wait until each has imported everything.
    """
    gc.freeze()
    gc.enable()
    if (worker_id := os.environ.get("PYTEST_XDIST_WORKER")) is not None:
        os.nice(schedule.niceness(worker_id))


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> object | None:
    """Run a coroutine that is marked so in the loop in which missions are simulated."""
    test = inspect.unwrap(pyfuncitem.obj)
    if pyfuncitem.get_closest_marker("virtual") is None or not inspect.iscoroutinefunction(test):
        return None
    virtual_time.run(test(**{name: pyfuncitem.funcargs[name] for name in inspect.signature(test).parameters}))
    return True


@pytest.fixture(autouse=True)
def restored_logging() -> Iterator[None]:
    """Leave the root logger as it was: some tests run the command line, which sets it up, in their own process."""
    root = logging.getLogger()
    level, handlers = root.level, list(root.handlers)
    yield
    root.setLevel(level)
    root.handlers[:] = handlers


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return one worker per core, beside one with the browser and one that mostly waits for other processes."""
    return (os.cpu_count() or 1) + schedule.PROMPT_WORKERS


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> schedule.Scheduling:
    return schedule.make_scheduler(config, log)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Add up the durations per folder, where ``--durations`` is asked for."""
    if config.option.durations is None:
        return
    reports = [report for kind in terminalreporter.stats.values() for report in kind if hasattr(report, "duration")]
    terminalreporter.section("durations per folder")
    terminalreporter.write_line("\n".join(timing.by_folder(reports)))
