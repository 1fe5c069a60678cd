"""The dashboard on a survey: examine a recorded flight, or show what an earlier examination has found."""

from __future__ import annotations

import asyncio
import fcntl
import logging
import os
import shutil
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from aos_gcs.clock import LoopClock
from aos_gcs.config.model import ApiConfig
from aos_gcs.errors import ConfigurationError, InputDataError, RecordingError
from aos_gcs.examination.examiner import Examination, Examiner
from aos_gcs.examination.overview import overview_grid
from aos_gcs.examination.state import PICTURES_KEY, SurveyPlace, SurveyState, restored
from aos_gcs.examination.survey_mission import SurveyMission
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.input_values import printable
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.planning.settings import AutofocusSettings
from aos_gcs.ports import Clock, Notice
from aos_gcs.runtime.dashboard.serving import open_dashboard
from aos_gcs.runtime.recorded.handover import HandoverPrinter
from aos_gcs.runtime.recorded.viewer import Viewer
from aos_gcs.runtime.sign_in import operator_secrets
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import MissionRecorder
from aos_gcs.store.schema import DATABASE_NAME

_log = logging.getLogger(__name__)

MANIFEST_KEY = "survey"
"""Entry of the manifest by which a folder is a survey: what was examined, and how."""

_NO_PLACE = (
    "Where the recording lies on the earth is not known: give --origin LAT,LON[,ALT] of the poses' world, or --crs "
    "EPSG:CODE of their coordinate system."
)


@dataclass(frozen=True, slots=True, eq=False)
class SurveyFolder:
    """Folder of a survey, and what is to be examined if it does not hold that yet.

    Args:
        folder: folder of the results.
        inputs: what is examined and how: a folder with others is not continued. None: whatever it holds.
        prepare: reads the recording; None: only what the folder holds is shown.
    """

    folder: Path
    inputs: dict[str, object] | None
    prepare: Callable[[], Examination] | None


def is_survey(folder: Path) -> bool:
    """Tell whether a folder holds the results of a survey.

    Raises:
        InputDataError: it is damaged, or holds a mission that was flown.
    """
    if not (folder / DATABASE_NAME).is_file():
        return False
    with MissionReader(folder) as reader:
        if MANIFEST_KEY not in reader.manifest():
            raise InputDataError(f"{folder} is the record of a mission: show it with aos-gcs replay.")
    return True


async def run_survey(survey: SurveyFolder, config: ApiConfig | None, imaging: ImagingSettings) -> MissionSnapshot:
    """Examine what is not examined yet, and return the state then.

    Args:
        survey: the survey.
        config: address of the dashboard, which stays until this is cancelled; None: no dashboard.
        imaging: settings by which frames are analysed when they are looked at again.

    Raises:
        ConfigurationError, InputDataError, ImagingError: the survey cannot be examined.
        RecordingError: the disk is full.
    """
    clock, state = LoopClock(), _known(survey)
    if config is None and state is not None and (state.is_finished or survey.prepare is None):
        return state.snapshot
    async with _open(survey, clock) as (mission, examiner), asyncio.TaskGroup() as group:
        reporting = group.create_task(mission.report())
        if config is None:
            await _examine(examiner)
        else:
            viewer = Viewer(survey.folder, imaging, AutofocusSettings().reach_m)
            secrets = operator_secrets(config)
            handovers = HandoverPrinter(lambda: survey.folder, clock.utc_s)
            async with open_dashboard(mission, config, secrets, findings=mission, viewer=viewer, handovers=handovers):
                await _examine(examiner)
                _log.info("%s The dashboard stays available until Ctrl-C.", mission.snapshot().message)
                await asyncio.Event().wait()
        reporting.cancel()
    return mission.snapshot()


async def _examine(examiner: Examiner | None) -> None:
    if examiner is not None and (left_out := await examiner.run()):
        _log.warning("%s", left_out)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Keep other programs from continuing a survey for as long as the context is entered.

    Raises:
        ConfigurationError: another one does.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError as error:
        raise ConfigurationError(f"{folder} is open in another aos-gcs survey: end that first.") from error
    finally:
        os.close(descriptor)


@asynccontextmanager
async def _open(survey: SurveyFolder, clock: Clock) -> AsyncIterator[tuple[SurveyMission, Examiner | None]]:
    """Open the record of a survey, a new one or that of an earlier examination."""
    folder = survey.folder
    if not folder.exists():
        async with _new(survey, clock) as opened:
            yield opened
        return
    # Read again, as another program may have continued it until now.
    with _alone(folder):
        state = _known(survey)
        if state is None:
            raise InputDataError(f"{folder} holds no survey.")
        async with MissionRecorder.reopen(folder, state.snapshot.step, notify=_warn) as recorder:
            mission, examiner = SurveyMission(state, recorder, clock), None
            if not state.is_finished and survey.prepare is not None:
                examination = await asyncio.to_thread(survey.prepare)
                _require_its_windows(folder, examination, state.snapshot.step)
                examiner = _examiner(examination, mission, recorder, clock)
            yield mission, examiner


@asynccontextmanager
async def _new(survey: SurveyFolder, clock: Clock) -> AsyncIterator[tuple[SurveyMission, Examiner]]:
    """Begin the record of a survey, once its pictures are known."""
    if survey.prepare is None:
        raise InputDataError(f"{survey.folder} holds no survey.")
    began_s, folder = clock.now_s(), survey.folder
    examination = await asyncio.to_thread(survey.prepare)
    place = _place(folder.name, examination)
    names = [printable(image.path.name) for image in examination.survey.images]
    manifest = {MANIFEST_KEY: survey.inputs, PICTURES_KEY: names}
    has_begun = False
    try:
        async with MissionRecorder.create(folder.parent, folder.name, manifest, notify=_warn) as recorder:
            with _alone(folder):
                snapshot = replace(place.snapshot(), elapsed_s=clock.now_s() - began_s)
                mission = SurveyMission(SurveyState(snapshot), recorder, clock)
                await mission.update()
                await recorder.flush()
                has_begun = True
                yield mission, _examiner(examination, mission, recorder, clock)
    except RecordingError:
        if not has_begun:
            # Without its first state it could be neither shown nor continued.
            await asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True)
        raise


def _examiner(examination: Examination, mission: SurveyMission, recorder: MissionRecorder, clock: Clock) -> Examiner:
    origin = examination.survey.origin
    if origin is None:
        raise ConfigurationError(_NO_PLACE)
    return Examiner(examination, mission, recorder, LocalFrame(origin), clock)


def _known(survey: SurveyFolder) -> SurveyState | None:
    """Return the state that the folder holds; None if there is none.

    Raises:
        ConfigurationError: it holds something else.
    """
    if not survey.folder.exists():
        return None
    if not is_survey(survey.folder):
        raise ConfigurationError(f"{survey.folder} exists already and holds no survey: name another folder with --out.")
    with MissionReader(survey.folder) as reader:
        if survey.inputs is not None and reader.manifest()[MANIFEST_KEY] != survey.inputs:
            raise ConfigurationError(
                f"{survey.folder} holds a survey of other pictures, or with other options: name another folder with "
                "--out, or remove it."
            )
        return restored(reader)


def _require_its_windows(folder: Path, examination: Examination, done: int) -> None:
    """Refuse to continue what another version of the program has begun with other windows: it would leave out ground.

    Raises:
        ConfigurationError: the record has frames of a window that are not in it now.
    """
    windows = examination.windows
    with MissionReader(folder) as reader:
        kept = [(entry.step, entry.image_index) for entry in reader.frames() if 1 <= entry.step <= done]
    if done > len(windows) or any(index not in windows[step - 1].frames for step, index in kept):
        raise ConfigurationError(
            f"{folder} was begun by another version of aos-gcs, which examined other pictures together: name another "
            "folder with --out, or remove it."
        )


def _place(name: str, examination: Examination) -> SurveyPlace:
    origin = examination.survey.origin
    if origin is None:
        raise ConfigurationError(_NO_PLACE)
    grid = overview_grid(examination.survey.images, examination.ground_m)
    east_m, south_m = (
        grid.west_m + grid.columns * grid.resolution_m,
        grid.north_m - grid.rows * grid.resolution_m,
    )
    corners = ((grid.west_m, south_m), (east_m, south_m), (east_m, grid.north_m), (grid.west_m, grid.north_m))
    return SurveyPlace(name, origin, corners, examination.ground_m)


def _warn(notice: Notice) -> None:
    _log.warning("%s", notice.text)
