"""Frames of a recorded video as image files, with their poses in a JSON file beside them."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.poses import Pose
from aos_gcs.input_values import require_file
from aos_gcs.surveys.images import MAX_PIXELS
from aos_gcs.surveys.poses_writing import poses_document
from aos_gcs.surveys.video.subtitles import CueTelemetry, read_subtitle_file, samples_of
from aos_gcs.surveys.video.track import FlightTrack

POSES_NAME = "poses.json"

_NEUTRAL, _COLOURLESS = 128.0, 3.0
"""Chroma of grey in 8 bits, and by how much that of a thermal video's pictures differs from it."""

_JPEG_QUALITY = 95

_TIME_TOLERANCE_S = 0.0005
"""Times of frames are rounded to the ticks of their video."""


@dataclass(frozen=True, slots=True)
class Selection:
    """Choice of frames."""

    spacing_m: float = 1.0
    """Distance between two frames, unless their time is given."""
    every_s: float | None = None
    """Time between two frames."""
    from_s: float = 0.0
    to_s: float = math.inf


@dataclass(frozen=True, slots=True)
class Extraction:
    """Result of an extraction."""

    names: tuple[str, ...]
    """Names of the images that were written."""
    without_telemetry: int
    """Number of frames of the video that no sample lies near."""
    other_zoom: int
    """Number of frames left out because the camera had zoomed."""
    is_cut_off: bool
    """Whether the video ended with an error after some frames."""


def read_telemetry(video: Path, subtitles: Path | None = None) -> list[CueTelemetry]:
    """Read the telemetry of a video: of a subtitle file, else of one with its name beside it, else of its own track.

    Raises:
        InputDataError: if there is none, or it cannot be read.
        ConfigurationError: if PyAV is not installed.
    """
    require_file(video, f"The video {video}")
    if subtitles is None:
        beside = (video.with_suffix(suffix) for suffix in (".SRT", ".srt", ".Srt"))
        subtitles = next((path for path in beside if path.is_file()), None)
    if subtitles is not None:
        return read_subtitle_file(subtitles)
    av = _av()
    with _opened(video) as container:
        if not container.streams.subtitles:
            raise InputDataError(
                f"The video {video} has neither a subtitle file beside it ({video.with_suffix('.SRT').name}) nor a "
                "subtitle track: its frames have no positions. Switch subtitles on in the aircraft's app."
            )
        try:
            return samples_of(_embedded(container), f"the subtitle track of {video}")
        except av.FFmpegError as error:
            raise InputDataError(f"The subtitle track of {video} cannot be read: {error.strerror}.") from error


def extract(
    video: Path,
    track: FlightTrack,
    folder: Path,
    selection: Selection,
    on_time: Callable[[float], None] | None = None,
) -> Extraction:
    """Write frames of a video, and their poses, into a new folder, which is there when all of it is written.

    Thermal videos give PNG files of one band, others JPEG files.

    Args:
        video: video file.
        track: poses over its time.
        folder: folder that does not exist yet, or is empty.
        selection: choice of frames.
        on_time: called with the time of every frame that is decoded.

    Raises:
        InputDataError: if the video cannot be read, or no frame of it can be used.
        ConfigurationError: if the folder cannot be written, or PyAV is not installed.
    """
    try:
        is_free = not folder.exists() or (folder.is_dir() and not any(folder.iterdir()))
        if not is_free or folder.resolve() == Path.cwd():
            raise ConfigurationError(f"{folder} exists already: name a new folder for the frames.")
        with tempfile.TemporaryDirectory(dir=folder.absolute().parent, prefix=f".{folder.name}.") as temporary:
            unfinished = Path(temporary) / folder.name
            unfinished.mkdir()
            result = _extract(video, track, unfinished, selection, on_time)
            # It replaces an empty folder, which stays where nothing could be extracted.
            unfinished.rename(folder)
    except OSError as error:
        raise ConfigurationError(f"Cannot write {folder}: {error.strerror or error}.") from error
    return result


def _extract(
    video: Path, track: FlightTrack, folder: Path, selection: Selection, on_time: Callable[[float], None] | None
) -> Extraction:
    av = _av()
    entries: list[tuple[str, Pose, float]] = []
    frames = _Frames(selection, track)
    is_grey: bool | None = None
    is_cut_off = False
    with _opened(video) as container:
        try:
            for time_s, picture in _pictures(container, video, selection):
                if on_time is not None:
                    on_time(time_s)
                if not frames.takes(time_s):
                    continue
                is_grey = _is_colourless(picture) if is_grey is None else is_grey
                name = f"{video.stem}_{round(time_s * 1000):08d}.{'png' if is_grey else 'jpg'}"
                _write(folder / name, _image(picture, is_grey=is_grey))
                entries.append((name, track.pose(time_s), time_s))
        except av.FFmpegError as error:
            is_cut_off = True
            if not entries:
                raise InputDataError(f"The video {video} cannot be decoded: {error.strerror}.") from error
    if not entries:
        raise InputDataError(
            f"No frame of {video} can be used: {frames.without_telemetry} have no telemetry near their time, and the "
            "chosen part has no others."
        )
    document = json.dumps(poses_document(entries, track.origin), indent=1)
    (folder / POSES_NAME).write_text(document + "\n", encoding="utf-8")
    return Extraction(tuple(name for name, _, _ in entries), frames.without_telemetry, frames.other_zoom, is_cut_off)


class _Frames:
    """Choice among the frames of a video, one after the other."""

    def __init__(self, selection: Selection, track: FlightTrack) -> None:
        self._selection = selection
        self._track = track
        self._last: tuple[float, NDArray[np.float64]] | None = None
        self._zoom: float | None = None
        self.without_telemetry = 0
        self.other_zoom = 0

    def takes(self, time_s: float) -> bool:
        """Return whether a frame is taken; it then is the one that the next must differ from."""
        if not self._track.is_known(time_s):
            self.without_telemetry += 1
            return False
        zoom = self._track.zoom(time_s)
        self._zoom = zoom if self._zoom is None else self._zoom
        if zoom != self._zoom:
            self.other_zoom += 1
            return False
        position_m = self._track.position_m(time_s)
        if self._last is not None and not self._is_apart(time_s, position_m, *self._last):
            return False
        self._last = time_s, position_m
        return True

    def _is_apart(
        self, time_s: float, position_m: NDArray[np.float64], last_s: float, last_m: NDArray[np.float64]
    ) -> bool:
        if self._selection.every_s is not None:
            return time_s - last_s >= self._selection.every_s - _TIME_TOLERANCE_S
        return bool(np.linalg.norm(position_m - last_m) >= self._selection.spacing_m)


def _av() -> Any:
    return load_extra("av", "video", "Reading a video")


def _opened(video: Path) -> Any:
    """Open a video.

    Raises:
        InputDataError: if it is none.
    """
    av = _av()
    try:
        # FFmpeg would follow playlists to other files and addresses.
        return av.open(
            str(video), options={"protocol_whitelist": "file", "format_whitelist": "mov,mp4,m4a,3gp,matroska"}
        )
    except (av.FFmpegError, OSError) as error:
        reason = error.strerror or error
        raise InputDataError(f"The file {video} is not a readable MP4, MOV or MKV video: {reason}.") from error


def _pictures(container: Any, video: Path, selection: Selection) -> Iterator[tuple[float, Any]]:
    """Yield the times and the pictures of the chosen part of a video."""
    if not container.streams.video:
        raise InputDataError(f"The file {video} has no pictures.")
    stream = container.streams.video[0]
    stream.thread_type = "AUTO"
    if stream.codec_context.width * stream.codec_context.height > MAX_PIXELS:
        raise InputDataError(f"The pictures of {video} have more than {MAX_PIXELS / 1e6:.0f} megapixels.")
    for picture in container.decode(stream):
        if picture.time is None or picture.time < selection.from_s:
            continue
        if picture.time > selection.to_s:
            return
        yield float(picture.time), picture


def _embedded(container: Any) -> Iterator[tuple[float, str]]:
    """Yield the cues of the first subtitle track, whose packets hold their length in two bytes, and then the text."""
    stream = container.streams.subtitles[0]
    for packet in container.demux(stream):
        if packet.pts is not None and packet.size > 2:
            text = bytes(packet)
            text = text[2:] if stream.codec_context.name == "mov_text" else text
            yield float(packet.pts * packet.time_base), text.decode("utf-8", errors="replace")


def _is_colourless(picture: Any) -> bool:
    """Return whether a picture is grey in three equal bands, as thermal cameras write them."""
    yuv = picture.to_ndarray(format="yuv444p").astype(np.float32)
    return bool(np.abs(yuv[1:] - _NEUTRAL).max() <= _COLOURLESS)


def _image(picture: Any, *, is_grey: bool) -> NDArray[np.uint8]:
    return np.asarray(picture.to_ndarray(format="gray" if is_grey else "bgr24"), dtype=np.uint8)


def _write(path: Path, image: NDArray[np.uint8]) -> None:
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY] if path.suffix == ".jpg" else []
    _, data = cv2.imencode(path.suffix, image, options)
    path.write_bytes(data.tobytes())
