"""docs/results.md: the tables of the studies, written by the program from their rows, beside a discussion by hand."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.calibration import SingleViewVisibility
from aos_gcs.lab.claims import Claim, paper_claims
from aos_gcs.lab.report import Comparison, compare, difference_table, markdown_table, summary_table, write_report
from aos_gcs.lab.results import ResultFolder
from aos_gcs.lab.statistics import Interval, mean_interval
from aos_gcs.lab.studies import BETTER, REFERENCE, STUDIES, Study

FIGURES: Mapping[str, Sequence[str]] = {
    "paper": (
        "mean_visibility",
        "evolutionary_factor",
        "trajectories_paper-1_1",
        "trajectories_paper-2_1",
        "trajectories_paper-2_3",
        "run_paper-1_1",
        "run_paper-2_3",
        "run_paper-2_4",
    ),
    "integral": ("mean_visibility", "difference_visibility_mean", "evolutionary_factor"),
    "static-300": (
        "mean_visibility",
        "mean_area_m2",
        "mean_history_visibility",
        "difference_visibility_mean",
        "runs_detection_s",
        "runs_path_m",
    ),
    "static-400": ("mean_visibility",),
    "static-500": ("mean_visibility",),
    "walking-1.5": ("mean_visibility",),
    "walking-4": ("mean_visibility",),
    "dynamics": ("mean_visibility",),
    "imaging": ("mean_visibility",),
}
"""Figures of each study's report that the document shows."""

BEGIN_MARK = "<!-- Written by aos-gcs lab reproduce; do not edit below -->"
END_MARK = "<!-- End of the written part -->"


@dataclass(frozen=True, slots=True)
class Goal:
    """Goal set for the better strategy before it was built, and what it has reached."""

    text: str
    reached: str
    met: bool


@dataclass(frozen=True, slots=True)
class DocumentFrame:
    """Text before and after the written part."""

    before: str
    after: str
    begin_mark: str = BEGIN_MARK

    def write(self, path: Path, body: str) -> None:
        """Write the whole document, in a new folder where there is none."""
        path.parent.mkdir(parents=True, exist_ok=True)
        text = f"{self.before}{self.begin_mark}\n\n{body}\n\n{END_MARK}\n{self.after}"
        path.write_text(text, encoding="utf-8")


def write_document(
    results: Mapping[str, ResultFolder],
    calibration: Mapping[float, SingleViewVisibility],
    path: Path,
    frame: DocumentFrame,
) -> None:
    """Write the document, its figures beside it in a folder of its name, and each study's full report in its folder.

    Args:
        results: results of all studies, by name.
        calibration: single-view visibility by trees per hectare.
        path: path of the Markdown file.
        frame: text around the written part, from :func:`document_frame`.
    """
    pictures = path.with_suffix("")
    pictures.mkdir(parents=True, exist_ok=True)
    comparisons = {study.name: _report(study, results[study.name]) for study in STUDIES}
    for study in STUDIES:
        for name in FIGURES[study.name]:
            shutil.copyfile(
                results[study.name].folder / "report" / f"{name}.png", pictures / f"{study.name}-{name}.png"
            )
    sections = [
        *_introduction(comparisons),
        _calibration(calibration),
        *_claims(comparisons["integral"]),
        *_goals(comparisons),
        *(part for study in STUDIES for part in _study(study, comparisons[study.name], pictures.name)),
    ]
    frame.write(path, "\n\n".join(sections))


def document_frame(
    path: Path, begin_mark: str = BEGIN_MARK, title: str = "# Results of the swarm strategies"
) -> DocumentFrame:
    """Return the text around the written part of an existing document, such as a discussion, or that of a new one.

    Raises:
        ConfigurationError: the document exists without the marks, so that writing it would lose text, or it cannot be
            written.
    """
    there = next(folder for folder in path.absolute().parents if folder.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        raise ConfigurationError(f"--document {path} cannot be written: {there} is a file, or closed to you.")
    if not path.exists():
        return DocumentFrame(f"{title}\n\n", "", begin_mark)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"--document {path} is no text file that can be renewed: name another one.") from error
    before, begin, rest = text.partition(begin_mark)
    _, end, after = rest.partition(END_MARK)
    if not (begin and end):
        raise ConfigurationError(
            f"{path} would be overwritten: it lacks the lines '{begin_mark}' and '{END_MARK}' around the part to be "
            "renewed. Add them, or choose another file with --document."
        )
    return DocumentFrame(before, after.removeprefix("\n"), begin_mark)


def _report(study: Study, results: ResultFolder) -> Comparison:
    labels = [choice.label for choice in results.campaign.strategies]
    comparison = compare(results.campaign.scenario, labels, results.read())
    write_report(comparison, results.folder / "report", reference=study.reference, shown_runs=3 if study.paper else 1)
    return comparison


def _introduction(comparisons: Mapping[str, Comparison]) -> Iterator[str]:
    count = max(len(comparison.initialisations) for comparison in comparisons.values())
    yield (
        f"## Figures\n\nWritten by `aos-gcs lab reproduce --initialisations {count}`. laboratory.md defines V, A and "
        "the oracle. Intervals contain the mean with 95 % confidence. All initialisations are held out: no strategy "
        "was developed on them."
    )


def _calibration(calibration: Mapping[float, SingleViewVisibility]) -> str:
    rows = [
        [
            f"{density:g}",
            f"{each.mean:.3f} ± {each.standard_error:.3f}",
            f"{each.lower_quartile:.3f} to {each.upper_quartile:.3f}",
        ]
        for density, each in calibration.items()
    ]
    table = markdown_table(["trees/ha", "visible share in a single view", "half of the forests within"], rows)
    return (
        "### The forest\n\nA single nadir view from within 12 m sees this share of a standing person (mean and its "
        f"standard error over forests); 15 to 20 % at 300 trees/ha is what the forest is made for.\n\n{table}"
    )


def _claims(comparison: Comparison) -> Iterator[str]:
    count = len(comparison.initialisations)
    yield (
        f"### Claims of the paper\n\nTested on {count} drawn initialisations with the paper's settings and the leader "
        "criterion `integral`, which resembles its curves; the rules behind the verdicts are in "
        "`aos_gcs/lab/claims.py`."
    )
    yield markdown_table(["claim", "measured here", "holds here"], map(_claim_row, paper_claims(comparison)))


def _claim_row(claim: Claim) -> list[str]:
    return [claim.text, claim.measured, "yes" if claim.holds else "no"]


def _goals(comparisons: Mapping[str, Comparison]) -> Iterator[str]:
    yield (
        f"### Goals of {BETTER}\n\nAgainst {REFERENCE} with the leader criterion `contribution`, on the studies below."
    )
    yield markdown_table(
        ["goal", "reached", "met"],
        [[goal.text, goal.reached, "yes" if goal.met else "no"] for goal in better_goals(comparisons)],
    )


def better_goals(comparisons: Mapping[str, Comparison]) -> Iterable[Goal]:
    """Measure the better strategy by what was asked of it, before it was built."""
    static = comparisons["static-300"]
    values = static.metrics[BETTER]
    gain = _gain(static, "visibility_mean")
    yield Goal(
        "V from 5 s on: +0.25, the interval's lower end above +0.20",
        f"{gain.mean:+.3f} ({gain.low:+.3f} to {gain.high:+.3f})",
        gain.mean >= 0.25 and gain.low > 0.20,
    )
    area = _gain(static, "area_mean_m2").mean / static.metrics[REFERENCE]["area_mean_m2"].mean()
    yield Goal("at least 20 % more visible area", f"{100 * area:+.0f} %", area >= 0.20)
    oracle = static.oracle("visibility")
    if oracle is not None:
        share = values["visibility_look"].mean() / oracle.mean()
        yield Goal("0.85 of the oracle at 14 s", f"{share:.2f}", share >= 0.85)
    lowest = float(np.percentile(values["visibility_look"], 10))
    yield Goal("tenth percentile of V at 14 s at least 0.65", f"{lowest:.2f}", lowest >= 0.65)
    for name, asked in (("walking-1.5", 0.13), ("walking-4", 0.10)):
        yield _gain_goal(comparisons[name], f"{comparisons[name].scenario.target_speed_mps:g} m/s", asked)
    for name, asked in (("static-400", 0.25), ("static-500", 0.12)):
        yield _gain_goal(comparisons[name], f"{comparisons[name].scenario.trees_per_ha:g} trees/ha", asked)
    history = _gain(static, "history_look")
    yield Goal(
        "with history at 14 s no worse",
        f"{history.mean:+.3f} ({history.low:+.3f} to {history.high:+.3f})",
        history.mean >= 0.0,
    )


def _gain_goal(comparison: Comparison, condition: str, asked: float) -> Goal:
    gain = _gain(comparison, "visibility_mean")
    reached = f"{gain.mean:+.3f} ({gain.low:+.3f} to {gain.high:+.3f})"
    return Goal(f"{condition}: V at least {asked:+.2f}", reached, gain.mean >= asked)


def _gain(comparison: Comparison, metric: str) -> Interval:
    return mean_interval(comparison.metrics[BETTER][metric] - comparison.metrics[REFERENCE][metric])


def _study(study: Study, comparison: Comparison, pictures: str) -> Iterator[str]:
    yield f"### {study.title}"
    settings = ", ".join(f"{name} = {value}" for name, value in study.scenario.items())
    yield f"{len(comparison.initialisations)} initialisations; {settings or 'default scenario'}."
    yield summary_table(comparison)
    yield difference_table(comparison, study.reference)
    for name in FIGURES[study.name]:
        yield f"![{study.title}: {name.replace('_', ' ')}]({pictures}/{study.name}-{name}.png)"
