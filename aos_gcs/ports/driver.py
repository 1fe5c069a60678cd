"""Drivers, the fleets that they find, and what they report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Protocol

from aos_gcs.ports.clock import Clock
from aos_gcs.ports.telemetry import ProvenLink
from aos_gcs.ports.vehicle import Vehicle
from aos_gcs.ports.worker import ThreadWorker, Worker


class Severity(StrEnum):
    """Urgency of a notice."""

    INFO = "info"
    WARNING = "warning"
    NEWS = "news"
    """Result of the search: to be shown before all warnings, though nothing is wrong."""
    CRITICAL = "critical"


@dataclass(frozen=True, slots=True)
class Notice:
    """A message to the operators."""

    severity: Severity
    text: str
    vehicle_id: int | None = None


@dataclass(frozen=True, slots=True)
class FormerLinks:
    """Proven addresses of the vehicles of a flight when its station ended."""

    recorded_utc_s: float
    """Seconds since the Unix epoch at which this was so."""
    links: Mapping[int, tuple[ProvenLink, ...]]
    """``VehicleState.proven`` by vehicle id."""


@dataclass(frozen=True, slots=True)
class DriverContext:
    """Services and settings that a driver gets when it is opened."""

    clock: Clock
    is_healthy: Callable[[], bool]
    """Asked before each of our heartbeats: a coordinator that has stopped must fall silent, so that the vehicles' own
    link-loss failsafe works."""
    notify: Callable[[Notice], None]
    """Returns at once; may be called for every status text."""
    log_folder: Path | None = None
    """Folder in which the driver records its raw traffic; None: nowhere."""
    system_id: int = 254
    """Our own MAVLink system id."""
    options: Mapping[str, object] = field(default_factory=dict)
    """Settings of this driver."""
    decoding: Worker = field(default_factory=ThreadWorker)
    """Decodes image files, which come from outside."""
    former: FormerLinks | None = None
    """Links of the flight that is taken up. Whoever uses the id of one of its vehicles elsewhere is ignored: it proves
    to be that vehicle by its board and the time since its boot, or counts as it when the former addresses have been
    silent for ten seconds and its board is not known to be another one."""


class Fleet(Protocol):
    """The vehicles that a driver has found."""

    def vehicles(self) -> Mapping[int, Vehicle]:
        """Return all vehicles ever heard, by id. A silent one stays, with an ageing ``heard_at_s``."""
        ...


class Driver(Protocol):
    """Entry point (group ``aos_gcs.drivers``) of a kind of link."""

    def __call__(self, links: Sequence[str], context: DriverContext) -> AbstractAsyncContextManager[Fleet]:
        """Open the links for as long as the context is entered.

        Raises:
            ConfigurationError: a link's text cannot be understood.
            LinkError: a link cannot be opened (for example, the port is taken).
        """
        ...
