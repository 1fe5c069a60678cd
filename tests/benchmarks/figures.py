"""Results of benchmarks in one form: a line for people, and a row for ``performance.py`` where it asks for rows."""

from __future__ import annotations

import json
import os
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
