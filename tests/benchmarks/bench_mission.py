"""Whole simulated missions: what they reach, and what a step costs the coordinator.

Usage: ``python tests/benchmarks/bench_mission.py [SEED ...]``, by default seed 1; each takes two to four minutes. The
options of ``aos-gcs demo`` that follow a ``--`` are passed on.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from aos_gcs.store.reader import MissionReader

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from tests.benchmarks.figures import report

COLUMNS = "seed found error_m detection_s visibility_max steps landed separation_m work_ms lag_p99_ms"


def fly(seed: str, options: list[str], folder: str) -> tuple[dict[str, object], list[float], list[float]]:
    """Return the result of one demo, the work per step and the event loop's lag (p99 per step), milliseconds."""
    command = [sys.executable, "-m", "aos_gcs", "--log-level", "warning", "demo", "--headless", "--exit-when-done"]
    done = subprocess.run(  # noqa: S603 - our own program
        [*command, "--json", "--seed", seed, "--folder", folder, *options], stdout=subprocess.PIPE, check=False
    )
    result = json.loads(done.stdout)
    with MissionReader(Path(result["mission_dir"])) as reader:
        steps = reader.steps()
    return result, [step.work_ms for step in steps], [step.loop_lag_p99_ms for step in steps]


def main(arguments: list[str]) -> None:
    """Fly the seeds one after another and print a line each, and the medians over all steps."""
    split = arguments.index("--") if "--" in arguments else len(arguments)
    seeds, options = arguments[:split] or ["1"], arguments[split + 1 :]
    all_work_ms, all_lags_ms = [], []
    print(COLUMNS)
    with tempfile.TemporaryDirectory() as folder:
        for seed in seeds:
            result, work_ms, lags_ms = fly(seed, options, folder)
            all_work_ms += work_ms
            all_lags_ms += lags_ms
            figures = [result[key] for key in ("target_error_m", "time_to_detection_s", "visibility_max")]
            print(
                seed,
                result["found"],
                *("-" if figure is None else f"{figure:.2f}" for figure in figures),
                result["steps"],
                f"{result['landed']}/{result['vehicles']}",
                f"{result['min_separation_m']:.2f}",
                f"{np.median(work_ms):.0f}",
                f"{max(lags_ms):.1f}",
                flush=True,
            )
    report("mission.work", float(np.median(all_work_ms)))
    report("mission.lag", max(all_lags_ms))
    print(
        f"{len(all_work_ms)} steps: work per step, median {np.median(all_work_ms):.0f} ms, "
        f"90th percentile {np.percentile(all_work_ms, 90):.0f} ms; "
        f"loop lag, p99 per step, median {np.median(all_lags_ms):.1f} ms, worst {max(all_lags_ms):.1f} ms"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
