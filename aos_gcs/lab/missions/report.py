"""Figures of the study of missions, with their intervals, and docs/missions.md."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aos_gcs.lab.document import DocumentFrame, document_frame
from aos_gcs.lab.missions.model import MissionResult, MissionsSettings
from aos_gcs.lab.report import markdown_table
from aos_gcs.lab.statistics import CONFIDENCE, PerHectare, Share, expected_calibration_error

BEGIN_MARK = "<!-- Written by aos-gcs lab missions; do not edit below -->"
_TITLE = "# Missions"
_RESAMPLES = 2000
_MIN_FOR_INTERVAL = 3
"""Values below which a figure has no interval worth the name."""
_MIN_FOR_CALIBRATION = 20
"""Findings below which probabilities cannot be compared with shares."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of several values with its bootstrap interval; NaN where there are too few."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class MissionGroup:
    """Figures of the missions of one density, condition and grade of errors."""

    trees_per_ha: float
    conditions: str
    errors: str
    with_person: int
    """Missions with a person."""
    without_person: int
    precision: Share
    """Claims that were right, over all missions of the group."""
    recall: Share
    """Persons that were found."""
    false_per_ha: PerHectare
    """False claims per searched hectare of the missions without a person."""
    claimed_after_s: Figure
    """Median time from the start to the claim of a person."""
    error_m: Figure
    """Median position error."""
    calibration_error: float
    """Expected error of the probabilities that findings are persons, weighing alike; NaN where there are too few."""
    findings: int
    """Findings that it rests on."""
    coverage: Figure
    """Mean share of the area that was in a frame."""
    false_convergences: Figure
    """Mean number per mission."""
    false_convergence_min: Figure
    """Mean time that they cost a mission, minutes."""
    duration_min: Figure
    """Mean duration of a mission, minutes."""
    min_separation_m: float
    """Smallest of all missions; NaN without any."""
    not_landed: int
    """Vehicles that did not stand on the ground at the end."""
    processor_s: float
    """Mean processor time of a mission."""
    predicted: float
    """Mean probability of detection that the plans promise; NaN without any."""
    noticed: Share
    """Persons at whom something was looked at closely, or who were found, of those with a prediction."""


def summarise(results: Iterable[MissionResult], vehicles: int) -> list[MissionGroup]:
    """Return the figures per density, condition and grade of errors, in this order."""
    groups: dict[tuple[float, str, str], list[MissionResult]] = {}
    for result in results:
        key = result.key
        groups.setdefault((key.trees_per_ha, key.conditions, key.errors), []).append(result)
    return [_group(groups[key], vehicles) for key in sorted(groups)]


def _group(results: Sequence[MissionResult], vehicles: int) -> MissionGroup:
    key = results[0].key
    empty = [one for one in results if not one.key.has_person]
    promised = [probability for one in results for probability in one.predicted]
    separations_m = [one.min_separation_m for one in results if one.min_separation_m is not None]
    return MissionGroup(
        trees_per_ha=key.trees_per_ha,
        conditions=key.conditions,
        errors=key.errors,
        with_person=len(results) - len(empty),
        without_person=len(empty),
        precision=Share.of(sum(one.true_claims for one in results), sum(one.claims for one in results)),
        recall=Share.of(sum(one.persons_found for one in results), sum(one.persons for one in results)),
        false_per_ha=PerHectare.of(sum(one.claims for one in empty), sum(one.coverage * one.area_ha for one in empty)),
        claimed_after_s=_figure([time_s for one in results for time_s in one.claimed_after_s], np.median),
        error_m=_figure([error_m for one in results for error_m in one.errors_m], np.median),
        calibration_error=_calibration_error(results),
        findings=sum(len(one.probabilities) for one in results),
        coverage=_figure([one.coverage for one in results], np.mean),
        false_convergences=_figure([one.false_convergences for one in results], np.mean),
        false_convergence_min=_figure([one.false_convergence_s / 60.0 for one in results], np.mean),
        duration_min=_figure([one.duration_s / 60.0 for one in results], np.mean),
        min_separation_m=min(separations_m, default=math.nan),
        not_landed=sum(vehicles - one.landed for one in results),
        processor_s=float(np.mean([one.processor_s for one in results])),
        predicted=float(np.mean(promised)) if promised else math.nan,
        noticed=Share.of(sum(one.persons_noticed for one in results if one.predicted), len(promised)),
    )


def _calibration_error(results: Sequence[MissionResult]) -> float:
    probabilities = np.array([stated for one in results for stated in one.probabilities])
    is_person = np.array([true for one in results for true in one.is_person], dtype=np.float64)
    count = len(probabilities)
    if count < _MIN_FOR_CALIBRATION:
        return math.nan
    return expected_calibration_error(probabilities, is_person, np.full(count, 1.0 / count))


def _figure(values: Sequence[float], statistic: Callable[[NDArray[np.float64]], np.floating]) -> Figure:
    sample = np.array(values, dtype=np.float64)
    value = float(statistic(sample)) if len(sample) else math.nan
    if len(sample) < _MIN_FOR_INTERVAL:
        return Figure(value, math.nan, math.nan)
    if np.ptp(sample) == 0.0:
        return Figure(value, value, value)
    # A second to import, which only what computes intervals should pay.
    from scipy import stats  # noqa: PLC0415

    interval = stats.bootstrap(
        (sample,), statistic, n_resamples=_RESAMPLES, confidence_level=CONFIDENCE, method="percentile", rng=0
    ).confidence_interval
    return Figure(value, float(interval.low), float(interval.high))


def as_markdown(groups: Sequence[MissionGroup]) -> str:
    """Return the figures as tables: what was claimed, what it cost, and what plans have promised, where they did."""
    claims = markdown_table(
        [
            "trees/ha",
            "conditions",
            "errors",
            "missions with, without a person",
            "precision of claims",
            "recall of persons",
            "false claims per searched ha without a person",
            "median error, m",
            "median time to a person's claim, s",
            "calibration error of findings",
        ],
        (
            [
                *_name(one),
                f"{one.with_person}, {one.without_person}",
                one.precision.text,
                one.recall.text,
                one.false_per_ha.text(2),
                _text(one.error_m, 2),
                _text(one.claimed_after_s, 0),
                "-" if math.isnan(one.calibration_error) else f"{one.calibration_error:.3f} (n = {one.findings})",
            ]
            for one in groups
        ),
    )
    costs = markdown_table(
        [
            "trees/ha",
            "conditions",
            "errors",
            "mean coverage, %",
            "false convergences per mission",
            "minutes they cost",
            "duration, min",
            "smallest separation, m",
            "vehicles not landed",
            "processor time per mission, s",
        ],
        (
            [
                *_name(one),
                _text(one.coverage, 1, 100.0),
                _text(one.false_convergences, 1),
                _text(one.false_convergence_min, 1),
                _text(one.duration_min, 1),
                f"{one.min_separation_m:.2f}",
                str(one.not_landed),
                f"{one.processor_s:.0f}",
            ]
            for one in groups
        ),
    )
    planned = [one for one in groups if one.noticed.trials]
    if not planned:
        return f"{claims}\n\n{costs}\n"
    promises = markdown_table(
        ["trees/ha", "conditions", "errors", "probability of detection, planned", "noticed", "found"],
        ([*_name(one), f"{one.predicted:.2f}", one.noticed.text, one.recall.text] for one in planned),
    )
    return f"{claims}\n\n{costs}\n\n{promises}\n"


def missions_frame(path: Path) -> DocumentFrame:
    """Return the text around the written part of the document; see ``aos_gcs.lab.document``."""
    return document_frame(path, BEGIN_MARK, _TITLE)


def write_document(
    path: Path, frame: DocumentFrame, settings: MissionsSettings, groups: Sequence[MissionGroup], tables: str
) -> None:
    """Write the document, or renew its written part: what was flown, and the tables of its figures."""
    flown = sum(one.with_person + one.without_person for one in groups)
    ground = f"{settings.terrain}, layers follow the ground" if settings.follow_ground else settings.terrain
    body = (
        f"n = {flown} missions of {settings.vehicles} vehicles with {settings.name} over "
        f"{settings.side_m:g} x {settings.side_m:g} m ({ground}), images of "
        f"{settings.image_size_px} x {settings.image_size_px} "
        f"pixels. In brackets: intervals of {100 * CONFIDENCE:.0f} % (shares by Wilson, rates by Poisson, the others "
        f"by bootstrap; none below {_MIN_FOR_INTERVAL} values).\n\n{tables.rstrip()}"
    )
    frame.write(path, body)


def _name(group: MissionGroup) -> tuple[str, str, str]:
    return f"{group.trees_per_ha:g}", group.conditions, group.errors


def _text(figure: Figure, digits: int, factor: float = 1.0) -> str:
    if math.isnan(figure.value):
        return "-"
    value = f"{factor * figure.value:.{digits}f}"
    if math.isnan(figure.low):
        return value
    return f"{value} ({factor * figure.low:.{digits}f} to {factor * figure.high:.{digits}f})"
