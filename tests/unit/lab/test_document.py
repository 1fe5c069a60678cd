"""The studies behind the results, and how the better strategy is measured by what was asked of it."""

import pyarrow as pa
import pytest

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.bound import ORACLE
from aos_gcs.lab.document import FIGURES, better_goals, document_frame
from aos_gcs.lab.report import Comparison, compare
from aos_gcs.lab.scenario import Scenario
from aos_gcs.lab.studies import BETTER, REFERENCE, STUDIES
from tests.fakes.lab_rows import run_at


def comparison(levels: dict[str, float], speed_mps: float = 0.0, trees_per_ha: float = 300.0) -> Comparison:
    """Runs whose V, A and history stay at a level, a little higher in every further initialisation."""

    rows = pa.concat_tables(
        [run_at(level + 0.01 * number, name, str(number)) for name, level in levels.items() for number in range(5)]
    )
    return compare(Scenario(target_speed_mps=speed_mps, trees_per_ha=trees_per_ha), [REFERENCE, BETTER], rows)


def goals(better: float, walking: float, oracle: float = 0.8, dense: float = 0.5) -> list[bool]:
    comparisons = {
        "static-300": comparison({REFERENCE: 0.4, BETTER: better, ORACLE: oracle}),
        "walking-1.5": comparison({REFERENCE: 0.3, BETTER: walking}, 1.5),
        "walking-4": comparison({REFERENCE: 0.3, BETTER: walking}, 4.0),
        "static-400": comparison({REFERENCE: 0.2, BETTER: dense}, trees_per_ha=400.0),
        "static-500": comparison({REFERENCE: 0.2, BETTER: dense}, trees_per_ha=500.0),
    }
    return [goal.met for goal in better_goals(comparisons)]


def test_a_strategy_that_reaches_everything_meets_all_goals() -> None:
    assert goals(better=0.75, walking=0.45) == [True] * 9


def test_each_goal_is_judged_by_its_own_measure() -> None:
    gain, area, oracle, lowest, slow, fast, denser, densest, history = goals(better=0.54, walking=0.45)
    assert (gain, area, oracle, lowest) == (False, True, False, False)
    assert (slow, fast, denser, densest, history) == (True, True, True, True, True)
    assert goals(better=0.75, walking=0.35)[4:6] == [False, False]
    assert goals(better=0.35, walking=0.45)[8] is False
    assert goals(better=0.75, walking=0.45, dense=0.35)[6:8] == [False, True]


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_studies_can_be_run_and_their_figures_are_named(study) -> None:
    campaign = study.campaign(5)
    labels = [choice.label for choice in campaign.strategies]
    assert study.reference in labels
    assert 1 <= len(campaign.initialisations) <= 5
    assert FIGURES[study.name]


def test_studies_have_names_of_their_own() -> None:
    assert len({study.name for study in STUDIES}) == len(STUDIES) == len(FIGURES)


def test_renewing_a_document_keeps_the_text_around_the_figures(tmp_path) -> None:
    document = tmp_path / "results.md"
    document_frame(document).write(document, "first figures")
    document.write_text("# Title\n\ndiscussion\n\n" + document.read_text().partition("\n\n")[2] + "\nappendix\n")
    document_frame(document).write(document, "second figures")
    text = document.read_text()
    assert text.startswith("# Title\n\ndiscussion\n\n<!--")
    assert text.endswith("\nappendix\n")
    assert "second figures" in text
    assert "first figures" not in text


def test_a_document_without_marks_is_not_overwritten(tmp_path) -> None:
    document = tmp_path / "results.md"
    document.write_text("# My own text\n")
    with pytest.raises(ConfigurationError, match=r"results\.md would be overwritten"):
        document_frame(document)
