"""Reasons for not using a frame; frames are counted by these classes (``aos_gcs.ports.CameraState``)."""

from __future__ import annotations

from aos_gcs.errors import CaptureError


class FrameRefusedError(CaptureError):
    """A frame whose pose or time cannot be trusted: too old, implausible, or ambiguous."""


class TornFrameError(CaptureError):
    """An incomplete image file, which may be complete later."""


class LateFrameError(CaptureError):
    """A frame that did not arrive by the deadline."""


class PendingImageError(CaptureError):
    """An image that is not available yet."""
