"""Why a frame is not used; the classes are what is counted (``aos_gcs.ports.CameraState``)."""

from __future__ import annotations

from aos_gcs.errors import CaptureError


class FrameRefusedError(CaptureError):
    """A frame whose pose or time cannot be trusted: too old, absurd, or not to be told apart from another."""


class TornFrameError(CaptureError):
    """An image file that is not whole; a later look may find it so."""


class LateFrameError(CaptureError):
    """A frame that was not there by the deadline."""


class PendingImageError(CaptureError):
    """An image that is not there yet; a later look may find it."""
