"""Anomalies on which the frames of a window agree, and what each is taken for.

Anomalies are those of :mod:`aos_gcs.surveys.window_anomalies`. A drone that takes frames along its way sees what as
many vehicles would see at once: to the decision, that of missions, every frame is one of a vehicle of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aos_gcs.imaging.geolocation import Geolocation, Uncertainty
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import CLAIMED, ENOUGH, SURELY_OTHER, FindingKind, Verdict
from aos_gcs.imaging.persons.warm_bodies import WarmView
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.mission.search.targets.persons import Judgement, PersonWatch
from aos_gcs.surveys.anomalies import LONGER_THAN_A_PERSON_M, PERSON_M, MapBlob
from aos_gcs.surveys.window_anomalies import Detection, find_anomalies

HEIGHT_STEP_M = 0.5
"""Heights of the ground that are judged as one: half of it displaces by 0.1 m at 25 degrees off nadir."""
FINEST_CELL_M = 0.1
"""Smallest cell of the map on which frames have to agree."""
LINE_M = 6.0
"""Length from which something warm is no person, nor two or three side by side: a conductor, a pipe, an edge."""
MAX_JUDGED = 200
"""Anomalies of a window that are judged, the most significant. More are a detector that does not fit."""


@dataclass(frozen=True, slots=True)
class ExaminationSettings:
    """What counts as an anomaly, and how well places are known."""

    detection: Detection
    uncertainty: Uncertainty


@dataclass(frozen=True, slots=True)
class Candidate:
    """An anomaly and the decision about it."""

    position_enu_m: tuple[float, float, float]
    """Position of the ground below it."""
    verdict: Verdict
    place: Geolocation | None
    """Place of what the decision rests on; None where nothing has one."""
    frames: int
    """Number of frames that agree on it."""
    significance: float
    """See :mod:`aos_gcs.surveys.significance`."""


@dataclass(frozen=True, slots=True)
class WindowFound:
    """What the frames of a window show."""

    candidates: tuple[Candidate, ...]
    """What may be a person, or is warm; the most significant first, none within a person's length of another."""
    largest_m2: float
    """Area of the largest anomaly."""
    left_out: Mapping[int, str]
    """Reason why a frame took no part, by its ``vehicle_id``."""


def search_window(frames: Sequence[Frame], surface: FocalSurface, settings: ExaminationSettings) -> WindowFound:
    """Return what the frames of a window show. Takes seconds: call it in a thread.

    Args:
        frames: frames in an east-north-up world, each of a vehicle of its own.
        surface: ground.
        settings: see :class:`ExaminationSettings`.

    Raises:
        ImagingError: if no frame sees the surface, or the detector cannot be applied to any.
    """
    found = find_anomalies(frames, surface, settings.detection, FINEST_CELL_M)
    usable = [frame for frame in frames if frame.vehicle_id not in found.left_out]
    return WindowFound(
        candidates=apart(_judged(usable, found.blobs[:MAX_JUDGED], settings.uncertainty)),
        largest_m2=max((blob.area_m2 for blob in found.blobs), default=0.0),
        left_out=found.left_out,
    )


def _judged(frames: Sequence[Frame], blobs: Sequence[MapBlob], uncertainty: Uncertainty) -> list[Candidate]:
    """Return what anomalies are taken for; without those that are nothing but unlike their surroundings."""
    by_height: dict[float, dict[int, MapBlob]] = {}
    for index, blob in enumerate(blobs):
        height_m = HEIGHT_STEP_M * round(blob.position_m[2] / HEIGHT_STEP_M)
        by_height.setdefault(height_m, {})[index] = blob
    if not by_height:
        return []
    found: list[Candidate] = []
    # Finding what stands out of frames takes most of the time, and does not depend on the height.
    seen_at_m = next(iter(by_height))
    seen = PersonWatch().look(frames, seen_at_m)
    for height_m, group in by_height.items():
        places = {index: np.array(blob.position_m[:2]) for index, blob in group.items()}
        watch = seen.on_plane(height_m)
        for index, judgement in watch.judge(places, height_m, uncertainty).items():
            candidate = _candidate(group[index], judgement)
            if _counts(candidate):
                found.append(candidate)
    return found


def apart(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return candidates without what is a piece of another one, the most significant first.

    Pieces have been joined on the map; places of what the decision rests on can come together besides. Of these a find
    stays rather than what is no more than warm.
    """
    kept: list[Candidate] = []
    for one in sorted(candidates, key=lambda one: (one.verdict.kind not in CLAIMED, -one.significance)):
        place_m = np.array(one.position_enu_m[:2])
        if all(np.linalg.norm(place_m - other.position_enu_m[:2]) > PERSON_M for other in kept):
            kept.append(one)
    return tuple(sorted(kept, key=lambda one: -one.significance))


def _candidate(blob: MapBlob, judgement: Judgement) -> Candidate:
    place = judgement.place
    east_m, north_m, up_m = blob.position_m if place is None else map(float, place.position_enu_m)
    verdict = _by_length(judgement.verdict, blob, judgement)
    return Candidate((east_m, north_m, up_m), verdict, place, blob.max_count, blob.significance or 0.0)


def _by_length(verdict: Verdict, blob: MapBlob, judgement: Judgement) -> Verdict:
    """Return a verdict that says where something is longer than a person, and that what is much longer is none.

    The decision of missions knows warm bodies of forests, in which nothing hot is longer than a trunk.
    """
    of_row_m, of_body_m = blob.length_m or 0.0, _usual_extent_m(judgement.views)
    length_m = max(of_row_m, of_body_m)
    if length_m <= LONGER_THAN_A_PERSON_M:
        return verdict
    told = replace(verdict, reasons=(f"{length_m:.0f} m long: longer than a person", *verdict.reasons))
    # Sunlit ground beside a person makes the body long, but not the row.
    is_line = blob.is_longer_than_a_person and (of_body_m if judgement.views else of_row_m) > LINE_M
    # In colours nothing tells what is warm.
    if not is_line or judgement.place is None or verdict.kind not in CLAIMED:
        return told
    probability = None if verdict.probability is None else min(verdict.probability, SURELY_OTHER)
    return replace(told, kind=FindingKind.WARM_OBJECT, probability=probability)


def _usual_extent_m(views: Sequence[WarmView]) -> float:
    """Return the median of how far what the views show extends; 0 without any."""
    return float(np.median([np.ptp(view.points_enu_m, axis=0).max() for view in views])) if views else 0.0


def _counts(candidate: Candidate) -> bool:
    """Tell whether searchers should know of it: something warm, or what stands out where temperatures are not known.

    What nothing but the marks tells of, as in colour pictures, needs as many frames as the decision asks for elsewhere.
    """
    if candidate.verdict.kind is FindingKind.ANOMALY:
        return candidate.place is not None or candidate.frames >= ENOUGH
    return candidate.verdict.kind is not FindingKind.OBJECT
