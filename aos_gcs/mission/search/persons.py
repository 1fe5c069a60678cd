"""What was warm in the latest steps, and what the targets are taken for by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.geolocation import Geolocation, Uncertainty
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.bodies import Body, find_bodies
from aos_gcs.imaging.persons.decision import Verdict, decide
from aos_gcs.imaging.persons.evidence import NO_TEMPERATURES, nothing_warm
from aos_gcs.imaging.persons.warm_bodies import LINK_M, WarmView, warm_view

KEPT_STEPS = 3
"""Number of steps whose frames count; the model of persons is fitted to as many."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """Decision about a target, and where the warm body stands that it rests on."""

    verdict: Verdict
    place: Geolocation | None = None
    """None where nothing warm was seen."""


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

    def judge(
        self, places_enu_m: Mapping[int, NDArray[np.float64]], plane_height_m: float, uncertainty: Uncertainty
    ) -> dict[int, Judgement]:
        """Return what the targets at places, shape (2,), are taken for, by the same keys.

        The warm body nearest to a place is the target's, where it is near enough. A place that no frame holds has no
        result.
        """
        if not places_enu_m:
            return {}
        views = [view for step in self.steps for view in step]
        if not views:
            return {key: Judgement(decide(NO_TEMPERATURES)) for key in places_enu_m}
        bodies = find_bodies(views, plane_height_m, uncertainty, list(places_enu_m.values()))
        judged = ((key, _judged(place, bodies, views, plane_height_m)) for key, place in places_enu_m.items())
        return {key: judgement for key, judgement in judged if judgement is not None}


def watch_persons(
    watch: PersonWatch,
    frames: Sequence[Frame],
    plane_height_m: float,
    places_enu_m: Mapping[int, NDArray[np.float64]],
    uncertainty: Uncertainty,
) -> tuple[PersonWatch, dict[int, Judgement]]:
    """Return the watch after a step, and its judgement of targets at places."""
    after = watch.look(frames, plane_height_m)
    return after, after.judge(places_enu_m, plane_height_m, uncertainty)


def _judged(
    place_enu_m: NDArray[np.float64], bodies: Sequence[Body], views: Sequence[WarmView], plane_height_m: float
) -> Judgement | None:
    nearest = min(bodies, key=lambda body: body.distance_m(place_enu_m), default=None)
    if nearest is None or nearest.distance_m(place_enu_m) > LINK_M:
        nothing = nothing_warm(place_enu_m, views, plane_height_m)
        return Judgement(decide(nothing)) if nothing.frames else None
    return Judgement(decide(nearest.evidence), nearest.place)
