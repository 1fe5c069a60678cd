"""Errors that a user can act on.

Every error that leaves the core derives from :class:`AosError`; its text is a whole sentence that names what is wrong
and what to do. The CLI prints it and exits with 2, the API answers with a 4xx: the mapping is done there, once.
"""

from collections.abc import Mapping


class AosError(Exception):
    """Root of all errors with a message for the user."""


class ConfigurationError(AosError):
    """A setting, option or file given by the user cannot be used; the text names the field and the remedy."""


class ParameterError(ConfigurationError):
    """One of a strategy's parameters cannot be used.

    Args:
        text: why, and what it must be.
        parameter: its name.
    """

    def __init__(self, text: str, parameter: str = "") -> None:
        super().__init__(text)
        self.parameter = parameter


class InputDataError(AosError):
    """Recorded data (images, poses, mission folders) is unreadable or inconsistent; the text names the file."""


class ImagingError(AosError):
    """Frames that cannot be integrated, such as a focal plane that lies above the cameras."""


class UnusableFramesError(ImagingError):
    """None of a step's frames can be used.

    Args:
        text: description of what has happened.
        reasons: by vehicle.
    """

    def __init__(self, text: str, reasons: Mapping[int, str] | None = None) -> None:
        super().__init__(text)
        self.reasons = dict(reasons or {})


class WorkerError(AosError):
    """A computation gave no result: its process has died, run out of memory or taken too long. It is started anew."""


class LinkError(AosError):
    """A connection cannot be opened or has been lost."""


class CommandError(AosError):
    """A vehicle did not carry out a command; base of the reasons below."""


class CommandRefusedError(CommandError):
    """The autopilot answered with a refusal; the text carries its own words where it gave any."""


class CommandTimeoutError(CommandError):
    """No acknowledgement, or no telemetry that shows the effect, before the deadline."""


class CaptureError(AosError):
    """A camera delivered no usable frame before the deadline."""


class NoIntervalError(CaptureError):
    """A camera does not take images by itself, or no longer; single ones can be requested from it.

    Args:
        text: why.
        may_pass: whether it may do so again after a while; else it is left alone.
    """

    def __init__(self, text: str, *, may_pass: bool = False) -> None:
        super().__init__(text)
        self.may_pass = may_pass


class MissionError(AosError):
    """An operator's request that the mission's present state does not allow."""


class RecordingError(AosError):
    """The mission folder cannot be written, for example because the disk is full; the mission itself goes on."""


class MissionFailedError(AosError):
    """A mission cannot go on; on the ground it ends, in the air all vehicles return."""
