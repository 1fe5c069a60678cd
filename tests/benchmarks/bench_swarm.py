"""Times scattering, strategy steps and safety checks: ``python tests/benchmarks/bench_swarm.py``."""

import sys
import timeit
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from aos_gcs.airspace.limits import SafetyLimits
from aos_gcs.airspace.traffic import WaypointRequest
from aos_gcs.airspace.vetting import vet_waypoints
from aos_gcs.swarm.model import Observation
from aos_gcs.swarm.registry import available_strategies, make_strategy
from aos_gcs.swarm.scatter import DURATION_S, scatter
from tests.benchmarks.figures import report

REPEATS = 15
REPORTED = 30
"""Size of the swarms whose figures go into the table."""


def median_ms(function: Callable[[], object]) -> float:
    """Return the median of single calls, milliseconds."""
    return 1e3 * float(np.median(timeit.repeat(function, number=1, repeat=REPEATS)))


def swarm(n: int) -> tuple[np.ndarray, np.random.Generator]:
    """Return a line of n drones after a random step, and the generator that made it."""
    rng = np.random.default_rng(n)
    line_m = np.column_stack([4.2 * np.arange(n), np.zeros(n)])
    return line_m + rng.normal(scale=1.5, size=(n, 2)), rng


def published_scatter(positions_m: np.ndarray, charge_m: float) -> np.ndarray:
    """Return the positions after the published 500 explicit steps, to compare with."""
    for _ in range(500):
        d = positions_m[:, None] - positions_m[None, :]
        distances_m = np.linalg.norm(d, axis=2) + np.diag(np.full(len(positions_m), np.inf))
        positions_m = positions_m + DURATION_S / 500 * charge_m**2 * (d / distances_m[..., None] ** 3).sum(axis=1)
    return positions_m


def bench_scatter(n: int) -> tuple[float, float, float]:
    """Return the medians for dense swarms, of which some have close pairs; for drones in one spot; as published."""
    swarms_m = [np.random.default_rng(seed).normal(scale=np.sqrt(n), size=(n, 2)) for seed in range(REPEATS)]
    dense, published = iter(swarms_m), iter(swarms_m)
    return (
        median_ms(lambda: scatter(next(dense), 4.2, np.random.default_rng(0), leader=0)),
        median_ms(lambda: scatter(np.zeros((n, 2)), 4.2, np.random.default_rng(0), leader=0)),
        median_ms(lambda: published_scatter(next(published), 4.2)),
    )


def bench_strategy(name: str, n: int) -> float:
    """Return the time of one tell and ask in the PSO branch."""
    strategy, (positions_m, rng) = make_strategy(name, {}), swarm(n)
    observation = Observation(tuple(range(n)), positions_m, rng.uniform(size=n), True, np.array([0.0, 30.0]))
    state = strategy.init(np.array([0.0, 1.0]))
    return median_ms(lambda: strategy.ask(strategy.tell(state, observation), rng))


def bench_safety(n: int) -> float:
    """Return the time to vet the waypoints of n vehicles in a dense swarm."""
    rng = np.random.default_rng(n)
    side_m = 12.0 * np.sqrt(n)
    starts_m = np.column_stack([rng.uniform(0, side_m, (n, 2)), 35.0 + np.arange(n) % 10])
    ends_m = starts_m + np.column_stack([rng.normal(scale=4.0, size=(n, 2)), np.zeros(n)])
    fence_m = ((-9.0, -9.0), (side_m, -9.0), (side_m + 9.0, side_m + 9.0), (side_m / 2, side_m), (-9.0, side_m + 9.0))
    limits = SafetyLimits(fence_enu_m=fence_m, floor_m=20.0, ceiling_m=60.0, margin_m=2.0)
    movers = [
        WaypointRequest(
            vehicle_id=row,
            position_enu_m=start_m,
            requested_enu_m=end_m,
            link_age_s=0.1,
            position_age_s=0.1,
            battery_fraction=0.9,
        )
        for row, (start_m, end_m) in enumerate(zip(starts_m, ends_m, strict=True))
    ]
    return median_ms(lambda: vet_waypoints(movers, [], limits))


def main() -> None:
    """Print one line per measurement."""
    for n in (10, 30, 100):
        dense_ms, coincident_ms, published_ms = bench_scatter(n)
        vetting_ms = bench_safety(n)
        if n == REPORTED:
            report("swarm.scatter", dense_ms, ratio=dense_ms / published_ms)
            report("swarm.vetting", vetting_ms)
        sys.stdout.write(
            f"scatter            n = {n:3d}  {dense_ms:8.2f} ms, published {published_ms / dense_ms:.0f} times\n"
        )
        sys.stdout.write(f"scatter, one spot  n = {n:3d}  {coincident_ms:8.2f} ms\n")
        for name in available_strategies():
            sys.stdout.write(f"{name:18s} n = {n:3d}  {bench_strategy(name, n):8.2f} ms\n")
        sys.stdout.write(f"vet_waypoints      n = {n:3d}  {vetting_ms:8.2f} ms\n")


if __name__ == "__main__":
    main()
