"""Times the laboratory: ``OPENBLAS_NUM_THREADS=1 python tests/benchmarks/bench_lab.py``, as all commands compute.

Processor time is what a core of its own would take; wall time includes what other programs do meanwhile. The campaign
is computed by this process and by two Dask workers, their start included, in turn, so that both meet the same load.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.lab import (
    Fidelity,
    Initialisation,
    Scenario,
    StrategyChoice,
    draw_initialisations,
    open_world,
    parse_strategies,
    run_strategy,
)
from aos_gcs.lab.campaign import Campaign, run_initialisation
from aos_gcs.lab.results import create_results
from aos_gcs.lab.sensing import make_sensor
from aos_gcs.lab.studies import ALL, BETTER
from aos_gcs.lab.workers import compute
from aos_gcs.lab.worlds import Target, World
from tests.benchmarks.figures import median_durations, report

STRATEGIES = f"aos-pso,aos-pso(leader_stabilised=true),{BETTER}"
CAMPAIGN_INITIALISATIONS = 6
SHOWN_INITIALISATIONS = 5
REPETITIONS = 3


def main() -> None:
    """Print medians and ratios."""
    scenario = Scenario()
    (initialisation,) = draw_initialisations(1, 0, scenario)
    world = open_world(initialisation, scenario)
    time_work("build a forest of one hectare", 3, lambda: open_world(initialisation, scenario))
    for fidelity in Fidelity:
        bench_step(world, Scenario(fidelity=fidelity))
    for choice in parse_strategies(STRATEGIES):
        bench_run(world, scenario, initialisation, choice)
    bench_initialisation(scenario)
    bench_workers(scenario)


def bench_step(world: World, scenario: Scenario) -> None:
    """Print how long the frames of one step take."""
    sensor, rng = make_sensor(world, scenario), np.random.default_rng(0)
    positions_m = np.column_stack([4.2 * np.arange(10) - 18.9, np.full(10, 55.0), 35.0 + np.arange(10)])
    target = Target((0.0, 58.0))
    sensor.sense(positions_m, target, rng)  # light and textures are made once
    time_work(f"frames of one step, {scenario.fidelity}", 5, lambda: sensor.sense(positions_m, target, rng))


def bench_run(world: World, scenario: Scenario, initialisation: Initialisation, choice: StrategyChoice) -> None:
    """Print how long a run takes."""

    def run() -> None:
        deque(run_strategy(world, scenario, initialisation, choice.make(), choice.label), maxlen=0)

    _, processor_s = time_work(f"run of 20 s, {choice.label}", 3, run)
    if choice.label == BETTER:
        report("lab.run", processor_s)


def bench_initialisation(scenario: Scenario) -> None:
    """Print how long all strategies take in one initialisation, its forest included: the median of several."""
    campaign = Campaign(
        scenario, parse_strategies(",".join(ALL)), draw_initialisations(SHOWN_INITIALISATIONS, 1, scenario)
    )
    initialisations = iter(campaign.initialisations)
    what = f"{len(ALL)} strategies in one initialisation"
    wall_s, _ = time_work(what, SHOWN_INITIALISATIONS, lambda: run_initialisation(campaign, next(initialisations)))
    report("lab.initialisation", wall_s)


def bench_workers(scenario: Scenario) -> None:
    """Print how long a campaign takes with one worker and with two."""
    campaign = Campaign(
        scenario, parse_strategies(STRATEGIES), draw_initialisations(CAMPAIGN_INITIALISATIONS, 1, scenario)
    )
    wall_s: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(REPETITIONS):
        for jobs, durations_s in wall_s.items():
            with tempfile.TemporaryDirectory() as folder:
                results = create_results(Path(folder) / "campaign", campaign)
                start_s = time.perf_counter()
                compute(results, lambda _: None, jobs=jobs)
                durations_s.append(time.perf_counter() - start_s)
    one_s, two_s = (statistics.median(durations_s) for durations_s in wall_s.values())
    runs = len(campaign.strategies) * len(campaign.initialisations)
    for jobs, duration_s in ((1, one_s), (2, two_s)):
        sys.stdout.write(f"{f'{runs} runs, workers: {jobs}':48s}{duration_s:.1f} s\n")
    sys.stdout.write(f"{'speed-up from one worker to two':48s}{one_s / two_s:.2f}\n")


def time_work(what: str, repetitions: int, action: Callable[[], object]) -> tuple[float, float]:
    """Print and return medians of wall and processor time."""
    durations = median_durations(repetitions, action)
    sys.stdout.write(f"{what:48s}{durations}\n")
    sys.stdout.flush()
    return durations.wall_s, durations.processor_s


if __name__ == "__main__":
    main()
