"""The campaigns behind docs/results.md, as data, and how they are run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from aos_gcs.imaging.model import LeaderCriterion
from aos_gcs.lab.campaign import Campaign
from aos_gcs.lab.claims import PAPER_STRATEGIES
from aos_gcs.lab.initialisation import draw_initialisations, paper_initialisations
from aos_gcs.lab.results import ResultFolder, create_results
from aos_gcs.lab.scenario import Fidelity, Scenario, TimeModel, parse_scenario
from aos_gcs.lab.strategies import parse_strategies
from aos_gcs.lab.worlds import ErrorGrade

HELD_OUT_SEED = 0
"""Seed of the initialisations that strategies are judged on; they are developed on other seeds."""
SOME = 20
"""Initialisations of the studies beside the main one."""
MORE = 30
"""Initialisations of those with walking persons, whose gain is smaller."""
FEW = 4
"""Initialisations of the study with rendered images, whose runs take a minute or two each."""

REFERENCE = "aos-pso"
BETTER = "aos-apso"
PAPER = "aos-apso-paper"
ALL = (
    "blind-sequential",
    "blind-parallel",
    REFERENCE,
    "aos-pso-stabilised",
    PAPER,
    "aos-apso-untuned",
    "aos-archive",
    BETTER,
)
RIVALS = (REFERENCE, PAPER, BETTER)


@dataclass(frozen=True, slots=True)
class Study:
    """One campaign of the results."""

    name: str
    """Name of the study's folder."""
    title: str
    strategies: tuple[str, ...]
    scenario: Mapping[str, object] = field(default_factory=dict)
    paper: bool = False
    """Whether the three fixed initialisations are used instead of drawn ones."""
    at_most: int | None = None
    """Bound on the number of initialisations."""
    oracle: bool = False

    @property
    def reference(self) -> str:
        """The strategy that the others are compared with."""
        return REFERENCE if REFERENCE in self.strategies else self.strategies[0]

    def campaign(self, initialisations: int) -> Campaign:
        """Return what to compute, with so many drawn initialisations."""
        scenario: Scenario = parse_scenario(self.scenario)
        count = min(initialisations, self.at_most or initialisations)
        starts = paper_initialisations() if self.paper else draw_initialisations(count, HELD_OUT_SEED, scenario)
        return Campaign(scenario, parse_strategies(",".join(self.strategies)), starts, oracle=self.oracle)


_INTEGRAL = {"leader_criterion": str(LeaderCriterion.INTEGRAL)}

STUDIES = (
    Study("paper", "The paper's experiment, three fixed initialisations", PAPER_STRATEGIES, _INTEGRAL, paper=True),
    Study("integral", "The paper's experiment, drawn initialisations", PAPER_STRATEGIES, _INTEGRAL),
    Study("static-300", "A standing person who stays, 300 trees/ha", ALL, oracle=True),
    Study("static-400", "400 trees/ha", RIVALS, {"trees_per_ha": 400.0}, at_most=SOME, oracle=True),
    Study("static-500", "500 trees/ha", RIVALS, {"trees_per_ha": 500.0}, at_most=SOME, oracle=True),
    Study("walking-1.5", "A person who walks at 1.5 m/s", RIVALS, {"target_speed_mps": 1.5}, at_most=MORE),
    Study("walking-4", "A person who runs at 4 m/s", RIVALS, {"target_speed_mps": 4.0}, at_most=MORE),
    Study(
        "dynamics",
        "Vehicles that accelerate, 0.6 s of processing per step",
        (*RIVALS, "aos-archive"),
        {"time_model": str(TimeModel.DYNAMICS), "duration_s": 60.0},
        at_most=SOME,
    ),
    Study(
        "imaging",
        "Rendered images through the imaging engine",
        RIVALS,
        {"fidelity": str(Fidelity.IMAGING), "errors": str(ErrorGrade.NONE), "image_size_px": 256, "duration_s": 10.0},
        at_most=FEW,
    ),
)


def run_studies(
    folder: Path,
    initialisations: int,
    compute: Callable[[ResultFolder, str], None],
) -> dict[str, ResultFolder]:
    """Run what is missing of all studies, each in its own folder, and return their results by name.

    Args:
        folder: folder of all studies; an interrupted call continues in it.
        initialisations: number of drawn initialisations per study.
        compute: computes what is missing in a result folder; its second argument is the study's title.

    Raises:
        ConfigurationError: a folder holds another campaign or cannot be written.
    """
    results = {}
    for study in STUDIES:
        results[study.name] = create_results(folder / study.name, study.campaign(initialisations))
        compute(results[study.name], study.title)
    return results
