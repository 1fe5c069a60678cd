"""PSO and APSO against pymoo's PSO on the standard functions, rotated ones included."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aos_gcs.optimisers.apso import Apso
from aos_gcs.optimisers.model import Optimiser, Schedule
from aos_gcs.optimisers.pso import Pso, PsoParameters

pymoo_pso = pytest.importorskip("pymoo.algorithms.soo.nonconvex.pso", reason="needs pymoo (the extra dev)")
pymoo_problem = pytest.importorskip("pymoo.core.problem", reason="needs pymoo (the extra dev)")

FloatArray = NDArray[np.float64]
Objective = Callable[[FloatArray], FloatArray]
N, DIM = 25, 6


def sphere(x: FloatArray) -> FloatArray:
    return np.asarray((x**2).sum(axis=1))


def rosenbrock(x: FloatArray) -> FloatArray:
    return np.asarray((100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2).sum(axis=1))


def rastrigin(x: FloatArray) -> FloatArray:
    return np.asarray((x**2 - 10.0 * np.cos(2.0 * np.pi * x) + 10.0).sum(axis=1))


def griewank(x: FloatArray) -> FloatArray:
    waves = np.cos(x / np.sqrt(np.arange(1.0, x.shape[1] + 1.0))).prod(axis=1)
    return np.asarray((x**2).sum(axis=1) / 4000.0 - waves + 1.0)


def schwefel(x: FloatArray) -> FloatArray:
    return np.asarray(418.9828872724339 * x.shape[1] - (x * np.sin(np.sqrt(np.abs(x)))).sum(axis=1))


FUNCTIONS: dict[str, tuple[Objective, float]] = {
    "sphere": (sphere, 100.0),
    "rosenbrock": (rosenbrock, 10.0),
    "rastrigin": (rastrigin, 5.12),
    "griewank": (griewank, 600.0),
    "schwefel": (schwefel, 500.0),
}
"""Name to function and half the width of its search range."""


def rotated(objective: Objective) -> Objective:
    # A second to import, which only the process that runs these tests should pay.
    from scipy.stats import ortho_group  # noqa: PLC0415

    rotation = ortho_group.rvs(DIM, random_state=1)
    return lambda x: objective(x @ rotation)


def walled(objective: Objective, half_width: float) -> Objective:
    """Nothing outside of the range counts: particles that leave it are drawn back."""
    return lambda x: np.where((np.abs(x) <= half_width).all(axis=1), objective(x), np.inf)


def best_of(optimiser: Optimiser[Any], objective: Objective, half_width: float, steps: int, seed: int) -> float:
    rng = np.random.default_rng(seed)
    state = optimiser.init(rng.uniform(-half_width, half_width, (N, DIM)))
    for _ in range(steps):
        positions, state = optimiser.ask(state, rng)
        state = optimiser.tell(state, objective(positions))
    return optimiser.best(state)[1]


def pymoo_run(objective: Objective, half_width: float, start: FloatArray | None, **options: object) -> Any:
    """Return pymoo's algorithm, set up with its problem but not run."""

    class Problem(pymoo_problem.Problem):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            super().__init__(n_var=DIM, n_obj=1, xl=-half_width, xu=half_width)

        def _evaluate(self, x: FloatArray, out: dict[str, FloatArray], *_: object, **__: object) -> None:
            out["F"] = objective(x)[:, None]

    sampling = {} if start is None else {"sampling": start}
    algorithm = pymoo_pso.PSO(pop_size=N, initial_velocity="zero", pertube_best=False, **sampling, **options)
    return algorithm, Problem()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_trajectories_equal_those_of_pymoo(name: str) -> None:
    objective, half_width = FUNCTIONS[name]
    start = np.random.default_rng(5).uniform(-half_width, half_width, (N, DIM))
    # Its range is so wide that no particle leaves it, for there the two differ on purpose.
    algorithm, problem = pymoo_run(
        objective, 1e3 * half_width, start, adaptive=False, w=0.7, c1=1.4, c2=1.5, max_velocity_rate=1e-4
    )
    algorithm.setup(problem, termination=("n_gen", 41), seed=7)
    limit = Schedule(1e-4 * 2e3 * half_width)
    ours = Pso(PsoParameters(c_c=1.4, c_s=1.5, inertia=Schedule(0.7), max_velocity=limit))
    rng, state = np.random.default_rng(7), ours.init(start)
    for _ in range(40):
        asked = algorithm.ask()
        positions, state = ours.ask(state, rng)
        assert positions == pytest.approx(asked.get("X"), rel=1e-9, abs=1e-9 * half_width)
        algorithm.evaluator.eval(problem, asked)
        algorithm.tell(infills=asked)
        state = ours.tell(state, objective(positions))


def pymoo_best(objective: Objective, half_width: float, steps: int, seed: int, **options: object) -> float:
    algorithm, problem = pymoo_run(objective, half_width, None, **options)
    algorithm.setup(problem, termination=("n_gen", steps), seed=seed)
    while algorithm.has_next():
        algorithm.next()
    return float(algorithm.result().F[0])


@pytest.mark.slow
@pytest.mark.parametrize("rotate", [False, True], ids=["as is", "rotated"])
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("adaptive", [False, True], ids=["pso", "apso"])
def test_results_are_not_worse_than_those_of_pymoo(name: str, adaptive: bool, rotate: bool) -> None:
    objective, half_width = FUNCTIONS[name]
    objective = rotated(objective) if rotate else objective
    steps, seeds = 150, range(30)
    limit = Schedule(0.4 * half_width)
    if adaptive:
        optimiser: Optimiser[Any] = Apso(lower=-half_width, upper=half_width, moves=steps)
        options: dict[str, object] = {"adaptive": True}
    else:
        optimiser = Pso(PsoParameters(c_c=1.5, c_s=1.5, inertia=Schedule(0.7), max_velocity=limit))
        options = {"adaptive": False, "w": 0.7, "c1": 1.5, "c2": 1.5, "max_velocity_rate": 0.2}
    inside = walled(objective, half_width)
    ours = [best_of(optimiser, inside, half_width, steps, seed) for seed in seeds]
    theirs = [pymoo_best(objective, half_width, steps, seed, **options) for seed in seeds]
    from scipy.stats import mannwhitneyu  # noqa: PLC0415

    significance = mannwhitneyu(ours, theirs, alternative="greater").pvalue
    assert significance > 0.001, f"median {np.median(ours):g} against {np.median(theirs):g}, p = {significance:.2g}"
