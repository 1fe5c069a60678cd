"""Likelihood that a target is a person, from the warm bodies in the frames of the latest steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.classifier import person_confidence
from aos_gcs.imaging.persons.evidence import gather_evidence
from aos_gcs.imaging.persons.warm_bodies import LINK_M, WarmView, warm_bodies, warm_view

KEPT_STEPS = 3
"""Number of steps whose frames count; the model of persons is fitted to as many."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonWatch:
    """What was warm in the latest steps, the oldest first."""

    steps: tuple[tuple[WarmView, ...], ...] = ()

    def look(self, frames: Sequence[Frame], plane_height_m: float) -> PersonWatch:
        """Return the watch with what is warm in a step's frames; frames without temperatures show nothing.

        Args:
            frames: frames of one step, with corrected poses.
            plane_height_m: ENU height of the focal plane.
        """
        radiometric = [frame for frame in frames if "thermal" in frame.bands and frame.image.dtype.kind == "f"]
        seen = tuple(warm_view(frame, plane_height_m) for frame in radiometric)
        return PersonWatch((*self.steps, seen)[-KEPT_STEPS:])

    def judge(self, places_enu_m: Mapping[int, NDArray[np.float64]]) -> dict[int, float | None]:
        """Return the probabilities, 0 to 1, that the warm bodies at places, shape (2,), are persons, by the same keys.

        They are those of :func:`~aos_gcs.imaging.persons.classifier.person_confidence`; None where nothing warm was
        seen.
        """
        bodies = warm_bodies([view for step in self.steps for view in step]) if places_enu_m else ()
        return {key: _confidence(bodies, place_enu_m) for key, place_enu_m in places_enu_m.items()}


def watch_persons(
    watch: PersonWatch, frames: Sequence[Frame], plane_height_m: float, places_enu_m: Mapping[int, NDArray[np.float64]]
) -> tuple[PersonWatch, dict[int, float | None]]:
    """Return the watch after a step, and its judgement of places."""
    after = watch.look(frames, plane_height_m)
    return after, after.judge(places_enu_m)


def _confidence(bodies: Sequence[Sequence[WarmView]], place_enu_m: NDArray[np.float64]) -> float | None:
    nearest_m, nearest = LINK_M, None
    for body in bodies:
        points_enu_m = np.concatenate([view.points_enu_m for view in body])
        distance_m = float(np.linalg.norm(points_enu_m - place_enu_m, axis=1).min())
        if distance_m < nearest_m:
            nearest_m, nearest = distance_m, body
    return None if nearest is None else person_confidence(gather_evidence(nearest))
