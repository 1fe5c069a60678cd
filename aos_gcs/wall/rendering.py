"""Pictures of tiles, from the frames on the disk: functions for a worker.

The record has every frame that the mission has used, a moment after it has come. To take pictures from there costs the
flight nothing, and a picture that is shown is one that is on record.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.imaging.pictures import COLOUR_BANDS, CONTRAST_SAMPLES, THERMAL_CONTRAST_PERCENTILES, shade_integral
from aos_gcs.store.frame_entry import FrameEntry
from aos_gcs.store.images import StoredBands
from aos_gcs.store.reader import MissionReader
from aos_gcs.wall.model import FrameFacts, Look, Order, RenderedFrame, ThermalScale, TileKind, TilePicture

MOST_FRAMES: Final = 4
"""Number of frames that one look renders: a call of the worker has a limit of time, whatever the size of the frames."""
_JPEG_OPTIONS: Final = [cv2.IMWRITE_JPEG_QUALITY, 75]
_THERMAL: Final = "thermal"
_REDUCIBLE: Final = (np.uint8, np.uint16, np.float32)
"""Types of numbers that OpenCV reduces."""
_OUTSIDE: Final = 24
"""Grey of cells that no frame covers."""


def look(folder: Path, after: int, until_utc_s: float | None, orders: Sequence[Order]) -> Look:
    """Return the newest frame of each vehicle among those after a number, and pictures of the tiles that are due.

    One call for both, since to open the record costs as much as to render a small tile. At most ``MOST_FRAMES`` frames
    are rendered, in the sequence of the orders.

    Args:
        folder: mission folder.
        after: number of the newest frame that is known.
        until_utc_s: time of exposure until which frames are looked for; None: all.
        orders: tiles that are due. What shows the newest frame of its camera already is left as it is.

    Raises:
        InputDataError: there is no record, or it is damaged.
    """
    rendered: list[RenderedFrame] = []
    with MissionReader(folder) as reader:
        newest = tuple(map(frame_facts, reader.newest_frames(after, until_utc_s)))
        found = {facts.vehicle_id: facts for facts in newest}
        for vehicle_id in dict.fromkeys(order.tile.vehicle_id for order in orders if order.tile.vehicle_id is not None):
            of_vehicle = [order for order in orders if order.tile.vehicle_id == vehicle_id]
            number, due = _due(of_vehicle, found.get(vehicle_id))
            if not due:
                continue
            if len(rendered) == MOST_FRAMES:
                return Look(newest, tuple(rendered), is_complete=False)
            rendered.append(_render_orders(reader, vehicle_id, number, due))
    return Look(newest, tuple(rendered), is_complete=True)


def _due(orders: Sequence[Order], found: FrameFacts | None) -> tuple[int, tuple[Order, ...]]:
    """Return the newest frame of a camera and the orders that it was not rendered for."""
    number = orders[0].known if found is None else found.number
    there = [order for order in orders if (order.known if found is None else order.tile.kind in found.kinds)]
    return number, tuple(order for order in there if order.former != number)


def _render_orders(reader: MissionReader, vehicle_id: int, number: int, orders: tuple[Order, ...]) -> RenderedFrame:
    try:
        pictures = _rendered(reader.frame(number), [(order.tile.kind, order.width_px) for order in orders])
    except InputDataError as error:
        return RenderedFrame(vehicle_id, number, orders, (), str(error))
    return RenderedFrame(vehicle_id, number, orders, pictures)


def render_frame(folder: Path, number: int, wanted: Sequence[tuple[TileKind, int]]) -> tuple[TilePicture, ...]:
    """Return pictures of a frame of some kinds and widths in pixels; its file is read once.

    Raises:
        InputDataError: the frame is missing or damaged, or has no such kind.
    """
    with MissionReader(folder) as reader:
        return _rendered(reader.frame(number), wanted)


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


def _rendered(entry: FrameEntry, wanted: Sequence[tuple[TileKind, int]]) -> tuple[TilePicture, ...]:
    bands = entry.bands()
    there = kinds_of(bands)
    for kind, _ in wanted:
        if kind not in there:
            raise InputDataError(f"the frame has no {kind} band; it has {', '.join(bands)}")
    kinds = list(dict.fromkeys(kind for kind, _ in wanted))
    shown = [_shown_bands(bands, kind) for kind in kinds]
    stored = dict(zip(kinds, zip(shown, entry.load_bands(shown), strict=True), strict=True))
    return tuple(_picture(*stored[kind], kind, width_px) for kind, width_px in wanted)


def _shown_bands(bands: tuple[str, ...], kind: TileKind) -> tuple[str, ...]:
    """Return the bands that a tile shows: in colour, red, green and blue or else the first one that is not thermal."""
    if kind is TileKind.THERMAL:
        return (_THERMAL,)
    if all(band in bands for band in COLOUR_BANDS):
        return COLOUR_BANDS
    return (next(band for band in bands if band != _THERMAL),)


def _picture(bands: tuple[str, ...], stored: StoredBands, kind: TileKind, width_px: int) -> TilePicture:
    values = stored.values if stored.values.dtype in _REDUCIBLE else stored.values.astype(np.float32)
    # Reduced in the numbers of the file: what is left out need not be converted.
    small = _reduced(values, width_px).reshape(-1, min(width_px, values.shape[1]), values.shape[2])
    if kind is TileKind.THERMAL:
        band = stored.as_seen(small[:, :, 0]).astype(np.float32, copy=False)
        return _thermal(band, is_celsius=stored.is_centikelvin or stored.values.dtype == np.float32)
    rgba = shade_integral(small.astype(np.float32), bands)
    return _encoded(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), None)


def _thermal(band: NDArray[np.float32], is_celsius: bool) -> TilePicture:
    """Return temperatures, shape (H, W), from black to yellow, with the values of both ends."""
    samples = band[np.isfinite(band)]
    samples = samples[:: max(1, samples.size // CONTRAST_SAMPLES)]
    low, high = map(float, np.percentile(samples, THERMAL_CONTRAST_PERCENTILES)) if samples.size else (0.0, 0.0)
    shades = np.nan_to_num((band - low) * (255.0 / max(high - low, 1e-6)), nan=0.0)
    coloured = cv2.applyColorMap(np.clip(shades, 0.0, 255.0).astype(np.uint8), cv2.COLORMAP_INFERNO)
    return _encoded(coloured, ThermalScale(low, high, is_celsius))


def _reduced(image: NDArray[Any], width_px: int) -> NDArray[Any]:
    """Return an image of a width, of the same type, or as it is where it is narrower; a single channel has no axis."""
    rows, columns = image.shape[:2]
    if columns > width_px:
        size = width_px, max(1, round(rows * width_px / columns))
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
    return image


def _encoded(bgr: NDArray[np.generic], scale: ThermalScale | None) -> TilePicture:
    whole = np.clip(bgr, 0, 255).astype(np.uint8)
    height_px, width_px = whole.shape[:2]
    return TilePicture(cv2.imencode(".jpg", whole, _JPEG_OPTIONS)[1].tobytes(), width_px, height_px, scale)
