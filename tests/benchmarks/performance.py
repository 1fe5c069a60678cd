"""Runs benchmarks and writes their figures into docs/performance.md.

Usage: ``python tests/benchmarks/performance.py [BENCHMARK ...]``, such as ``imaging render``; by default all that have
rows. Rows that a run does not measure stay as they are. ``--release VERSION`` measures nothing: it keeps the present
figures as those of that release.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.process import use_one_blas_thread
from tests.benchmarks.figures import ROWS_FILE

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
DATA = FOLDER / "performance.json"
TABLE = ROOT / "docs" / "performance.md"
HEAD = """# Performance

Written by `make bench` (`make bench ARGS="imaging render"` for some): every row is the median of its own run, on the
machine named in its last column; the ratio compares with a peer measured in the same run. A goal that the figure
misses is marked. Rows that a run leaves out keep their figures, with the commit that was measured. Commands to 20 and
50 vehicles are measured while each core analyses images.
"""
NONE_YET = "none yet"
"""Release of the figures before the first one."""
NO_RELEASE = "There has been no release yet.\n"
COLUMNS = """
| work | median | ratio to its peer | goal | last release | measured |
|---|---|---|---|---|---|
"""


GOAL = re.compile(r"(?P<of>ratio )?(?P<sign>[<≤±]) (?P<limit>[\d.]+)(?:/(?P<divisor>\d+))?")
"""Beginning of a goal that has a number, which is one of the figure's unit, or a ratio."""
OPTIONS = {"fleet": ("--busy",), "mission": ("1", "2", "3")}
"""Options of benchmarks: commands reach a fleet while every core analyses images; seeds of missions."""


def measure(names: Collection[str]) -> dict[str, dict[str, Any]]:
    """Run benchmarks one after another and return their figures by row; with one thread of BLAS, as all commands."""
    use_one_blas_thread()
    found: dict[str, dict[str, Any]] = {}
    for script in sorted(FOLDER.glob("bench_*.py")):
        name = script.stem.removeprefix("bench_")
        if name not in names:
            continue
        print(f"== {script.name}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            rows_file = Path(folder) / "rows"
            environment = {**os.environ, ROWS_FILE: str(rows_file)}
            command = [sys.executable, str(script), *OPTIONS.get(name, ())]
            subprocess.run(command, check=True, env=environment)  # noqa: S603 - our own program
            if rows_file.exists():
                lines = rows_file.read_text(encoding="utf-8").splitlines()
                found |= {row.pop("key"): row for row in map(json.loads, lines)}
    return found


def benchmarks_of(rows: Iterable[str]) -> set[str]:
    """Return the names of the benchmarks that measure rows."""
    return {key.partition(".")[0] for key in rows}


def stamp() -> dict[str, str]:
    """Return when, of which commit and on which machine the figures are."""
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"],  # noqa: S607 - of the developer
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    date = datetime.datetime.now(datetime.UTC).date().isoformat()
    return {"date": date, "commit": commit, "machine": f"{os.cpu_count()} cores, Python {platform.python_version()}"}


def is_missed(goal: str, value: float, ratio: float | None) -> bool:
    """Return whether a figure misses its goal; one without a number, such as *flat*, is left to the reader."""
    if (found := GOAL.match(goal)) is None:
        return False
    limit = float(found["limit"]) / float(found["divisor"] or 1)
    measured = ratio if found["of"] else value
    if measured is None:
        return False
    if found["sign"] == "±":
        return abs(measured) > limit
    return measured >= limit if found["sign"] == "<" else measured > limit


def line(row: dict[str, Any], release: str) -> str:
    """Return one row of the table."""
    measured = row.get("measured")
    released = row.get("release")
    dash, goal = "\N{EN DASH}", row.get("goal", "")
    if measured is not None and is_missed(goal, measured["value"], measured["ratio"]):
        goal += ": **missed**"
    cells = [
        row["work"],
        dash if measured is None else f"{measured['value']:.3g} {row['unit']}",
        dash if measured is None or measured["ratio"] is None else f"{measured['ratio']:.3g} ({row['peer']})",
        goal,
        dash if released is None else f"{released:.3g} {row['unit']} ({release})",
        "not yet" if measured is None else f"{measured['date']}, {measured['commit']}, {measured['machine']}",
    ]
    return f"| {' | '.join(cells)} |\n"


def table(data: dict[str, Any]) -> str:
    """Return docs/performance.md as it is for some data."""
    note = NO_RELEASE if data["release"] == NONE_YET else ""
    return HEAD + note + COLUMNS + "".join(line(row, data["release"]) for row in data["rows"].values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmarks", nargs="*", help="names without bench_; by default those with rows")
    parser.add_argument("--release", metavar="VERSION", help="keep the present figures as those of this release")
    options = parser.parse_args()
    data = json.loads(DATA.read_text(encoding="utf-8"))
    rows: dict[str, dict[str, Any]] = data["rows"]
    if options.release is not None:
        data["release"] = options.release
        for row in rows.values():
            row["release"] = row["measured"]["value"] if "measured" in row else None
    else:
        for key, figures in measure(options.benchmarks or benchmarks_of(rows)).items():
            rows[key]["measured"] = figures | stamp()
    DATA.write_text(json.dumps(data, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    TABLE.write_text(table(data), encoding="utf-8")


if __name__ == "__main__":
    main()
