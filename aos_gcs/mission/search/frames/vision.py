"""Analysis of a step's frames, on the focal plane in use and with corrected poses."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ImagingError, MissionError, WorkerError
from aos_gcs.geometry.poses import Pose
from aos_gcs.imaging.focus.step import follow_focus
from aos_gcs.imaging.focus.track import FocusTrack, overridden
from aos_gcs.imaging.model import AnomalySource, Frame, KeptView, KnownPlaces, StepAnalysis
from aos_gcs.imaging.registration.pose_errors import ErrorBudget, Registration, apply_sure, register
from aos_gcs.imaging.step.analysis import analyse_examined, analyse_step
from aos_gcs.imaging.step.settings import DEPTH_BELOW_M
from aos_gcs.mission.context import FlightContext
from aos_gcs.mission.handler_watch import WORK_S, sign_of_life
from aos_gcs.mission.journal import Recorder
from aos_gcs.mission.model.steps import FocusSnapshot, FocusSource
from aos_gcs.mission.search.frames.background import BackgroundWatch
from aos_gcs.mission.search.frames.ground_in_view import ground_in_view
from aos_gcs.mission.search.frames.intake import FrameIntake, open_intake
from aos_gcs.mission.search.frames.sampling import Sample
from aos_gcs.mission.search.targets.persons import Judgement, PersonWatch, watch_persons
from aos_gcs.ports import Severity

P = ParamSpec("P")
T = TypeVar("T")

_REPORTED_CHANGE_M = 0.5
"""Change of the focal height from which it is reported."""


class Vision:
    """Analyses the frames of each step, and learns focus and poses from them for the next ones.

    Args:
        context: context of the flight.
        recorder: stores the frames.
        focus_override_m: focal height that the operator has set; None leaves it to the program.
    """

    def __init__(self, context: FlightContext, recorder: Recorder, focus_override_m: float | None) -> None:
        self._context = context
        self._recorder = recorder
        self._focus = overridden(FocusTrack(context.settings.imaging.plane_height_m, math.inf), focus_override_m)
        """Focal height above the ground, but for the operator's, which is above the origin."""
        self._ground_m = 0.0
        """Height of the ground in the latest step; 0 where the focal plane does not follow it."""
        self._reported_height_m = self._focus.height_m
        self._registration = Registration(ErrorBudget.of(context.settings.uncertainty))
        self._history: tuple[KeptView, ...] = ()
        """Views of earlier steps that are still part of the integral."""
        self._reported: list[Frame] = []
        """Frames of this step with the poses that the vehicles have reported."""
        self._persons = PersonWatch()
        self._background = BackgroundWatch(context.journal)

    @property
    def focus(self) -> FocusSnapshot:
        """The focal plane in use."""
        track = self._focus
        if track.override_m is not None:
            return FocusSnapshot(track.override_m, FocusSource.OPERATOR, None)
        if math.isinf(track.sigma_m):
            return FocusSnapshot(self._focal_height_m, FocusSource.CONFIGURED, None)
        return FocusSnapshot(self._focal_height_m, FocusSource.AUTOFOCUS, track.sigma_m)

    @property
    def focus_override_m(self) -> float | None:
        """Focal height that the operator has set; None leaves it to the program."""
        return self._focus.override_m

    def override_focus(self, height_m: float | None) -> None:
        """Focus on the operator's height from the next step on; None leaves it to autofocus again.

        Raises:
            MissionError: the height is not below the cameras, or far below the ground.
        """
        surface = self._context.roster.layers.surface
        lowest_m = self._context.settings.flight.lowest_layer_m + (0.0 if surface is None else surface.lowest_m)
        if height_m is not None and not (math.isfinite(height_m) and height_m < lowest_m):
            raise MissionError(
                f"The focal height must be below the lowest layer, {lowest_m:g} m above the origin; it is {height_m:g}."
            )
        deepest_m = self._deepest_m
        if height_m is not None and height_m < deepest_m:
            raise MissionError(
                f"The focal height must be at least {deepest_m:g} m above the origin, {DEPTH_BELOW_M:g} m below the "
                f"plane that is set; it is {height_m:g}."
            )
        self._focus = overridden(self._focus, height_m)

    @property
    def _deepest_m(self) -> float:
        """Least height above the origin that an operator may set: a plane far below the ground shows nothing."""
        surface, plane_m = self._context.roster.layers.surface, self._context.settings.imaging.plane_height_m
        lowest_m = plane_m if surface is None else plane_m + min(0.0, surface.lowest_m)
        return min(lowest_m, self._ground_m + self._focus.height_m) - DEPTH_BELOW_M

    def beside(self) -> Vision:
        """Return another one for frames taken beside those of this one: with its focus and poses, and no history."""
        other = Vision(self._context, self._recorder, None)
        other._focus, other._ground_m, other._registration = self._focus, self._ground_m, self._registration
        other._background = self._background
        return other

    def intake(self, step: int) -> AbstractAsyncContextManager[FrameIntake]:
        """Take in the frames of a step, as they come."""
        return open_intake(self._context, self._recorder, step)

    async def see(
        self,
        intake: FrameIntake,
        taken: Sample,
        settled_enu_m: Sequence[tuple[float, float]] = (),
        target_enu_m: Sequence[float] | None = None,
    ) -> StepAnalysis:
        """Analyse the frames of a step; blobs at settled places lead nobody, those of suspected persons before others.

        Args:
            intake: intake of the frames, which is over.
            taken: frames that count.
            settled_enu_m: horizontal places that have been looked at.
            target_enu_m: place of the target: the focal plane is that of the ground there, not of that below the swarm.

        Raises:
            UnusableFramesError: none of the frames can be used.
            WorkerError: they could not be analysed.
        """
        self._reported = [intake.frames[capture.vehicle_id] for capture in taken.captures]
        placed = self._placed()
        self._follow_ground([frame.pose.position_enu_m for frame in placed] if target_enu_m is None else [target_enu_m])
        imaging = replace(self._context.settings.imaging, plane_height_m=self._focal_height_m)
        places = KnownPlaces(tuple(settled_enu_m), self._persons.suspects_enu_m)
        if imaging.anomaly_source is AnomalySource.MASKS:
            examined = [replace(intake.examined(frame.vehicle_id), pose=frame.pose) for frame in placed]
            analysis = await self._run(analyse_examined, examined, imaging, self._history, places)
        else:
            analysis = await self._run(analyse_step, placed, imaging, self._history, places=places)
        self._history = analysis.history
        self._background.note(self._reported)
        return analysis

    def frames(self, analysis: StepAnalysis) -> list[Frame]:
        """Return the step's frames that took part in its analysis, with the poses by which they were placed."""
        return self._usable(self._placed(), analysis)

    def corrected_poses(self) -> dict[int, Pose]:
        """Return the poses by which the step's frames were placed, by vehicle; none where registration is off."""
        if not self._context.settings.registration.enabled:
            return {}
        return {frame.vehicle_id: frame.pose for frame in self._placed()}

    def forget(self) -> None:
        """Discard the views of earlier steps: the target has moved."""
        self._history = ()
        self._persons = self._persons.without_steps()

    async def learn(
        self, step: int, analysis: StepAnalysis, places_enu_m: Mapping[int, NDArray[np.float64]]
    ) -> dict[int, Judgement] | None:
        """Learn from the step's frames for the next ones; there is time for it while the vehicles move.

        Returns:
            What the targets at the places are taken for, by the same keys; None where the frames could not be judged.
        """
        settings, persons = self._context.settings, self._persons
        judgements: dict[int, Judgement] | None = None
        try:
            persons, judgements = await self._watch_persons(analysis, places_enu_m)
            if settings.registration.is_due(step):
                await self._register(analysis)
            if settings.autofocus.is_due(step):
                await self._refocus(analysis)
        except WorkerError as error:
            text = f"Step {step}: not all was learned from its images: {error}"
            self._context.journal.notice(Severity.WARNING, text)
        # Only now: who ends the step meanwhile ends it without a judgement, as the record has it.
        self._persons = persons
        self._background.note_sun(is_sunny=persons.is_sunny)
        self._reported = []
        return judgements

    async def _watch_persons(
        self, analysis: StepAnalysis, places_enu_m: Mapping[int, NDArray[np.float64]]
    ) -> tuple[PersonWatch, dict[int, Judgement]]:
        usable = self.frames(analysis)
        settings, grid = self._context.settings, analysis.grid
        ground = ground_in_view(settings, self._context.bounds.ground, grid)
        return await self._run(
            watch_persons, self._persons, usable, grid.height_m, places_enu_m, settings.uncertainty, ground=ground
        )

    @property
    def _focal_height_m(self) -> float:
        track = self._focus
        return self._ground_m + track.height_m if track.override_m is None else track.override_m

    def _follow_ground(self, places_enu_m: Sequence[Sequence[float] | NDArray[np.float64]]) -> None:
        """Note the mean height of the ground at places; where none of it is known, the former one stays."""
        ground = self._context.bounds.ground
        if ground is None or not self._context.settings.focus_follows_ground:
            return
        heights_m = ground.heights_at(np.array([place_m[:2] for place_m in places_enu_m]))
        known_m = heights_m[np.isfinite(heights_m)]
        if known_m.size:
            self._ground_m = float(known_m.mean())

    async def _run(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        sign_of_life(WORK_S)
        return await self._context.imaging.run(function, *args, **kwargs)

    def _placed(self) -> list[Frame]:
        """Return the step's frames with corrected poses, where registration is sure of them."""
        settings = self._context.settings.registration
        if not settings.enabled:
            return self._reported
        return apply_sure(self._registration, self._reported, settings.min_confidence)

    def _usable(self, frames: list[Frame], analysis: StepAnalysis) -> list[Frame]:
        return [frame for frame in frames if frame.vehicle_id in analysis.vehicle_ids]

    async def _register(self, analysis: StepAnalysis) -> None:
        usable = self._usable(self._reported, analysis)
        before, limit = self._registration, self._context.settings.registration.min_confidence
        try:
            self._registration = await self._run(register, usable, before, analysis.grid.height_m)
        except ImagingError as error:
            self._context.journal.notice(Severity.WARNING, f"Registration: no result from this step: {error}")
            return
        if before.confidence < limit <= self._registration.confidence:
            corrections = self._registration.corrections().values()
            offset_m = max(math.hypot(c.east_m, c.north_m) for c in corrections)
            yaw_deg = math.degrees(max(abs(c.yaw_rad) for c in corrections))
            self._context.journal.notice(
                Severity.INFO,
                f"Registration: poses are corrected from now on, by up to {offset_m:.2f} m and {yaw_deg:.1f}° "
                f"(confidence {self._registration.confidence:.2f})",
            )

    async def _refocus(self, analysis: StepAnalysis) -> None:
        settings, before = self._context.settings, self._focus
        usable = self.frames(analysis)
        in_view = analysis.blob is not None and analysis.visibility_m2 >= settings.detection.threshold_m2
        target_enu_m = analysis.blob.centroid_enu_m if analysis.blob is not None and in_view else None
        ground_m = self._ground_m
        low_m, high_m = (ground_m + height_m for height_m in settings.focus_range_m)
        found = await self._run(follow_focus, before.moved(ground_m), usable, target_enu_m, low_m, high_m)
        # The operator may have set a height meanwhile.
        after = self._focus = replace(found.moved(-ground_m), override_m=self._focus.override_m)
        if abs(after.height_m - self._reported_height_m) >= _REPORTED_CHANGE_M:
            self._reported_height_m = after.height_m
            above = " above the ground" if settings.focus_follows_ground else ""
            text = f"Autofocus: focal plane at {after.height_m:.1f} m{above}, ± {after.sigma_m:.1f} m"
            self._context.journal.notice(Severity.INFO, text)
