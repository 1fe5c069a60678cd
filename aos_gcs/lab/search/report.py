"""Figures of the study of searches: what is found at which rate, when, and whether that was predicted."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aos_gcs.lab.document import DocumentFrame, document_frame
from aos_gcs.lab.report import markdown_table
from aos_gcs.lab.search.model import Method, SearchOutcome, SearchResult, SearchStudySettings
from aos_gcs.lab.statistics import CONFIDENCE, Share

BEGIN_MARK = "<!-- Written by aos-gcs lab search; do not edit below -->"
_TITLE = "# Whole searches"
_BINS = 10
"""Bins of predicted probability in which predictions are compared with what was noticed."""
_TOGETHER = frozenset(Method) - {Method.STOPS, Method.LAWNMOWER}
"""Methods in flight whose views count together: those for which the map predicts."""


@dataclass(frozen=True, slots=True)
class SearchGroup:
    """Figures of a method, with some vehicles over an area of one size and density."""

    trees_per_ha: float
    hectares: float
    vehicles: int
    method: Method
    noticed: Share
    """Persons noticed in the first flight."""
    predicted: float
    """Mean probability of detection by the map, at the persons' places."""
    duration_s: float
    path_m: float
    claimed: int
    """Persons claimed after all flights."""
    claimed_s: float
    """Median time to the claim; those that were never noticed count as later than all others."""
    ratio: float
    """Median over the persons of this time, over that of the lawnmower; NaN without one."""
    of_plain: float = math.nan
    """The same over that of the legs to and fro, for legs in the order of a prior; NaN for others."""

    @property
    def hectares_per_hour(self) -> float:
        """Area over the time of the first flight."""
        return self.hectares / (self.duration_s / 3600.0)


@dataclass(frozen=True, slots=True)
class MapCalibration:
    """Predictions by the map beside what was noticed."""

    trees_per_ha: float
    searches: int
    bins: tuple[tuple[float, float, int], ...]
    """Mean prediction, share noticed and number of searches, by tenths of the prediction."""
    error: float
    """Mean difference of prediction and share over the bins, weighted by their searches."""
    bias: float
    """Mean prediction minus share noticed, over all."""


@dataclass(frozen=True, slots=True)
class SearchFigures:
    """Figures of a study."""

    searches: int
    """Persons that were searched for."""
    groups: tuple[SearchGroup, ...]
    calibrations: tuple[MapCalibration, ...]
    rendered: int
    """Searches of which the frames were rendered."""
    rendered_noticed: int
    """Searches in which rendered frames notice the person."""
    rays_noticed: int
    """Searches in which rays notice the person."""
    agreed: int
    """Searches in which frames and rays agree."""


def summarise(results: Sequence[SearchResult]) -> SearchFigures:
    """Return the figures of a study."""
    by_group: dict[tuple[float, float, int, Method], list[tuple[int, SearchOutcome]]] = {}
    for result in results:
        for one in result.outcomes:
            key = result.key.trees_per_ha, one.hectares, one.vehicles, one.method
            by_group.setdefault(key, []).append((result.key.seed, one))
    groups = []
    for (trees, hectares, vehicles, method), outcomes in sorted(by_group.items(), key=lambda item: _order(item[0])):
        lawnmower, plain = (
            dict(by_group.get((trees, hectares, vehicles, rival), ())) for rival in (Method.LAWNMOWER, Method.PLANNED)
        )
        times_s = {seed: math.inf if one.claimed_s is None else one.claimed_s for seed, one in outcomes}
        found = [one for _, one in outcomes]
        groups.append(
            SearchGroup(
                trees_per_ha=trees,
                hectares=hectares,
                vehicles=vehicles,
                method=method,
                noticed=Share.of(sum(one.noticed for one in found), len(found)),
                predicted=float(np.mean([one.predicted for one in found])),
                duration_s=found[0].duration_s,
                path_m=found[0].path_m,
                claimed=sum(one.claimed_s is not None for one in found),
                claimed_s=float(np.median(list(times_s.values()))),
                ratio=_ratio(times_s, lawnmower),
                of_plain=_ratio(times_s, plain) if method is Method.PRIOR else math.nan,
            )
        )
    rendered = [one for result in results for one in result.outcomes if one.rendered is not None]
    return SearchFigures(
        searches=len(results),
        groups=tuple(groups),
        calibrations=_calibrations(results),
        rendered=len(rendered),
        rendered_noticed=sum(bool(one.rendered) for one in rendered),
        rays_noticed=sum(one.noticed for one in rendered),
        agreed=sum(one.rendered == one.noticed for one in rendered),
    )


def _ratio(times_s: Mapping[int, float], rivals: Mapping[int, SearchOutcome]) -> float:
    """Return the median of times over those of a rival's searches for the same persons; NaN without any."""
    ratios = [
        times_s[seed] / rival.claimed_s
        for seed, rival in rivals.items()
        if seed in times_s and rival.claimed_s is not None
    ]
    return float(np.median(ratios)) if ratios else math.nan


def _order(key: tuple[float, float, int, Method]) -> tuple[float, float, int, int]:
    trees, hectares, vehicles, method = key
    return trees, hectares, vehicles, list(Method).index(method)


def _calibrations(results: Sequence[SearchResult]) -> tuple[MapCalibration, ...]:
    calibrations = []
    for trees in sorted({result.key.trees_per_ha for result in results}):
        own = [
            one
            for result in results
            for one in result.outcomes
            if result.key.trees_per_ha == trees and one.method in _TOGETHER
        ]
        if not own:
            continue
        predicted, noticed = np.array([one.predicted for one in own]), np.array([one.noticed for one in own])
        index = np.minimum((predicted * _BINS).astype(np.int64), _BINS - 1)
        bins = tuple(
            (float(predicted[index == one].mean()), float(noticed[index == one].mean()), int((index == one).sum()))
            for one in np.unique(index)
        )
        error = sum(abs(mean - share) * count for mean, share, count in bins) / len(own)
        calibrations.append(MapCalibration(trees, len(own), bins, error, float(predicted.mean() - noticed.mean())))
    return tuple(calibrations)


def as_markdown(figures: SearchFigures) -> str:
    """Return the figures as tables."""
    has_prior = any(one.method is Method.PRIOR for one in figures.groups)
    header = (
        "trees/ha",
        "area",
        "vehicles",
        "flight",
        "noticed in one flight",
        "predicted",
        "one flight",
        "rate",
        "flown",
        "claim, median",
        "of the lawnmower's",
        *(("of the planned one's",) if has_prior else ()),
    )
    rows = [
        (
            f"{one.trees_per_ha:g}",
            f"{one.hectares:g} ha",
            str(one.vehicles),
            str(one.method),
            _share(one.noticed),
            f"{one.predicted:.2f}",
            f"{one.duration_s:.0f} s",
            f"{one.hectares_per_hour:.0f} ha/h",
            f"{one.path_m / 1000.0:.1f} km",
            f"{one.claimed_s:.0f} s" if math.isfinite(one.claimed_s) else "more than half never",
            "-" if math.isnan(one.ratio) else f"{one.ratio:.2f}",
            *(("-" if math.isnan(one.of_plain) else f"{one.of_plain:.2f}",) if has_prior else ()),
        )
        for one in figures.groups
    ]
    parts = [markdown_table(header, rows)]
    columns = ("trees/ha", "searches", "predicted: noticed (searches)", "mean difference", "predicted minus noticed")
    lines = [
        (
            f"{one.trees_per_ha:g}",
            str(one.searches),
            ", ".join(f"{mean:.2f}: {share:.2f} ({count})" for mean, share, count in one.bins),
            f"{one.error:.3f}",
            f"{one.bias:+.3f}",
        )
        for one in figures.calibrations
    ]
    if lines:
        parts.append(markdown_table(columns, lines))
    if figures.rendered:
        parts.append(
            f"Of {figures.rendered} searches with rendered frames, these notice the person in "
            f"{figures.rendered_noticed}, rays in {figures.rays_noticed}; both say the same in {figures.agreed}."
        )
    return "\n\n".join(parts) + "\n"


def _share(share: Share) -> str:
    return f"{share.value:.2f} ({share.low:.2f} to {share.high:.2f}), {share.hits} of {share.trials}"


def search_frame(path: Path) -> DocumentFrame:
    """Return the text around the written part of the document; see :func:`aos_gcs.lab.document.document_frame`."""
    return document_frame(path, BEGIN_MARK, _TITLE)


def write_document(
    path: Path, frame: DocumentFrame, settings: SearchStudySettings, figures: SearchFigures, tables: str
) -> None:
    """Write the document, or renew its written part: what was searched, and the tables of its figures."""
    about = "" if settings.spread is None else f", half of them within {settings.spread:g} sides of a last known point"
    body = (
        f"n = {figures.searches} persons ({settings.posture}{about}), each searched for by all methods; wanted "
        f"probability of detection {settings.pod:g}, {settings.rate_hz:g} frames per second, {settings.passes} flights "
        f"at most, close look {settings.close_look_s:g} s. In brackets: Wilson's intervals of "
        f"{100 * CONFIDENCE:.0f} %.\n\n{tables.rstrip()}"
    )
    frame.write(path, body)
