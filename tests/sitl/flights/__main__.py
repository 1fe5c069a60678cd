"""Fly three ArduCopters and three PX4s in software through what can go wrong, and print what came of it.

    python -m tests.sitl.flights --arducopter PATH/arducopter --px4 PATH/px4_sitl_default

Everything stays on this machine's loopback interface, every flight is bounded in time, and the processes that it
started are ended. Logs, records and the simulators' truth of each flight are kept in the folder of ``--logs``.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from aos_gcs.airspace.limits import UNLIMITED
from tests.sitl.flights.autopilots import ArduCopter, Autopilots, Kind, Px4
from tests.sitl.flights.scenarios import SCENARIOS, WITHOUT
from tests.sitl.flights.station import FlightError, Station


@dataclass(frozen=True)
class Row:
    """Result of one flight."""

    scenario: str
    autopilot: str
    passed: bool
    text: str
    distance_m: float | None
    duration_s: float

    def __str__(self) -> str:
        result = "passed" if self.passed else "**failed**"
        distance = "" if self.distance_m is None else f"{self.distance_m:.2f} m"
        return f"| {self.scenario} | {self.autopilot} | {result} | {self.text} | {distance} | {self.duration_s:.0f} s |"


HEADER = """| flight | 3 of | result | outcome | smallest true distance | real time |
|---|---|---|---|---|---|"""


def main() -> int:
    """Fly what is asked for and return the exit code."""
    options = _options()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # what was started is ended then, too
    kinds: list[Kind] = []
    if options.arducopter is not None:
        kinds.append(ArduCopter(options.arducopter.resolve(strict=True)))
    if options.px4 is not None:
        kinds.append(Px4(options.px4.resolve(strict=True)))
    rows = []
    for kind in kinds:
        for name in options.only or SCENARIOS:
            if name not in WITHOUT.get(kind.name, ()):
                rows.append(_fly(kind, name, options.logs.resolve(), options.limit_s))
                sys.stderr.write(f"{rows[-1]}\n")
    table = "\n".join(
        [HEADER, *map(str, rows), "", f"Load at the end: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores."]
    )
    sys.stdout.write(f"{table}\n")
    options.logs.mkdir(parents=True, exist_ok=True)
    (options.logs / "table.md").write_text(table + "\n", encoding="utf-8")
    return 0 if rows and all(row.passed for row in rows) else 1


def _fly(kind: Kind, name: str, logs: Path, limit_s: float) -> Row:
    folder = logs / f"{kind.name}-{name}"
    shutil.rmtree(folder, ignore_errors=True)  # a former mission that did not end would be taken up
    start_s = time.monotonic()
    station = Station(kind, folder, start_s + limit_s)
    with Autopilots(kind, folder) as autopilots:
        try:
            text, passed = SCENARIOS[name](autopilots, station), True
        except FlightError as error:
            text, passed = str(error), False
        if autopilots.dead():
            text, passed = f"{text}; simulators ended by themselves: {autopilots.dead()}", False
    distance_m, least_m = station.truth("min_separation_m"), UNLIMITED.separation_m
    if distance_m is not None and distance_m < least_m:
        text, passed = f"{text}; two vehicles came within {distance_m:.2f} m, where {least_m} m are configured", False
    return Row(name, kind.name, passed, text.replace("|", "/"), distance_m, time.monotonic() - start_s)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.sitl.flights", description=__doc__.splitlines()[0])
    parser.add_argument("--arducopter", type=Path, help="the program arducopter, built for SITL")
    parser.add_argument("--px4", type=Path, help="the folder of PX4's SITL that holds bin/px4 and etc")
    parser.add_argument("--only", action="append", choices=SCENARIOS, help="fly this one; may be repeated")
    parser.add_argument("--logs", type=Path, default=Path(".sitl"), help="folder of the logs (.sitl)")
    parser.add_argument("--limit-s", type=float, default=900.0, help="real time after which a flight is given up (900)")
    options = parser.parse_args()
    if options.arducopter is None and options.px4 is None:
        parser.error("name --arducopter, --px4, or both")
    return options


if __name__ == "__main__":
    raise SystemExit(main())
