"""Durations, and results of benchmarks in one form: a line for people, and a row for ``performance.py`` if it asks."""

from __future__ import annotations

import json
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROWS_FILE = "AOS_GCS_BENCH_ROWS"
"""Environment variable that names the file to which rows are appended, one JSON object per line."""


def report(key: str, value: float, *, ratio: float | None = None) -> None:
    """Print a figure, and hand it on.

    Args:
        key: its row in ``performance.json``, which has its words, unit and goal.
        value: the median, in the row's unit.
        ratio: ours by the peer's, both measured in this run.
    """
    beside = "" if ratio is None else f", {ratio:.2f} of the peer"
    print(f"[{key}] {value:.4g}{beside}", flush=True)
    if rows_file := os.environ.get(ROWS_FILE):
        with Path(rows_file).open("a", encoding="utf-8") as rows:
            rows.write(json.dumps({"key": key, "value": value, "ratio": ratio}) + "\n")


@dataclass(frozen=True, slots=True)
class Durations:
    """Medians of wall and processor time; they differ by threads, and where other programs take the cores."""

    wall_s: float
    processor_s: float

    def __str__(self) -> str:
        return f"{self.wall_s:.3f} s (processor {self.processor_s:.3f} s)"


def median_durations(repetitions: int, action: Callable[[], object]) -> Durations:
    """Return the medians of some repetitions."""
    wall_s, processor_s = [], []
    for _ in range(repetitions):
        wall_start, processor_start = time.perf_counter(), time.process_time()
        action()
        wall_s.append(time.perf_counter() - wall_start)
        processor_s.append(time.process_time() - processor_start)
    return Durations(statistics.median(wall_s), statistics.median(processor_s))
