"""Repeat a test command beside busy processes and report every test that failed in any run.

``make soak-test`` calls it with the whole suite; ``RUNS=3 make soak-test`` repeats it three times. Everything that the
runs print is kept in ``.soak/``. The exit code is 0 when all runs passed.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FAILURE = re.compile(r"^(?:FAILED|ERROR) (\S+::.*?|\S+\.py)(?: - .*)?$", re.MULTILINE)
"""A line of pytest's short summary."""


@dataclass(frozen=True)
class Run:
    """Result of one run."""

    number: int
    passed: bool
    duration_s: float
    failures: tuple[str, ...]
    log: Path

    def __str__(self) -> str:
        state = "passed" if self.passed else f"FAILED ({len(self.failures)} tests, {self.log})"
        return f"run {self.number:2d}: {self.duration_s:7.1f} s  {state}"


def main(arguments: list[str]) -> int:
    """Run the command as often as asked for and return the exit code."""
    options = _options(arguments)
    options.logs.mkdir(parents=True, exist_ok=True)
    runs = []
    with _busy(options.busy):
        for number in range(1, options.runs + 1):
            runs.append(_run(number, options.command, options.logs / f"run-{number:02d}.log", 60.0 * options.limit_min))
            print(runs[-1], flush=True)
    failures = [failure for run in runs for failure in run.failures]
    for failure in sorted(set(failures), key=lambda name: (-failures.count(name), name)):
        print(f"failed {failures.count(failure)} of {len(runs)} times: {failure}")
    passed = sum(run.passed for run in runs)
    print(f"{passed} of {len(runs)} runs passed beside {options.busy} busy processes")
    return 0 if passed == len(runs) else 1


def _options(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10, help="number of runs (10)")
    parser.add_argument("--busy", type=int, default=2, help="number of busy processes beside them (2)")
    parser.add_argument("--limit-min", type=float, default=60.0, help="minutes after which a run is ended (60)")
    parser.add_argument("--logs", type=Path, default=ROOT / ".soak", help="folder of the runs' output (.soak)")
    parser.add_argument("command", nargs="+", help="the test command, after --")
    return parser.parse_args(arguments)


@contextmanager
def _busy(count: int) -> Iterator[None]:
    """Keep processors busy for as long as the context is entered, and in no case for longer than this process lives."""
    loop = f"import os\nwhile os.getppid() == {os.getpid()}:\n    sum(range(1_000_000))"
    processes = [subprocess.Popen([sys.executable, "-c", loop]) for _ in range(count)]  # noqa: S603 - our own text
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def _run(number: int, command: list[str], log: Path, limit_s: float) -> Run:
    """Run the command once; one that does not end in time is ended with all that it has started."""
    start_s = time.monotonic()
    with log.open("wb") as output:
        process = subprocess.Popen(command, stdout=output, stderr=output, start_new_session=True)  # noqa: S603
        try:
            code: int | None = process.wait(timeout=limit_s)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            _end(process)
    text = log.read_text(encoding="utf-8", errors="replace")
    failures = tuple(dict.fromkeys(FAILURE.findall(text)))
    return Run(number, code == 0, time.monotonic() - start_s, failures, log)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a command that still runs, and its children."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
