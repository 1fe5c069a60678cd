"""Examination of a recorded flight, window by window, while the dashboard shows what was found so far."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from aos_gcs.errors import ImagingError, InputDataError
from aos_gcs.examination.overview import Overview
from aos_gcs.examination.reduction import reduced
from aos_gcs.examination.search import Candidate, ExaminationSettings, WindowFound, search_window
from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.examination.windows import FrameWindow, examined_ground
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.projection import project_points
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import CLAIMED, FindingKind
from aos_gcs.imaging.undistort import seen_pixels
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.imaging.workers import parallel_map
from aos_gcs.input_values import printable
from aos_gcs.mission.model.findings import TargetEstimate
from aos_gcs.mission.model.phase import Outcome, OutcomeRecord, Phase
from aos_gcs.mission.model.steps import StepRecord
from aos_gcs.mission.search.targets.tracker import error_ellipse
from aos_gcs.ports import Capture, Clock, Severity
from aos_gcs.store.frame_entry import MAX_UTC_S
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.surveys.anomalies import PERSON_M
from aos_gcs.surveys.images import read_frame
from aos_gcs.surveys.model import Survey, SurveyImage
from aos_gcs.surveys.seen_ground import SeenGround, ground_height_m, seen_ground
from aos_gcs.surveys.significance import MIN_VIEWS

_MANY = 0.2
"""Share of the pictures from which on those that are left out are named beside the result."""
_WHOLE = 0.8
"""Share of the ground from which all of it counts as examined: single frames see the edges of every flight."""

_LEAST_PERCENT = 0.5
"""Share of the ground without a height from which a result says so, in percent: what rounds to 1 %."""


@dataclass(frozen=True, slots=True, eq=False)
class Examination:
    """A recorded flight, and how it is examined."""

    survey: Survey
    """Survey whose world is east-north-up about its origin."""
    bands: tuple[str, ...]
    """Bands by which the images are judged: that of one band counts as thermal."""
    surface: FocalSurface
    windows: tuple[FrameWindow, ...]
    settings: ExaminationSettings
    ground_m: float
    """Height of the ground where the surface is not known."""
    terrain_name: str = ""
    """Name of the file with the heights of the ground; empty where it is level."""


class Examiner:
    """Examines the windows of a survey, one after the other.

    Args:
        examination: what is examined.
        mission: told what is found.
        recorder: record of the survey, for its frames.
        frame: frame of the survey's world.
        clock: clock of the examination.
    """

    def __init__(
        self,
        examination: Examination,
        mission: SurveyMission,
        recorder: MissionRecorder,
        frame: LocalFrame,
        clock: Clock,
    ) -> None:
        self._work = examination
        self._mission = mission
        self._recorder = recorder
        self._frame = frame
        self._clock = clock
        self._read: dict[int, Frame] = {}
        """Frames of the latest window, by their indices in the survey."""
        self._broken: dict[int, str] = {}
        """Reasons why images cannot be read, by their indices."""
        self._unusable: set[int] = set()
        """Indices of the images that were read, and reported to take no part."""
        self._overview = Overview(examination.survey.images, examination.bands, examination.ground_m)
        self._shown: set[int] = set()
        """Indices of the images that the overview holds."""

    async def run(self) -> str:
        """Examine what has not been examined, and conclude; return which pictures are left out, if they are many.

        Raises:
            InputDataError: no image can be read.
            ImagingError: no window can be examined.
            RecordingError: the disk is full.
        """
        done = len(self._mission.steps())
        if not done:
            for warning in self._work.survey.warnings:
                await self._mission.notice(Severity.WARNING, printable(warning))
            for name, reason in self._left_out_before():
                await self._mission.notice(Severity.INFO, f"Picture {name} left out: {reason}")
        for window in self._work.windows[:done]:
            await asyncio.to_thread(self._load, window)
        for number, window in enumerate(self._work.windows[done:], start=done + 1):
            await self._mission.update(message=self._progress(number, window))
            await self._examine(number, window)
            await self._recorder.flush()
        return await self._conclude()

    def _progress(self, number: int, window: FrameWindow) -> str:
        first, last, count = window.first + 1, window.last + 1, len(window.frames)
        # Between them may be pictures of another flight.
        some = f"{count} of the " if count < last - window.first else ""
        total = len(self._work.windows)
        return (
            f"Examining {some}pictures {first} to {last} of {len(self._work.survey.images)}, window {number} of {total}"
        )

    async def _conclude(self) -> str:
        mission, images = self._mission, len(self._work.survey.images)
        persons = mission.persons
        if len(self._broken) == images:
            raise InputDataError(f"None of the {images} images can be read: {next(iter(self._broken.values()))}")
        outcome = Outcome.FOUND if persons else Outcome.NOT_FOUND
        found = f"{persons} possible {'person' if persons == 1 else 'persons'}" if persons else "no person found"
        total, left_out = self._counted()
        seen = await asyncio.to_thread(seen_ground, self._work.survey.images, self._work.surface, self._work.ground_m)
        share = (await asyncio.to_thread(examined_ground, seen, self._took_part())).share
        result = f"{total - len(left_out)} of {total} pictures examined: {found}{self._limits(seen, share)}"
        many = _many_left_out(total, left_out)
        warnings = "Read the warnings about heights first." if self._work.survey.warnings else ""
        text = " ".join(filter(None, (result, many, warnings)))
        await self._recorder.record_outcome(OutcomeRecord(self._clock.utc_s(), outcome, {"images": images}))
        await mission.notice(Severity.INFO, text)
        await mission.update(phase=Phase.DONE, outcome=outcome, message=text)
        await self._recorder.flush()
        return many

    def _counted(self) -> tuple[int, list[tuple[str, str]]]:
        """Return the number of pictures to be examined, and the names of those that were not, with the reasons."""
        images, left_out = self._work.survey.images, self._left_out_before()
        total = len(images) + len(left_out)
        missing: dict[int, str] = {}
        examined = {index for window in self._took_part() for index in window}
        for window, step in zip(self._work.windows, self._mission.steps(), strict=False):
            missing |= {window.frames[number - 1]: reason for number, reason in step.missing.items()}
        unused = sorted(missing.keys() - examined)
        left_out += [(printable(images[index].path.name), printable(missing[index])) for index in unused]
        return total, left_out

    def _left_out_before(self) -> list[tuple[str, str]]:
        """Return the names of pictures that were left out when the recording was opened, with the reasons."""
        survey = self._work.survey
        return [
            (printable(name), printable(reason))
            for name, reason in survey.left_out.items()
            if name not in survey.not_chosen
        ]

    def _took_part(self) -> list[list[int]]:
        """Return the indices of the frames of each window that were examined in it."""
        return [
            [index for number, index in enumerate(window.frames, start=1) if number not in step.missing]
            for window, step in zip(self._work.windows, self._mission.steps(), strict=True)
        ]

    def _limits(self, seen: SeenGround, share: float) -> str:
        """Return the end of a result's sentence, and what a searcher must know of it: where nothing could be found.

        Args:
            seen: ground that the frames see.
            share: share of the ground with a height that was examined.
        """
        # Whole texts, as each has a translation of its own.
        percent, file = 100.0 * seen.share_unknown, self._work.terrain_name
        limit = ""
        if percent < _LEAST_PERCENT:
            if share <= 0.0:
                limit = (
                    f", as no place is in {MIN_VIEWS} successive pictures: only pictures that overlap can be examined"
                )
            elif share < _WHOLE:
                limit = (
                    f", in the {100.0 * share:.0f} % of the ground that {MIN_VIEWS} successive pictures or more show"
                )
            return f"{limit}."
        if share <= 0.0 and seen.known:
            limit = (
                f", as no place with a height is in {MIN_VIEWS} successive pictures: only pictures that overlap can be "
                "examined"
            )
        elif 0.0 < share < _WHOLE:
            limit = (
                f", in the {100.0 * share:.0f} % of the ground with a height that {MIN_VIEWS} successive pictures or "
                "more show"
            )
        return f"{limit}. {percent:.0f} % of the photographed ground has no height in {file}: not examined."

    async def _examine(self, number: int, window: FrameWindow) -> None:
        began_s = self._clock.now_s()
        broken = await asyncio.to_thread(self._load, window)
        for index in broken:
            await self._mission.notice(Severity.INFO, f"Picture left out: {self._broken[index]}")
        frames = [
            replace(self._read[index], vehicle_id=number_in_window)
            for number_in_window, index in enumerate(window.frames, start=1)
            if index in self._read
        ]
        missing = {
            number_in_window: self._broken[index]
            for number_in_window, index in enumerate(window.frames, start=1)
            if index in self._broken
        }
        found = WindowFound((), 0.0, {})
        if frames:
            found = await self._search(window, frames, missing)
        await self._record_frames(number, window, frames)
        record = self._step(number, frames, found, missing | dict(found.left_out))
        await self._mission.add_step(
            replace(record, elapsed_s=self._mission.elapsed_s(), work_ms=1000.0 * (self._clock.now_s() - began_s))
        )
        new = self._mission.observe(self._targets(number, found.candidates, window), number)
        await self._mission.add_pictures(await asyncio.to_thread(self._overview.pictures, number))
        for finding in new:
            if finding.kind in CLAIMED:
                what = "possible person" if finding.kind is FindingKind.PERSON else "anomaly"
                await self._mission.notice(Severity.INFO, f"Finding {finding.finding_id}: {what}")
        await self._mission.update(step=number)

    async def _search(self, window: FrameWindow, frames: Sequence[Frame], missing: dict[int, str]) -> WindowFound:
        search = partial(search_window, frames, self._work.surface, self._work.settings)
        try:
            found = await asyncio.to_thread(search)
        except ImagingError as error:
            if len(missing) + len(frames) == len(self._work.survey.images):
                raise
            await self._mission.notice(Severity.INFO, f"A window is left out: {error}")
            return WindowFound((), 0.0, {frame.vehicle_id: str(error) for frame in frames})
        for number, reason in found.left_out.items():
            index = window.frames[number - 1]
            if index not in self._unusable:
                self._unusable.add(index)
                name = printable(self._work.survey.images[index].path.name)
                await self._mission.notice(Severity.INFO, f"Picture {name} left out: {reason}")
        return found

    def _load(self, window: FrameWindow) -> list[int]:
        """Read the frames of a window that are not read yet; return the indices of those that newly cannot be."""
        new = [index for index in window.frames if index not in self._read and index not in self._broken]
        results = parallel_map(self._try_read, new)
        self._read = {index: frame for index, frame in self._read.items() if index in window.frames}
        broken = []
        for index, result in zip(new, results, strict=True):
            if isinstance(result, Frame):
                self._read[index] = result
            else:
                self._broken[index] = result
                broken.append(index)
        unseen = [index for index in window.frames if index in self._read and index not in self._shown]
        self._overview.add([self._read[index] for index in unseen])
        self._shown |= set(unseen)
        return broken

    def _try_read(self, index: int) -> Frame | str:
        image = self._work.survey.images[index]
        try:
            frame = reduced(read_frame(image, self._work.survey.bands))
        except InputDataError as error:
            return printable(str(error))
        return replace(frame, bands=self._work.bands)

    async def _record_frames(self, number: int, window: FrameWindow, frames: Sequence[Frame]) -> None:
        for frame in frames:
            index = window.frames[frame.vehicle_id - 1]
            image = self._work.survey.images[index]
            capture = Capture(
                vehicle_id=frame.vehicle_id,
                image_index=index,
                utc_s=_utc_s(image),
                image=frame.image,
                bands=frame.bands,
                position=self._frame.to_geodetic(frame.pose.position_enu_m),
                R_cam2enu=frame.pose.R_cam2enu,
                camera=frame.camera,
            )
            await self._recorder.record_frame(number, capture)

    def _step(self, number: int, frames: Sequence[Frame], found: WindowFound, missing: dict[int, str]) -> StepRecord:
        height_m = ground_height_m(frames, self._work.surface) if frames else self._work.ground_m
        return StepRecord(
            step=number,
            elapsed_s=0.0,
            phase=Phase.SCAN,
            visibility_m2=found.largest_m2,
            visibility_present_m2=found.largest_m2,
            threshold_m2=0.0,
            branch="",
            evolutionary_factor=None,
            evolutionary_state=None,
            c_s_m=None,
            c_c_m=None,
            leader_id=None,
            target_enu_m=None,
            fitness={},
            missing=missing,
            waypoints=(),
            imaging_ms=0.0,
            work_ms=0.0,
            loop_lag_p99_ms=0.0,
            focal_height_m=self._work.ground_m if math.isnan(height_m) else height_m,
        )

    def _targets(self, number: int, candidates: Sequence[Candidate], window: FrameWindow) -> list[TargetEstimate]:
        """Return what a window shows as targets, each with a track of its own; without what another saw better."""
        now_s = self._mission.elapsed_s()
        return [
            _target(1000 * number + index, candidate, now_s, self._pictures_of(candidate, window))
            for index, candidate in enumerate(candidates, start=1)
            if not self._is_known_better(candidate)
        ]

    def _pictures_of(self, candidate: Candidate, window: FrameWindow) -> str:
        """Return which pictures of a window hold a place."""
        place_m = np.array([candidate.position_enu_m])
        names = [
            printable(self._work.survey.images[index].path.name)
            for index in window.frames
            if (frame := self._read.get(index)) is not None
            and seen_pixels(project_points(place_m, frame.camera, frame.pose), frame.camera).any()
        ]
        span = f"{names[0]} to {names[-1]}" if len(names) > 1 else "".join(names)
        return f"in the view of {len(names)} pictures, {span}" if names else ""

    def _is_known_better(self, candidate: Candidate) -> bool:
        """Tell whether an earlier window shows it more clearly, or has claimed it where this one does not."""
        known = self._mission.known_at(candidate.position_enu_m, PERSON_M)
        if known is None or not known.is_claimed:
            return False
        return candidate.verdict.kind not in CLAIMED or (known.significance or 0.0) > candidate.significance


def _target(track_id: int, candidate: Candidate, now_s: float, pictures: str) -> TargetEstimate:
    verdict, place = candidate.verdict, candidate.place
    covariance_m2 = None if place is None else place.covariance_m2[:2, :2]
    return TargetEstimate(
        position_enu_m=candidate.position_enu_m,
        sigma_m=None if covariance_m2 is None else math.sqrt(float(covariance_m2.trace()) / 2.0),
        sightings=candidate.frames,
        track_id=track_id,
        ellipse=None if covariance_m2 is None else error_ellipse(covariance_m2),
        seen_at_s=now_s,
        person_confidence=verdict.probability,
        kind=verdict.kind,
        reasons=(*verdict.reasons, pictures) if pictures else verdict.reasons,
        significance=candidate.significance,
    )


def _utc_s(image: SurveyImage) -> float:
    """Return the time of exposure; 0 where it is not known, or of a clock that does not tell the date."""
    taken_at_s = image.taken_at_s
    return taken_at_s if taken_at_s is not None and 0.0 <= taken_at_s <= MAX_UTC_S else 0.0


def _many_left_out(total: int, left_out: Sequence[tuple[str, str]]) -> str:
    """Return how many of the pictures are left out, and why the first one is; empty where they are few."""
    if len(left_out) <= _MANY * total:
        return ""
    name, reason = left_out[0]
    return f"{len(left_out)} of {total} pictures are left out; {name}: {reason.removesuffix('.')}."
