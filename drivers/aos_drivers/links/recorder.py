"""Raw traffic on disk as .tlog, readable by every MAVLink log viewer."""

from __future__ import annotations

import asyncio
import struct
import threading
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack
from pathlib import Path

from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import DriverContext, Notice, Severity

TLOG_NAME = "mavlink.tlog"
_TIMESTAMP = struct.Struct(">Q")
_BUFFER_BYTES = 8 * 1024 * 1024
_FLUSH_PERIOD_S = 0.2


class TlogRecorder:
    """Writes packets from a thread of its own, so that a slow disk never blocks the links.

    Buffered: up to 8 MiB. Buffer full policy: the newest packet is not recorded and counted in ``dropped``.
    A write error ends the recording; ``on_error`` hears of it once, in the writer's thread.
    """

    def __init__(self, path: Path, on_error: Callable[[OSError], None]) -> None:
        """Open ``path`` for appending and start the writer.

        Raises:
            OSError: it cannot be opened.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("ab")
        self._on_error = on_error
        self._lock = threading.Lock()
        self._buffer = bytearray()
        self._stop = threading.Event()
        self._has_failed = False
        self._thread = threading.Thread(target=self._run, name="tlog-writer", daemon=True)
        self.dropped = 0
        self._thread.start()

    def close(self) -> None:
        """Write out what is buffered and close; waits for the disk."""
        self._stop.set()
        self._thread.join()

    def write(self, packet: bytes | bytearray, utc_s: float) -> None:
        """Record one packet that was sent or received at ``utc_s``."""
        self.write_all([packet], utc_s)

    def write_all(self, packets: Sequence[bytes | bytearray], utc_s: float) -> None:
        """Record valid packets, sent or received together at ``utc_s``."""
        stamp = _TIMESTAMP.pack(int(utc_s * 1e6))
        with self._lock:
            for packet in packets:
                if self._has_failed or len(self._buffer) + len(stamp) + len(packet) > _BUFFER_BYTES:
                    self.dropped += 1
                else:
                    self._buffer += stamp + packet

    def _run(self) -> None:
        try:
            with self._file:
                while not self._stop.wait(_FLUSH_PERIOD_S):
                    self._write_buffer()
                self._write_buffer()
        except OSError as error:
            self._has_failed = True
            self._on_error(error)

    def _write_buffer(self) -> None:
        with self._lock:
            data, self._buffer = self._buffer, bytearray()
        if data:
            self._file.write(data)
            self._file.flush()


async def open_recorder(stack: AsyncExitStack, context: DriverContext) -> TlogRecorder | None:
    """Return the recorder of a driver's traffic, closed with ``stack``; None without a log folder.

    Raises:
        ConfigurationError: its file cannot be written.
    """
    if context.log_folder is None:
        return None
    loop = asyncio.get_running_loop()

    def on_error(error: OSError) -> None:
        text = f"the MAVLink traffic is no longer recorded: {error}"
        loop.call_soon_threadsafe(context.notify, Notice(Severity.CRITICAL, text))

    path = context.log_folder / TLOG_NAME
    try:
        recorder = await asyncio.to_thread(TlogRecorder, path, on_error)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be written: {error.strerror}; choose another log folder") from error
    stack.push_async_callback(asyncio.to_thread, recorder.close)
    return recorder
