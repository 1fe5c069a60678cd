"""Likelihood that a target is a person, from the warm bodies in the frames of the latest steps."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.classifier import person_confidence
from aos_gcs.imaging.persons.evidence import gather_evidence
from aos_gcs.imaging.persons.warm_bodies import LINK_M, WarmView, warm_bodies, warm_view

KEPT_STEPS = 3
"""Number of steps whose frames count; the model of persons is fitted to as many."""


class PersonWatch:
    """Keeps the warm bodies of the latest steps and judges places by them."""

    def __init__(self) -> None:
        self._steps: deque[tuple[WarmView, ...]] = deque(maxlen=KEPT_STEPS)
        self._bodies: tuple[tuple[WarmView, ...], ...] = ()

    def look(self, frames: Sequence[Frame], plane_height_m: float) -> None:
        """Note the warm bodies in a step's frames; frames without temperatures show none.

        Args:
            frames: frames of one step, with corrected poses.
            plane_height_m: ENU height of the focal plane.
        """
        radiometric = [frame for frame in frames if "thermal" in frame.bands and frame.image.dtype.kind == "f"]
        self._steps.append(tuple(warm_view(frame, plane_height_m) for frame in radiometric))
        self._bodies = warm_bodies([view for step in self._steps for view in step])

    def forget(self) -> None:
        """Discard what was seen before the next step: the target has moved."""
        self._steps.clear()

    def confidence_at(self, position_enu_m: NDArray[np.float64]) -> float | None:
        """Return the probability, 0 to 1, that the warm body at a place, shape (2,), is a person.

        Returns:
            As of :func:`~aos_gcs.imaging.persons.classifier.person_confidence`; None when nothing warm was seen there.
        """
        nearest_m, nearest = LINK_M, None
        for body in self._bodies:
            points_enu_m = np.concatenate([view.points_enu_m for view in body])
            distance_m = float(np.linalg.norm(points_enu_m - position_enu_m, axis=1).min())
            if distance_m < nearest_m:
                nearest_m, nearest = distance_m, body
        return None if nearest is None else person_confidence(gather_evidence(nearest))
