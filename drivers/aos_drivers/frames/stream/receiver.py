"""Receiving the video of one vehicle with PyAV (FFmpeg), in a thread of its own.

FFmpeg blocks, and decoding takes time: neither may happen on the event loop. What is kept is bounded to the latest few
decoded frames, of which only those that are wanted are turned into images.
"""

from __future__ import annotations

import asyncio
import struct
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_drivers.frames.settings import CameraSettings
from aos_drivers.frames.stream.clock import FrameTime, StreamClock
from aos_gcs.equal_bands import COLOURS, GREY, without_equal_bands
from aos_gcs.errors import CaptureError
from aos_gcs.extras import load_extra
from aos_gcs.ports import Clock

KEPT_FRAMES = 8
_TIMEOUT_S = 5.0
"""Time limit for opening the stream, and between two packets."""
_ANALYSIS_S = 1.0
"""Time limit for detecting the contents of a stream that does not declare them."""
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 0.5, 8.0
_PROTOCOLS = {
    "rtsp": "rtsp,rtp,udp,tcp",
    "rtsps": "rtsps,rtsp,rtp,udp,tcp,tls",
    "rtp": "rtp,udp",
    "udp": "udp",
    "tcp": "tcp",
    "sdp": "file,rtp,udp",
}
"""Protocols that FFmpeg may use for each kind of address, so that no stream leads it to files or other services."""
_FORMATS = "rtsp,rtp,sdp,mpegts"
"""Formats that FFmpeg may read; no playlists, which name other addresses."""
_CODED_COLOUR = 3
"""Difference of two channels, in grey levels, that coding may add to a picture without colours: Motion JPEG adds 2."""


@dataclass(frozen=True, slots=True, eq=False)
class StreamFrame:
    """One decoded frame."""

    number: int
    """Counts the frames since the driver was opened."""
    time: FrameTime
    picture: Any
    """``av.VideoFrame``."""

    def image(self) -> tuple[NDArray[np.uint8], tuple[str, ...]]:
        """Return the image, shape (H, W, C), and its bands. Takes milliseconds: call it in a thread.

        A picture without colours, as thermal cameras send them, is grey whatever its pixel format.
        """
        if self.picture.format.name.startswith("gray"):
            return self.picture.to_ndarray(format="gray")[..., np.newaxis], GREY
        pixels = without_equal_bands(self.picture.to_ndarray(format="rgb24"), _CODED_COLOUR)
        return pixels, GREY if pixels.shape[2] == 1 else COLOURS


class VideoReceiver:
    """Receives a stream for as long as ``run`` does, and connects again whenever it ends.

    Buffered: the latest eight frames, older ones go.
    """

    def __init__(
        self,
        address: Callable[[], str],
        clock: Clock,
        settings: CameraSettings,
        max_pixels: int,
        on_frame: Callable[[], None],
    ) -> None:
        """Call ``address`` before each connection (it may raise CaptureError), and ``on_frame`` for each frame."""
        self._address = address
        self._clock = clock
        self._settings = settings
        self._max_pixels = max_pixels
        self._on_frame = on_frame
        self._av: Any = load_extra("av", "video", "Receiving video")
        self._lock = threading.Lock()
        self._frames: deque[StreamFrame] = deque(maxlen=KEPT_FRAMES)
        self._received = 0
        self._stop = threading.Event()
        self.problem = "the stream has not been opened yet"
        """Reason why no frames arrive; empty while they do."""

    async def run(self) -> None:
        """Receive until cancelled."""
        loop = asyncio.get_running_loop()
        thread = threading.Thread(target=self._work, args=(loop,), name="video", daemon=True)
        thread.start()
        try:
            await loop.create_future()
        finally:
            self._stop.set()
            await asyncio.to_thread(thread.join)

    def first_since(self, at_s: float) -> StreamFrame | None:
        """Return the first frame that is kept and was exposed at ``at_s`` or later."""
        with self._lock:
            return next((frame for frame in self._frames if frame.time.at_s >= at_s), None)

    def _work(self, loop: asyncio.AbstractEventLoop) -> None:
        pause_s = _FIRST_PAUSE_S
        while not self._stop.is_set():
            before = self._received
            try:
                self._receive(loop)
                self.problem = "the stream has ended"
            except Exception as error:  # whatever it is: a thread that ends would say nothing, and nothing would come
                self.problem = f"the stream fails: {error}"
            pause_s = _FIRST_PAUSE_S if self._received > before else min(2 * pause_s, _LONGEST_PAUSE_S)
            self._stop.wait(pause_s)

    def _receive(self, loop: asyncio.AbstractEventLoop) -> None:
        """Receive one connection's frames, until it ends or fails."""
        address = self._address()
        kind = "sdp" if address.endswith(".sdp") else address.partition("://")[0]
        options = {
            "protocol_whitelist": _PROTOCOLS[kind],
            "format_whitelist": _FORMATS,
            "fflags": "nobuffer",
            "analyzeduration": str(round(_ANALYSIS_S * 1e6)),
        }
        # Names of cameras are in any encoding.
        timeout_s = (_TIMEOUT_S, _TIMEOUT_S)
        with self._av.open(address, options=options, timeout=timeout_s, metadata_errors="replace") as container:
            if not container.streams.video:
                raise CaptureError(f"{address} has no video")
            stream = container.streams.video[0]
            self._check_size(stream.codec_context.width, stream.codec_context.height)
            stream.codec_context.options = {"max_pixels": str(self._max_pixels)}
            times = StreamClock(self._settings.latency_s, self._settings.latency_sigma_s)
            sender_minus_media_s: float | None = None
            for packet in container.demux(stream):
                if self._stop.is_set():
                    return
                arrival_s = self._clock.now_s()
                sender_minus_media_s = self._sender_offset_s(packet, sender_minus_media_s)
                for picture in self._decode(packet):
                    self._take(picture, times, arrival_s, sender_minus_media_s)
                    loop.call_soon_threadsafe(self._on_frame)

    def _decode(self, packet: Any) -> list[Any]:
        """Return the complete images of a packet; there is none before the first key frame, or after a loss."""
        try:
            return [picture for picture in packet.decode() if not picture.is_corrupt]
        except self._av.error.InvalidDataError:
            return []

    def _sender_offset_s(self, packet: Any, before_s: float | None) -> float | None:
        """Return our time minus the stream's, from the latest time of day that the sender reported."""
        if packet.pts is None or not packet.has_sidedata("prft"):
            return before_s
        (utc_us,) = struct.unpack_from("=q", bytes(packet.get_sidedata("prft")))
        utc_minus_ours_s = self._clock.utc_s() - self._clock.now_s()
        return float(utc_us / 1e6 - utc_minus_ours_s - packet.pts * packet.time_base)

    def _take(self, picture: Any, times: StreamClock, arrival_s: float, sender_minus_media_s: float | None) -> None:
        if picture.pts is None:
            return
        self._check_size(picture.width, picture.height)
        media_s = float(picture.pts * picture.time_base)
        sender_s = None if sender_minus_media_s is None else media_s + sender_minus_media_s
        with self._lock:
            self._frames.append(StreamFrame(self._received, times.time_of(media_s, arrival_s, sender_s), picture))
            self._received += 1
        self.problem = ""

    def _check_size(self, width: int, height: int) -> None:
        if width * height > self._max_pixels:
            raise CaptureError(
                f"its pictures have {width} x {height} pixels; the limit is {self._max_pixels / 1e6:g} megapixels "
                "(max_image_megapixels)"
            )
