"""Pictures of tiles, from the frames on the disk: functions for a worker.

The record has every frame that the mission has used, a moment after it has come. To take pictures from there costs the
flight nothing, and a picture that is shown is one that is on record.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.pictures import CONTRAST_SAMPLES, THERMAL_CONTRAST_PERCENTILES, shade_integral
from aos_gcs.store.frame_entry import FrameEntry
from aos_gcs.store.reader import MissionReader
from aos_gcs.wall.model import FrameFacts, ThermalScale, TileKind, TilePicture

_JPEG_OPTIONS: Final = [cv2.IMWRITE_JPEG_QUALITY, 75]
_THERMAL: Final = "thermal"
_OUTSIDE: Final = 24
"""Grey of cells that no frame covers."""


def newest_frames(folder: Path, after: int, until_utc_s: float | None) -> tuple[FrameFacts, ...]:
    """Return the newest frame of each vehicle among those after a number, and exposed until a time.

    Raises:
        InputDataError: there is no record, or it is damaged.
    """
    with MissionReader(folder) as reader:
        return tuple(map(frame_facts, reader.newest_frames(after, until_utc_s)))


def render_frame(folder: Path, number: int, wanted: Sequence[tuple[TileKind, int]]) -> tuple[TilePicture, ...]:
    """Return pictures of a frame of some kinds and widths in pixels; its file is read once.

    Raises:
        InputDataError: the frame is missing or damaged, or has no such kind.
    """
    with MissionReader(folder) as reader:
        capture = reader.frame(number).load()
    return tuple(_picture(capture.image, capture.bands, kind, width_px) for kind, width_px in wanted)


def render_raster(png: bytes, width_px: int) -> TilePicture:
    """Return a picture of a raster of the mission, a PNG with transparency.

    Raises:
        InputDataError: it is no picture.
    """
    bgra = cv2.imdecode(np.frombuffer(png, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if bgra is None or bgra.ndim != 3 or bgra.shape[2] != 4:
        raise InputDataError("a raster of the mission is damaged; the next step makes another one")
    premultiplied = bgra[:, :, :3].astype(np.float32) * (bgra[:, :, 3:] / np.float32(255.0))
    premultiplied += np.float32(_OUTSIDE) * (1.0 - bgra[:, :, 3:] / np.float32(255.0))
    return _encoded(_reduced(premultiplied, width_px), None)


def frame_facts(entry: FrameEntry) -> FrameFacts:
    """Return a frame without its image.

    Raises:
        InputDataError: the row is damaged.
    """
    position, R_cam2enu = entry.pose()
    east, north, up = map(float, R_cam2enu[:, 2])
    return FrameFacts(
        number=entry.number,
        vehicle_id=entry.vehicle_id,
        utc_s=entry.utc_s,
        kinds=kinds_of(entry.bands()),
        latitude_deg=position.latitude_deg,
        longitude_deg=position.longitude_deg,
        altitude_amsl_m=position.altitude_amsl_m,
        axis_enu=(east, north, up),
    )


def kinds_of(bands: tuple[str, ...]) -> tuple[TileKind, ...]:
    """Return the kinds of tiles that a frame of these bands has."""
    has_thermal, has_other = _THERMAL in bands, bool(bands) and bands != (_THERMAL,)
    return (TileKind.COLOUR,) * has_other + (TileKind.THERMAL,) * has_thermal


def _picture(image: NDArray[np.generic], bands: tuple[str, ...], kind: TileKind, width_px: int) -> TilePicture:
    if kind not in kinds_of(bands):
        raise InputDataError(f"the frame has no {kind} band; it has {', '.join(bands)}")
    if kind is TileKind.THERMAL:
        is_celsius = image.dtype == np.float32
        return _thermal(_reduced(image[:, :, bands.index(_THERMAL)].astype(np.float32), width_px), is_celsius)
    others = [index for index, band in enumerate(bands) if band != _THERMAL]
    small = _reduced(image[:, :, others].astype(np.float32), width_px)
    small = small.reshape(*small.shape[:2], len(others))  # OpenCV drops a single band
    rgba = shade_integral(small, tuple(bands[index] for index in others))
    return _encoded(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), None)


def _thermal(band: NDArray[np.float32], is_celsius: bool) -> TilePicture:
    """Return temperatures, shape (H, W), from black to yellow, with the values of both ends."""
    samples = band[np.isfinite(band)]
    samples = samples[:: max(1, samples.size // CONTRAST_SAMPLES)]
    low, high = map(float, np.percentile(samples, THERMAL_CONTRAST_PERCENTILES)) if samples.size else (0.0, 0.0)
    shades = np.nan_to_num((band - low) * (255.0 / max(high - low, 1e-6)), nan=0.0)
    coloured = cv2.applyColorMap(np.clip(shades, 0.0, 255.0).astype(np.uint8), cv2.COLORMAP_INFERNO)
    return _encoded(coloured, ThermalScale(low, high, is_celsius))


def _reduced(image: NDArray[np.float32], width_px: int) -> NDArray[np.float32]:
    """Return an image of a width, of the same shape otherwise, or as it is where it is narrower."""
    rows, columns = image.shape[:2]
    if columns > width_px:
        size = width_px, max(1, round(rows * width_px / columns))
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), dtype=np.float32)
    return image


def _encoded(bgr: NDArray[np.generic], scale: ThermalScale | None) -> TilePicture:
    whole = np.clip(bgr, 0, 255).astype(np.uint8)
    height_px, width_px = whole.shape[:2]
    return TilePicture(cv2.imencode(".jpg", whole, _JPEG_OPTIONS)[1].tobytes(), width_px, height_px, scale)
