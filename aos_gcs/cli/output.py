"""Log lines and progress on standard error. Standard output is left to results."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import StrEnum

import typer
from rich.console import Console
from rich.logging import RichHandler
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as RichProgress

Advance = Callable[[int], None]
"""Function that reports a number of further units of work as done."""

PLAIN_INTERVAL_S = 3.0


class LogLevel(StrEnum):
    """Names of the standard library's log levels."""

    DEBUG = "debug"
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


def configure_logging(level: LogLevel) -> None:
    """Send log records to standard error: coloured on a terminal, plain lines otherwise."""
    handler: logging.Handler
    if sys.stderr.isatty():
        handler = RichHandler(console=Console(stderr=True), show_path=False, log_time_format="[%X]")
    else:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True, format="%(message)s")


@contextmanager
def progress(description: str, total: int, monotonic: Callable[[], float] = time.monotonic) -> Iterator[Advance]:
    """Show how far a long piece of work is, and yield the function that advances it.

    A bar on a terminal; otherwise a line at most every :data:`PLAIN_INTERVAL_S` seconds, and one at the end of work
    that took longer than that.

    Args:
        description: name of the work, e.g. ``Integrating frames``.
        total: number of units of work.
        monotonic: clock in seconds, for the plain lines.
    """
    if sys.stderr.isatty():
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        with RichProgress(*columns, console=Console(stderr=True)) as bar:
            task = bar.add_task(description, total=total)
            yield lambda units: bar.advance(task, units)
    else:
        yield _plain_progress(description, total, monotonic)


def _plain_progress(description: str, total: int, monotonic: Callable[[], float]) -> Advance:
    done = 0
    started_s = last_s = monotonic()

    def advance(units: int) -> None:
        nonlocal done, last_s
        done += units
        now_s = monotonic()
        finished_late = done >= total and now_s - started_s >= PLAIN_INTERVAL_S
        if finished_late or now_s - last_s >= PLAIN_INTERVAL_S:
            last_s = now_s
            percent = 100 * done // max(total, 1)
            typer.echo(f"{description}: {done}/{total} ({percent} %)", err=True)

    return advance
