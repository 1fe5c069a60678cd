"""Figures of recorded flights with their intervals: as a table, as data for JSON, and as docs/recordings.md."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aos_gcs.lab.document import DocumentFrame, document_frame
from aos_gcs.lab.recordings.study import MATCH_M, WindowResult, WindowSettings
from aos_gcs.lab.report import markdown_table
from aos_gcs.lab.statistics import CONFIDENCE, PerHectare, Share

BEGIN_MARK = "<!-- Written by aos-gcs lab recordings; do not edit below -->"
_TITLE = "# Recordings"


@dataclass(frozen=True, slots=True)
class Total:
    """All windows of one detector."""

    detector: str
    windows: int
    detected: Share
    """Persons in view near which the detector has an anomaly."""
    recall: Share
    """Persons in view that the decision claims."""
    precision: Share
    """Claims at a person."""
    false_alarms: PerHectare
    """Anomalies at no person."""
    false_claims: PerHectare
    error_m: float
    """Median of the horizontal errors; NaN without a person found."""
    largest_error_m: float


def summarise(results: Iterable[WindowResult]) -> list[Total]:
    """Return the totals per detector, in the order of their first appearance."""
    by_detector: dict[str, list[WindowResult]] = {}
    for result in results:
        by_detector.setdefault(result.detector, []).append(result)
    return [_total(detector, own) for detector, own in by_detector.items()]


def as_markdown(results: Sequence[WindowResult]) -> str:
    """Return the tables of the totals and of the windows."""
    totals = markdown_table(
        [
            "detector",
            "windows",
            "persons detected",
            "persons claimed (recall)",
            "claims that are right (precision)",
            "false alarms per ha",
            "false claims per ha",
            "position error, median and largest, m",
        ],
        (
            [
                one.detector,
                str(one.windows),
                one.detected.text,
                one.recall.text,
                one.precision.text,
                one.false_alarms.text(1),
                one.false_claims.text(1),
                "-" if math.isnan(one.error_m) else f"{one.error_m:.2f}, {one.largest_error_m:.2f}",
            ]
            for one in summarise(results)
        ),
    )
    windows = markdown_table(
        [
            "recording",
            "frames",
            "detector",
            "persons in view",
            "detected",
            "claimed",
            "anomalies, false",
            "claims, false",
            "position errors, m",
        ],
        (
            [
                one.recording,
                f"{one.first} to {one.first + one.frames - 1}",
                one.detector,
                str(one.persons),
                str(one.detected),
                str(one.found),
                f"{one.anomalies}, {one.false_anomalies}",
                f"{one.claims}, {one.false_claims}",
                ", ".join(f"{error:.2f}" for error in one.errors_m) or "-",
            ]
            for one in results
        ),
    )
    return f"{totals}\n\n{windows}\n"


def as_data(results: Sequence[WindowResult]) -> dict[str, Any]:
    """Return the windows and the totals as data for JSON; what is not known is null."""
    data = {
        "match_m": MATCH_M,
        "windows": [asdict(one) for one in results],
        "totals": [asdict(one) for one in summarise(results)],
    }
    return {key: _finite(value) for key, value in data.items()}


def recordings_frame(path: Path) -> DocumentFrame:
    """Return the text around the written part of the document; see ``aos_gcs.lab.document``."""
    return document_frame(path, BEGIN_MARK, _TITLE)


def write_document(path: Path, frame: DocumentFrame, settings: WindowSettings, results: Sequence[WindowResult]) -> None:
    """Write the document, or renew its written part."""
    body = (
        f"Windows of {settings.frames} frames, every {settings.stride} from frame {settings.first} on; cells of "
        f"{settings.resolution_m:g} m; {settings.false_alarms_per_ha:g} false alarms per hectare allowed; persons "
        f"within {MATCH_M:g} m. In brackets: intervals of {100 * CONFIDENCE:.0f} % (shares by Wilson, rates by "
        f"Poisson), as if windows were independent.\n\n{as_markdown(results).rstrip()}"
    )
    frame.write(path, body)


def _total(detector: str, results: Sequence[WindowResult]) -> Total:
    persons, found = (sum(getattr(one, name) for one in results) for name in ("persons", "found"))
    claims, false_claims = (sum(getattr(one, name) for one in results) for name in ("claims", "false_claims"))
    hectares = sum(one.searched_ha for one in results)
    errors_m = [error for one in results for error in one.errors_m]
    return Total(
        detector=detector,
        windows=len(results),
        detected=Share.of(sum(one.detected for one in results), persons),
        recall=Share.of(found, persons),
        precision=Share.of(claims - false_claims, claims),
        false_alarms=PerHectare.of(sum(one.false_anomalies for one in results), hectares),
        false_claims=PerHectare.of(false_claims, hectares),
        error_m=float(np.median(errors_m)) if errors_m else math.nan,
        largest_error_m=max(errors_m, default=math.nan),
    )


def _finite(value: Any) -> Any:
    """Return data without the numbers that JSON lacks."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
