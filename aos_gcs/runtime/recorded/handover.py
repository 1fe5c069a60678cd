"""Hand-overs of recorded missions as files, with pictures of the findings computed from their frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Final, ParamSpec, TypeVar

import cv2
import numpy as np

from aos_gcs.errors import AosError, WorkerError
from aos_gcs.extras import load_extra
from aos_gcs.handover.contents import read_handover
from aos_gcs.handover.flights import to_csv
from aos_gcs.handover.model import FindingPicture, Handover, HandoverOptions, ReportedFinding
from aos_gcs.handover.texts import make_writer
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.viewing import PictureFormat, ViewerBusyError, ViewKind, ViewWindow
from aos_gcs.runtime.processes.workers import HANDOVER
from aos_gcs.runtime.recorded.step_views import ViewSource, view_step
from aos_gcs.runtime.recorded.viewer import view_source
from aos_gcs.store.reader import MissionReader
from aos_gcs.workers.process import open_worker

P = ParamSpec("P")
T = TypeVar("T")

MOST_PICTURED: Final = 60
"""Number of findings that have pictures: the first ones, which are the confirmed and the announced."""
_HALF_WIDTH_M: Final = 4.0
_KINDS: Final = {ViewKind.INTEGRAL: "Integral", ViewKind.THERMAL: "Thermal integral"}


def make_handover(folder: Path, options: HandoverOptions, printed_utc_s: float) -> bytes:
    """Return the hand-over of a mission folder as a PDF.

    Args:
        folder: mission folder, also of a mission that is in flight.
        options: paper, notation and time zone.
        printed_utc_s: time at which it is made.

    Raises:
        ConfigurationError: the library for PDF is not installed, or the time zone is not known.
        InputDataError: the record is damaged, or holds no state of the mission.
    """
    check_printing(options)
    from aos_gcs.handover.document import write_document  # noqa: PLC0415 - its library may be missing

    with MissionReader(folder) as reader:
        handover = _with_pictures(read_handover(reader), view_source(reader))
    file = BytesIO()
    write_document(file, handover, options, printed_utc_s)
    return file.getvalue()


def make_flight_log(folder: Path) -> str:
    """Return the flights of a mission folder as CSV.

    Raises:
        InputDataError: the record is damaged, or holds no state of the mission.
    """
    with MissionReader(folder) as reader:
        handover = read_handover(reader)
    return to_csv(handover.flights, handover.operation, handover.sortie)


def check_printing(options: HandoverOptions) -> None:
    """Refuse a hand-over that could not be printed, before work is done for it.

    Raises:
        ConfigurationError: the library for PDF is not installed, or the time zone is not known.
    """
    load_extra("reportlab", "report", "A hand-over as PDF")
    make_writer(options.time_zone, options.notation, None)


class HandoverPrinter:
    """Implementation of ``HandoverControl`` on a mission folder.

    Each hand-over is made in a process of its own, which ends with it: none is kept for what is wanted twice a day.

    Args:
        folder: returns the mission folder; that of the sortie shown, in a replay.
        utc_s: clock of the print.
    """

    def __init__(self, folder: Callable[[], Path], utc_s: Callable[[], float]) -> None:
        self._folder = folder
        self._utc_s = utc_s
        self._is_busy = False

    async def handover(self, options: HandoverOptions) -> bytes:
        """Return the hand-over of the mission so far as a PDF."""
        check_printing(options)
        return await self._compute(make_handover, self._folder(), options, self._utc_s())

    async def flight_log(self) -> str:
        """Return the flights of all vehicles so far as CSV."""
        return await self._compute(make_flight_log, self._folder())

    async def _compute(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        if self._is_busy:
            raise ViewerBusyError("A hand-over is being made already; try again in a moment.")
        self._is_busy = True
        try:
            async with open_worker(HANDOVER) as worker:
                await worker.ready()
                return await worker.run(function, *args, **kwargs)
        except WorkerError as error:
            raise ViewerBusyError(f"{error}; try again in a moment.") from error
        finally:
            self._is_busy = False


def _with_pictures(handover: Handover, source: ViewSource) -> Handover:
    """Return the hand-over with pictures of the first findings."""
    findings = tuple(
        _pictured(reported, source) if index < MOST_PICTURED else replace(reported, pictures_missing=_too_many())
        for index, reported in enumerate(handover.findings)
    )
    return replace(handover, findings=findings)


def _too_many() -> str:
    return f"the first {MOST_PICTURED} findings have pictures; this one is on the dashboard."


def _pictured(reported: ReportedFinding, source: ViewSource) -> ReportedFinding:
    finding = reported.finding
    if finding.step < 1:
        return replace(reported, pictures_missing="it was marked before the first step; no frame shows it.")
    pictures: list[FindingPicture] = []
    reason = ""
    for kind in _KINDS:
        try:
            pictures.append(_picture(finding, kind, source.of_sortie(finding.found_in)))
        except AosError as error:
            reason = reason or str(error)
    return replace(reported, pictures=tuple(pictures), pictures_missing="" if pictures else reason)


def _picture(finding: Finding, kind: ViewKind, source: ViewSource) -> FindingPicture:
    east_m, north_m, up_m = finding.position_enu_m
    window = ViewWindow(east_m, north_m, _HALF_WIDTH_M)
    height_m = up_m if finding.sightings else None
    view = view_step(source, finding.step, kind, height_m, window=window, picture_format=PictureFormat.PNG)
    caption = f"{_KINDS[kind]} of step {finding.step}, {2.0 * _HALF_WIDTH_M:g} m wide, north up"
    return FindingPicture(caption, 2.0 * _HALF_WIDTH_M, _on_white(view.data))


def _on_white(png: bytes) -> bytes:
    """Return an RGBA picture as a JPEG on white: ink is for what was seen."""
    bgra = np.asarray(cv2.imdecode(np.frombuffer(png, dtype=np.uint8), cv2.IMREAD_UNCHANGED), dtype=np.float32)
    alpha = bgra[:, :, 3:] / 255.0
    bgr = bgra[:, :, :3] * alpha + 255.0 * (1.0 - alpha)
    _, encoded = cv2.imencode(".jpg", np.rint(bgr).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 90])
    return encoded.tobytes()
