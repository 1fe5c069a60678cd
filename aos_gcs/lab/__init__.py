"""The laboratory: swarm strategies compared in simulated forests, repeatably.

A notebook needs little more than this::

    from aos_gcs.lab import Scenario, draw_initialisations, open_world, parse_strategies, run_strategy
    from aos_gcs.lab.tables import to_table

    scenario = Scenario(trees_per_ha=400.0)
    (initialisation,) = draw_initialisations(1, seed=0, scenario=scenario)
    world = open_world(initialisation, scenario)
    for choice in parse_strategies("aos-pso,aos-apso(gamma=0.8)"):
        table = to_table(run_strategy(world, scenario, initialisation, choice.make(), choice.label))
"""

from aos_gcs.lab.experiment import run_strategy
from aos_gcs.lab.initialisation import Initialisation, draw_initialisations, open_world, paper_initialisations
from aos_gcs.lab.rows import StepRow
from aos_gcs.lab.scenario import Fidelity, Scenario, TimeModel, load_scenario, parse_scenario
from aos_gcs.lab.strategies import StrategyChoice, parse_strategies

__all__ = [
    "Fidelity",
    "Initialisation",
    "Scenario",
    "StepRow",
    "StrategyChoice",
    "TimeModel",
    "draw_initialisations",
    "load_scenario",
    "open_world",
    "paper_initialisations",
    "parse_scenario",
    "parse_strategies",
    "run_strategy",
]
