"""Views of the recorded steps of a mission: on other focal planes, and frame by frame.

The frames are those on the disk, so that a flying mission and a record are seen in the same way.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import ParamSpec, TypeVar

from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError, WorkerError
from aos_gcs.groundmap.detection import Posture
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.viewing import (
    FocusFound,
    FrameKind,
    GroundFile,
    PictureFormat,
    View,
    ViewedStep,
    ViewerBusyError,
    ViewKind,
    ViewWindow,
)
from aos_gcs.planning.settings import AutofocusSettings, MissionSettings
from aos_gcs.ports import ThreadWorker, Worker
from aos_gcs.runtime.recorded.searched_ground import make_ground_file
from aos_gcs.runtime.recorded.step_views import ViewSource, describe_step, find_height, view_frame, view_step
from aos_gcs.store.reader import MissionReader

P = ParamSpec("P")
T = TypeVar("T")

MAX_WAITING = 8


class Viewer:
    """Implementation of ``ViewControl`` on a mission folder, of a mission in flight or ended.

    Args:
        folder: mission folder.
        settings: analysis of the mission's frames.
        focus_reach_m: range of autofocus above and below the mission's plane.
        worker: computes the views; None: in threads of this process.
    """

    def __init__(
        self, folder: Path, settings: ImagingSettings, focus_reach_m: float, worker: Worker | None = None
    ) -> None:
        self._source = ViewSource(folder, settings, focus_reach_m)
        self._worker = worker or ThreadWorker()
        self._turn = asyncio.Lock()
        self._waiting = 0

    async def describe(self, step: int) -> ViewedStep:
        """Return what can be seen of a recorded step."""
        return await self._compute(describe_step, self._source, step)

    async def view(
        self,
        step: int,
        kind: ViewKind,
        height_m: float | None,
        window: ViewWindow | None = None,
        picture_format: PictureFormat = PictureFormat.PNG,
    ) -> View:
        """Return the integral of a step's frames on the plane of this height, None: the mission's own."""
        return await self._compute(
            view_step, self._source, step, kind, height_m, window=window, picture_format=picture_format
        )

    async def frame(self, step: int, vehicle_id: int, kind: FrameKind, width_px: int | None) -> bytes:
        """Return a vehicle's frame of a step as a PNG, reduced to a width if it is wider."""
        return await self._compute(view_frame, self._source, step, vehicle_id, kind, width_px)

    async def ground_file(self, kind: GroundFile, posture: Posture, below: float) -> bytes:
        """Return a file of the searched ground; gaps are where detection in a posture is less likely than ``below``."""
        return await self._compute(make_ground_file, self._source.folder, kind, posture, below)

    async def autofocus(self, step: int, centre_enu_m: tuple[float, float], half_width_m: float) -> FocusFound:
        """Look for the height at which the frames agree best on a square."""
        return await self._compute(find_height, self._source, step, centre_enu_m, half_width_m)

    async def _compute(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        async with self._in_turn():
            try:
                return await self._worker.run(function, *args, **kwargs)
            except WorkerError as error:
                raise ViewerBusyError(f"{error}; try again in a moment.") from error

    @asynccontextmanager
    async def _in_turn(self) -> AsyncIterator[None]:
        """One after the other: the flying mission needs the cores, too."""
        if self._waiting >= MAX_WAITING:
            raise ViewerBusyError(f"{MAX_WAITING} requests for pictures wait already; try again in a moment.")
        self._waiting += 1
        try:
            async with self._turn:
                yield
        finally:
            self._waiting -= 1


def open_viewer(reader: MissionReader, worker: Worker | None = None) -> Viewer:
    """Return the viewer of a recorded mission, with the settings that it was flown with; see ``Viewer``."""
    source = view_source(reader)
    return Viewer(source.folder, source.settings, source.focus_reach_m, worker)


def view_source(reader: MissionReader) -> ViewSource:
    """Return the frames of a recorded mission and the settings that it was flown with.

    A record of another version, whose settings mean nothing to this one, is seen with the usual settings.
    """
    settings = recorded_settings(reader)
    if settings is None:
        return ViewSource(reader.folder, ImagingSettings(), AutofocusSettings().reach_m)
    return ViewSource(reader.folder, settings.imaging, settings.autofocus.reach_m)


def recorded_settings(reader: MissionReader) -> MissionSettings | None:
    """Return the settings that a recorded mission was flown with; None for a record of another version."""
    configuration = reader.manifest().get("configuration")
    try:
        return mission_settings(parse_config(configuration if isinstance(configuration, dict) else {}))
    except ConfigurationError:
        return None
