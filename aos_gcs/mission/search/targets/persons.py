"""What was warm in the latest steps, and what the targets are taken for by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from aos_gcs.imaging.geolocation import Geolocation, Uncertainty, geolocate
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.bodies import Body, find_bodies
from aos_gcs.imaging.persons.classifier import MIN_VEHICLES
from aos_gcs.imaging.persons.decision import FindingKind, Verdict, decide, may_be_warmer
from aos_gcs.imaging.persons.evidence import NO_TEMPERATURES, Evidence, gather_evidence, nothing_warm, vantage_points
from aos_gcs.imaging.persons.form import FormSums, form_sums
from aos_gcs.imaging.persons.spots import can_stand_out, relative_view, spot_at
from aos_gcs.imaging.persons.warm_bodies import LINK_M, WarmView, warm_bodies, warm_view
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.mission.search.targets.sight_lines import SightLines

KEPT_STEPS = 3
"""Number of steps whose frames count; the model of persons is fitted to as many."""
SUSPICION = 0.2
"""Probability from which a warm body may be a person, so that it is worth a close look: as many bodies are persons."""
_SUNNY_SHARE = 0.25
"""Share of the frames so far in which the sun warms the ground, from which on the day is a sunny one: in some all that
they hold lies in the shade."""
KEPT_BODIES = 8
"""Number of bodies, those seen last, whose lines of sight are kept."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """Decision about a target, and where the warm body stands that it rests on."""

    verdict: Verdict
    place: Geolocation | None = None
    """None where nothing warm was seen."""
    views: tuple[WarmView, ...] = ()
    """Parts of the latest steps' views that show it."""
    form_sums: FormSums = field(default_factory=FormSums)
    """What the latest step's own views tell about its form."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonWatch:
    """What was warm in the latest steps, the oldest first."""

    steps: tuple[tuple[WarmView, ...], ...] = ()
    lines: Mapping[int, SightLines] = field(default_factory=dict)
    """Lines of sight to warm bodies, by the key of the target: what is taken for a person later has been looked at."""
    plane_height_m: float = 0.0
    """Height of the plane that the points of the steps lie on."""
    suspects_enu_m: tuple[tuple[float, float], ...] = ()
    """Horizontal places of warm bodies that may be persons, by all that the steps show."""
    frames: int = 0
    """Frames with temperatures so far."""
    sunny_frames: int = 0
    """Frames among these in which the sun warms the ground."""

    def look(self, frames: Sequence[Frame], plane_height_m: float) -> PersonWatch:
        """Return the watch with what is warm in a step's frames, or stands out where none of them tells temperatures.

        Args:
            frames: frames of one step, with corrected poses.
            plane_height_m: ENU height of the focal plane.
        """
        radiometric = [frame for frame in frames if "thermal" in frame.bands and frame.image.dtype.kind == "f"]
        plain = [] if radiometric else [frame for frame in frames if can_stand_out(frame)]
        warm = [warm_view(frame, plane_height_m) for frame in radiometric]
        watch = replace(
            self,
            plane_height_m=plane_height_m,
            frames=self.frames + len(warm),
            sunny_frames=self.sunny_frames + sum(view.in_sun for view in warm),
        )
        seen = (
            *(replace(view, in_sun=watch.is_sunny) for view in warm),
            *(relative_view(frame, plane_height_m) for frame in plain),
        )
        return replace(watch, steps=(*self._steps_on(plane_height_m), seen)[-KEPT_STEPS:])

    @property
    def is_sunny(self) -> bool:
        """Whether the sun warms spots of clothes and fur, too."""
        return self.sunny_frames > _SUNNY_SHARE * self.frames

    def without_steps(self) -> PersonWatch:
        """Return the watch without what was seen; the lines of sight stay: a body that has moved drops its own."""
        return replace(self, steps=(), suspects_enu_m=())

    def on_plane(self, plane_height_m: float) -> PersonWatch:
        """Return what was seen, without lines of sight, on the plane of another height."""
        return PersonWatch(
            self._steps_on(plane_height_m),
            plane_height_m=plane_height_m,
            frames=self.frames,
            sunny_frames=self.sunny_frames,
        )

    def _steps_on(self, plane_height_m: float) -> tuple[tuple[WarmView, ...], ...]:
        if plane_height_m == self.plane_height_m:
            return self.steps
        return tuple(tuple(view.on_plane(self.plane_height_m, plane_height_m) for view in step) for step in self.steps)

    def judge(
        self,
        places_enu_m: Mapping[int, NDArray[np.float64]],
        plane_height_m: float,
        uncertainty: Uncertainty,
        ground: Terrain | None = None,
        *,
        linked: Sequence[tuple[WarmView, ...]] | None = None,
    ) -> dict[int, Judgement]:
        """Return what the targets at places, shape (2,), are taken for, by the same keys.

        The warm body nearest to a place is the target's, where it is near enough. A place that no frame holds has no
        result. Frames without temperatures decide where none of the latest steps has any that tell them. ``linked`` are
        the bodies of the views that tell temperatures, where the caller has them.
        """
        if not places_enu_m:
            return {}
        views = [view for step in self.steps for view in step]
        if not views:
            return {key: Judgement(decide(NO_TEMPERATURES)) for key in places_enu_m}
        if not any(view.radiometric for view in views):
            spots = (
                (key, _spot(place, views, plane_height_m, uncertainty, ground)) for key, place in places_enu_m.items()
            )
            return {key: judgement for key, judgement in spots if judgement is not None}
        views = self.radiometric_views()
        bodies = find_bodies(views, plane_height_m, uncertainty, list(places_enu_m.values()), ground, linked=linked)
        judged = ((key, self._judged(place, bodies, views, plane_height_m)) for key, place in places_enu_m.items())
        return {key: judgement for key, judgement in judged if judgement is not None}

    def _judged(
        self,
        place_enu_m: NDArray[np.float64],
        bodies: Sequence[Body],
        views: Sequence[WarmView],
        plane_height_m: float,
    ) -> Judgement | None:
        nearest = min(bodies, key=lambda body: body.distance_m(place_enu_m), default=None)
        if nearest is None or nearest.distance_m(place_enu_m) > LINK_M:
            nothing = nothing_warm(place_enu_m, views, plane_height_m)
            return Judgement(decide(nothing)) if nothing.frames else None
        latest = [view for view in nearest.views if self._is_latest(view)]
        return Judgement(decide(nearest.evidence), nearest.place, nearest.views, form_sums(latest, plane_height_m))

    def _is_latest(self, view: WarmView) -> bool:
        """Tell whether a view, or part of one, is of the latest step."""
        return any(view.pose is one.pose for one in self.steps[-1])

    def radiometric_views(self) -> list[WarmView]:
        """Return the views of all steps that tell temperatures."""
        return [view for step in self.steps for view in step if view.radiometric]

    def suspect(self, linked: Sequence[tuple[WarmView, ...]]) -> PersonWatch:
        """Return the watch with those noted of its bodies that may be persons."""
        views = self.radiometric_views()
        bodies = (body for body in linked if vantage_points(body, views) >= MIN_VEHICLES)
        suspects = (body for body in bodies if _is_suspect(gather_evidence(body, views, self.plane_height_m)))
        return replace(self, suspects_enu_m=tuple(map(_middle, suspects)))

    def locate(
        self,
        judgements: Mapping[int, Judgement],
        plane_height_m: float,
        uncertainty: Uncertainty,
        ground: Terrain | None = None,
    ) -> tuple[PersonWatch, dict[int, Judgement]]:
        """Return the watch and the judgements of its latest step with persons located by the lines of all steps.

        Targets that are one body, by its views, have the lines of the one that has most.
        """
        lines, located = dict(self.lines), dict(judgements)
        keys_of_body: dict[int, list[int]] = {}
        for key, judgement in judgements.items():
            if judgement.place is not None:
                keys_of_body.setdefault(id(judgement.views), []).append(key)
        for keys in keys_of_body.values():
            judgement = judgements[keys[0]]
            views = [view.as_blob_view() for view in judgement.views if self._is_latest(view)]
            if judgement.place is None or not views:
                continue
            former = max((lines.pop(key, SightLines()) for key in keys), key=lambda one: one.count)
            if judgement.verdict.kind is not FindingKind.PERSON:
                lines |= dict.fromkeys(keys, former.noted(views, plane_height_m))
                continue
            of_body, place = former.extended(views, judgement.place, plane_height_m, uncertainty, ground)
            lines |= dict.fromkeys(keys, of_body)
            located |= {key: replace(judgements[key], place=place) for key in keys}
        lines = dict(list(lines.items())[-KEPT_BODIES:])
        return replace(self, lines=lines), {key: replace(one, views=()) for key, one in located.items()}


def watch_persons(
    watch: PersonWatch,
    frames: Sequence[Frame],
    plane_height_m: float,
    places_enu_m: Mapping[int, NDArray[np.float64]],
    uncertainty: Uncertainty,
    *,
    ground: Terrain | None = None,
) -> tuple[PersonWatch, dict[int, Judgement]]:
    """Return the watch after a step, and its judgement of targets at places on the ground, where that is known."""
    after = watch.look(frames, plane_height_m)
    linked = warm_bodies(after.radiometric_views())
    judgements = after.judge(places_enu_m, plane_height_m, uncertainty, ground, linked=linked)
    located, judgements = after.locate(judgements, plane_height_m, uncertainty, ground)
    return located.suspect(linked), judgements


def _is_suspect(evidence: Evidence) -> bool:
    return (decide(evidence).probability or 0.0) >= SUSPICION or may_be_warmer(evidence)


def _middle(body: Sequence[WarmView]) -> tuple[float, float]:
    east_m, north_m = np.concatenate([view.points_enu_m for view in body]).mean(axis=0)
    return float(east_m), float(north_m)


def _spot(
    place_enu_m: NDArray[np.float64],
    views: Sequence[WarmView],
    plane_height_m: float,
    uncertainty: Uncertainty,
    ground: Terrain | None,
) -> Judgement | None:
    evidence, spot = spot_at(place_enu_m, views, plane_height_m)
    if not evidence.frames:
        return None
    if not spot:
        return Judgement(decide(evidence))
    lines = [view.as_blob_view() for view in spot]
    return Judgement(decide(evidence), geolocate(lines, plane_height_m, uncertainty, ground=ground))
