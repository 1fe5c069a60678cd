"""Log lines in a thread of their own: a terminal that stands still must not stop a flight."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

_MAX_WAITING = 10_000
"""Number of lines that may wait for the terminal; further ones are lost and counted."""
_FAREWELL_S = 2.0
"""Time limit for writing what still waits when the program ends."""


class BackgroundHandler(logging.Handler):
    """Hands records to other handlers in its own thread; never waits for them.

    Args:
        handlers: handlers that may block.
    """

    def __init__(self, handlers: Sequence[logging.Handler]) -> None:
        super().__init__()
        self._handlers = handlers
        self._waiting: queue.Queue[logging.LogRecord | None] = queue.Queue(_MAX_WAITING)
        self._lost = 0
        self._thread = threading.Thread(target=self._write, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        """Queue a record."""
        record.msg, record.args = record.getMessage(), None  # what it was about may change
        try:
            self._waiting.put_nowait(record)
        except queue.Full:
            self._lost += 1

    def close(self) -> None:
        """Write what waits, for a short time only."""
        with suppress(queue.Full):
            self._waiting.put(None, timeout=_FAREWELL_S)
        self._thread.join(_FAREWELL_S)
        super().close()

    def _write(self) -> None:
        while (record := self._waiting.get()) is not None:
            lost, self._lost = self._lost, 0
            if lost:
                record.msg = f"{record.msg} ({lost} lines before this one were lost: the terminal did not take them)"
            for handler in self._handlers:
                if record.levelno >= handler.level:
                    handler.handle(record)


@contextmanager
def background_log() -> Iterator[None]:
    """Write the root logger's lines in a thread for as long as the context is entered."""
    root = logging.getLogger()
    handlers = root.handlers[:]
    background = BackgroundHandler(handlers)
    root.handlers[:] = [background]
    try:
        yield
    finally:
        root.handlers[:] = handlers
        background.close()
