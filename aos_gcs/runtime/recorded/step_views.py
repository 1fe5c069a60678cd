"""Computation of views of recorded steps, from the frames on the disk: functions for a worker.

A worker remembers the latest steps and analyses: sliders and magnifiers ask for the same ones many times.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, ImagingError, InputDataError
from aos_gcs.examination.state import picture_names
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.imaging.focus.autofocus import find_focus
from aos_gcs.imaging.focus.measure import FocusSignal
from aos_gcs.imaging.focus.region import GroundRegion
from aos_gcs.imaging.model import FocalGrid, Frame, StepAnalysis
from aos_gcs.imaging.pictures import MAX_CELLS, encode_jpeg, encode_png, shade_integral, shade_step, shade_thermal
from aos_gcs.imaging.step.analysis import analyse_step
from aos_gcs.imaging.step.examination import ExaminedFrame, examine
from aos_gcs.imaging.step.integration import integrate
from aos_gcs.imaging.step.settings import DEPTH_BELOW_M, ImagingSettings
from aos_gcs.imaging.views import grid_view
from aos_gcs.mission.search.frames.sampling import to_frame
from aos_gcs.mission.viewing import (
    FocusFound,
    FrameKind,
    PictureFormat,
    View,
    ViewedFrame,
    ViewedStep,
    ViewKind,
    ViewWindow,
)
from aos_gcs.store.reader import MissionReader
from aos_gcs.store.recorder import FOLDER_NAME

T = TypeVar("T")

KEPT_STEPS = 2
"""Number of steps whose frames stay in memory: two can be compared. Ten frames of a step take 10 to 40 MB."""
KEPT_ANALYSES = 4
"""Number of analysed planes that stay in memory: another kind of picture of them needs no new computation."""
CLEARANCE_M = 1.0
"""Distance of the highest plane to the lowest camera."""
MAX_CLOSE_UP_CELLS = 400
"""Largest edge of a close-up."""
_NOTHING_THERE = "window: no frame of the step looks at this place."
_ENCODE = {PictureFormat.PNG: encode_png, PictureFormat.JPEG: encode_jpeg}


@dataclass(frozen=True, slots=True)
class ViewSource:
    """A mission folder, and how its frames are analysed."""

    folder: Path
    settings: ImagingSettings
    focus_reach_m: float
    """Range of autofocus above and below the mission's plane."""

    def of_sortie(self, found_in: str) -> ViewSource:
        """Return the frames of an earlier sortie, whose folder lies beside this one; those of this one for no name."""
        if not re.fullmatch(FOLDER_NAME, found_in):
            return self
        return replace(self, folder=self.folder.absolute().parent / found_in)


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    step: int
    frames: tuple[Frame, ...]
    utc_s: tuple[float, ...]
    """Times of the frames' exposures."""
    names: tuple[str, ...]
    """Names of the frames' pictures in a survey; empty texts in missions."""
    focal_height_m: float
    examine: Callable[[Frame], ExaminedFrame]
    """Remembers the masks: they are the same on every plane, and finding them takes longer than all else."""

    @property
    def heights_m(self) -> tuple[float, float]:
        """Lowest and highest plane that can be looked at."""
        lowest_camera_m = min(float(frame.pose.position_enu_m[2]) for frame in self.frames)
        return self.focal_height_m - DEPTH_BELOW_M, lowest_camera_m - CLEARANCE_M


@lru_cache(maxsize=KEPT_STEPS)
def _read(source: ViewSource, step: int) -> _Step:
    with MissionReader(source.folder) as reader:
        record, snapshot = reader.step(step), reader.last_snapshot()
        captures = [entry.load() for entry in reader.frames(step)]
        names = picture_names(reader)
    if snapshot is None or snapshot.origin is None or not captures:
        raise InputDataError(f"{source.folder} holds no frames of step {step}")
    frame = LocalFrame(snapshot.origin)
    height_m = source.settings.plane_height_m if record.focal_height_m is None else record.focal_height_m
    return _Step(
        step=step,
        frames=tuple(to_frame(capture, frame) for capture in captures),
        utc_s=tuple(capture.utc_s for capture in captures),
        names=tuple(names.get(capture.image_index, "") for capture in captures),
        focal_height_m=height_m,
        examine=cache(partial(examine, settings=source.settings)),
    )


@lru_cache(maxsize=KEPT_ANALYSES)
def _analyse(source: ViewSource, step: int, height_m: float) -> StepAnalysis:
    # Finer cells than a picture has would only cost time: a slider waits for this.
    settings = replace(source.settings, plane_height_m=height_m, max_cells=MAX_CELLS)
    loaded = _read(source, step)
    return _with_error(lambda: analyse_step(loaded.frames, settings, known=loaded.examine), InputDataError)


@lru_cache(maxsize=KEPT_ANALYSES)
def _mean(source: ViewSource, step: int, height_m: float) -> NDArray[np.float32]:
    """Return the mean of a step's frames on the raster of their analysis, shape (rows, columns, C)."""
    analysis = _analyse(source, step, height_m)
    frames = [frame for frame in _read(source, step).frames if frame.vehicle_id in analysis.vehicle_ids]
    return integrate(frames, analysis.grid).mean


def describe_step(source: ViewSource, step: int) -> ViewedStep:
    """Return what can be seen of a recorded step."""
    loaded = _read(source, step)
    low_m, high_m = loaded.heights_m
    kinds = [kind for kind in ViewKind if kind is not ViewKind.THERMAL or "thermal" in loaded.frames[0].bands]
    return ViewedStep(
        step=step,
        focal_height_m=loaded.focal_height_m,
        min_height_m=low_m,
        max_height_m=high_m,
        kinds=tuple(kinds),
        frames=tuple(map(_described, loaded.frames, loaded.utc_s, loaded.names)),
    )


def view_step(
    source: ViewSource,
    step: int,
    kind: ViewKind,
    height_m: float | None,
    *,
    window: ViewWindow | None,
    picture_format: PictureFormat,
) -> View:
    """Return the integral of a step's frames on the plane of a height, None: the mission's own."""
    loaded = _read(source, step)
    low_m, high_m = loaded.heights_m
    chosen_m = loaded.focal_height_m if height_m is None else height_m
    if not low_m <= chosen_m <= high_m:
        raise ConfigurationError(
            f"height_m must lie within {low_m:.1f} and {high_m:.1f}, below the cameras, but is {chosen_m:g}."
        )
    if window is not None and kind in {ViewKind.INTEGRAL, ViewKind.THERMAL}:
        return _close_up(loaded, kind, chosen_m, window, picture_format)
    analysis = _analyse(source, step, chosen_m)
    mean = _mean(source, step, chosen_m) if kind in {ViewKind.INTEGRAL, ViewKind.THERMAL} else None
    if window is not None:
        rows, columns = _cells_within(analysis.grid, window)
        analysis, mean = _part(analysis, rows, columns), None if mean is None else mean[rows, columns]
    return _shaded(loaded, kind, analysis, mean, picture_format)


def _close_up(
    loaded: _Step, kind: ViewKind, height_m: float, window: ViewWindow, picture_format: PictureFormat
) -> View:
    """Return a part of a plane as sharp as the frames are: the raster of all that they see may be coarser."""
    half_m = window.half_width_m
    finest_m = min((float(frame.pose.position_enu_m[2]) - height_m) / frame.camera.fx_px for frame in loaded.frames)
    edge = min(MAX_CLOSE_UP_CELLS, max(1, math.ceil(2.0 * half_m / finest_m)))
    grid = FocalGrid(window.east_m - half_m, window.north_m + half_m, 2.0 * half_m / edge, edge, edge, height_m)
    view = grid_view(grid)
    frames = [frame for frame in loaded.frames if view.project(frame) is not None and not loaded.examine(frame).fault]
    if window.nearest_only:
        frames = _nearest(frames, window)
    integral = integrate(frames, grid) if frames else None
    if integral is None or not integral.coverage.any():
        raise ConfigurationError(_NOTHING_THERE)
    nothing = np.zeros_like(integral.coverage)
    analysis = StepAnalysis(grid, integral.coverage, nothing, None, (), np.empty(0), None)
    return _shaded(loaded, kind, analysis, integral.mean, picture_format)


def _nearest(frames: Sequence[Frame], window: ViewWindow) -> list[Frame]:
    """Return the frame whose camera is the nearest to a window's middle, seen from above; none of none."""

    def distance_m(frame: Frame) -> float:
        east_m, north_m, _ = frame.pose.position_enu_m
        return math.hypot(east_m - window.east_m, north_m - window.north_m)

    return sorted(frames, key=distance_m)[:1]


def _shaded(
    loaded: _Step,
    kind: ViewKind,
    analysis: StepAnalysis,
    mean: NDArray[np.float32] | None,
    picture_format: PictureFormat,
) -> View:
    images = shade_step(analysis, mean, loaded.frames[0].bands, [kind.value])
    if not images:
        raise ConfigurationError(f"kind: the frames of step {loaded.step} have no {kind.value} band.")
    grid = analysis.grid
    return View(
        height_m=grid.height_m,
        visibility_m2=analysis.visibility_m2,
        data=_ENCODE[picture_format](images[kind.value]),
        west_m=grid.west_m,
        south_m=grid.north_m - grid.rows * grid.resolution_m,
        east_m=grid.west_m + grid.columns * grid.resolution_m,
        north_m=grid.north_m,
    )


def view_frame(source: ViewSource, step: int, vehicle_id: int, kind: FrameKind, width_px: int | None) -> bytes:
    """Return a vehicle's frame of a step as a PNG, reduced to a width if it is wider."""
    frames = [frame for frame in _read(source, step).frames if frame.vehicle_id == vehicle_id]
    if not frames:
        raise ConfigurationError(f"vehicle_id: step {step} has no frame of vehicle {vehicle_id}.")
    frame = frames[-1]
    if kind not in _kinds(frame):
        raise ConfigurationError(f"kind: the frame of vehicle {vehicle_id} has no {kind.value} band.")
    image = _reduced(frame.image.astype(np.float32), width_px)
    if kind is FrameKind.THERMAL:
        return encode_png(shade_thermal(image[..., frame.bands.index("thermal")]))
    return encode_png(shade_integral(image, frame.bands))


def find_height(source: ViewSource, step: int, centre_enu_m: tuple[float, float], half_width_m: float) -> FocusFound:
    """Look for the height at which the frames agree best on a square."""
    loaded = _read(source, step)
    (east_m, north_m), (_, high_m) = centre_enu_m, loaded.heights_m
    around_m, reach_m = loaded.focal_height_m, source.focus_reach_m

    def search() -> FocusFound:
        region = GroundRegion(
            east_m - half_width_m, north_m - half_width_m, east_m + half_width_m, north_m + half_width_m
        )
        result = find_focus(
            loaded.frames, region, around_m - reach_m, min(around_m + reach_m, high_m), signal=FocusSignal.TEXTURE
        )
        return FocusFound(result.height_m, result.sigma_m, result.found, result.reason)

    return _with_error(search, ConfigurationError)


def _cells_within(grid: FocalGrid, window: ViewWindow) -> tuple[slice, slice]:
    """Return the rows and columns of a raster that lie within a window."""
    half_m = window.half_width_m
    west, east = ((window.east_m + side - grid.west_m) / grid.resolution_m for side in (-half_m, half_m))
    north, south = ((grid.north_m - window.north_m + side) / grid.resolution_m for side in (-half_m, half_m))
    columns = slice(max(0, round(west)), min(grid.columns, round(east)))
    rows = slice(max(0, round(north)), min(grid.rows, round(south)))
    if rows.start >= rows.stop or columns.start >= columns.stop:
        raise ConfigurationError(_NOTHING_THERE)
    return rows, columns


def _part(analysis: StepAnalysis, rows: slice, columns: slice) -> StepAnalysis:
    """Return a part of a step's rasters."""
    grid = analysis.grid
    return replace(
        analysis,
        grid=replace(
            grid,
            west_m=grid.west_m + columns.start * grid.resolution_m,
            north_m=grid.north_m - rows.start * grid.resolution_m,
            rows=rows.stop - rows.start,
            columns=columns.stop - columns.start,
        ),
        coverage=analysis.coverage[rows, columns],
        anomaly_count=analysis.anomaly_count[rows, columns],
    )


def _with_error(compute: Callable[[], T], kind: type[InputDataError | ConfigurationError]) -> T:
    """Return the result of a computation; errors of imaging become errors of the given kind."""
    try:
        return compute()
    except ImagingError as error:
        raise kind(str(error)) from error


def _reduced(image: NDArray[np.float32], width_px: int | None) -> NDArray[np.float32]:
    """Return an image, shape (H, W, C), at most so wide, of the same shape otherwise."""
    rows, columns, bands = image.shape
    if width_px is None or width_px >= columns:
        return image
    size = width_px, max(1, round(rows * width_px / columns))
    reduced = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return np.asarray(reduced, dtype=np.float32).reshape(*size[::-1], bands)


def _described(frame: Frame, utc_s: float, name: str) -> ViewedFrame:
    east_m, north_m, up_m = map(float, frame.pose.position_enu_m)
    rows, columns = frame.image.shape[:2]
    return ViewedFrame(frame.vehicle_id, utc_s, (east_m, north_m, up_m), columns, rows, _kinds(frame), name)


def _kinds(frame: Frame) -> tuple[FrameKind, ...]:
    has_thermal, has_other = "thermal" in frame.bands, frame.bands != ("thermal",)
    return (FrameKind.COLOUR,) * has_other + (FrameKind.THERMAL,) * has_thermal
