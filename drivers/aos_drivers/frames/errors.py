"""Reasons for not using a frame, and the counts of frames by these reasons (``aos_gcs.ports.CameraState``)."""

from __future__ import annotations

from aos_gcs.errors import CaptureError
from aos_gcs.ports import CameraState


class FrameRefusedError(CaptureError):
    """A frame whose pose or time cannot be trusted: too old, implausible, or ambiguous."""


class TornFrameError(CaptureError):
    """An incomplete image file, which may be complete later."""


class LateFrameError(CaptureError):
    """A frame that did not arrive by the deadline."""


class PendingImageError(CaptureError):
    """An image that is not available yet."""


class FrameCounts:
    """Frame counts of one vehicle since the driver was opened."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._frames = 0
        self._missed = {"refused": 0, "late": 0, "torn": 0, "failed": 0}
        self._problem = ""
        self._is_told = False
        """Whether a missing frame was notified of since the last one that was used."""

    def count_used(self) -> bool:
        """Count a frame that was used; return whether to notify: the problem that was told is over."""
        self._frames += 1
        is_over, self._is_told, self._problem = self._is_told, False, ""
        return is_over

    def count_missed(self, error: CaptureError) -> bool:
        """Count a missed frame; return whether to notify: for the first, second, fourth … of its kind."""
        kind = _kind(error)
        self._missed[kind] += 1
        self._problem = str(error)
        count = self._missed[kind]
        is_told = count & (count - 1) == 0
        self._is_told = self._is_told or is_told
        return is_told

    def state(self) -> CameraState:
        """Return the snapshot that crosses the port."""
        return CameraState(source=self._source, frames=self._frames, problem=self._problem, **self._missed)


def _kind(error: CaptureError) -> str:
    match error:
        case FrameRefusedError():
            return "refused"
        case LateFrameError():
            return "late"
        case TornFrameError():
            return "torn"
    return "failed"
