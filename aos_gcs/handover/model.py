"""Content of a hand-over, and how it is to be printed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from aos_gcs.geometry.geodesy import EnuPoint, LocalFrame
from aos_gcs.geometry.notations import Notation
from aos_gcs.mission.model.findings import Finding
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.steps import PictureKind


class Paper(StrEnum):
    """Size of the paper."""

    A4 = "a4"
    LETTER = "letter"


@dataclass(frozen=True, slots=True)
class HandoverOptions:
    """Paper, notation and time zone of a hand-over."""

    paper: Paper = Paper.A4
    notation: Notation = Notation.DECIMAL
    time_zone: str = "UTC"
    """Name of the time zone of all times, as in the tz database: ``Europe/Vienna``."""


class HandoverControl(Protocol):
    """Hand-overs for the API; one is made after the other, apart from the flight."""

    async def handover(self, options: HandoverOptions) -> bytes:
        """Return the hand-over of the mission so far as a PDF.

        Raises:
            ConfigurationError: the time zone is not known, or the library for PDF is not installed.
            InputDataError: the record is damaged, or holds no state of the mission yet.
            ViewerBusyError: another one is being made, or making it takes too long.
        """
        ...

    async def flight_log(self) -> str:
        """Return the flights of all vehicles so far as CSV.

        Raises:
            InputDataError, ViewerBusyError: as for :meth:`handover`.
        """
        ...


@dataclass(frozen=True, slots=True)
class LoggedFlight:
    """One flight of one vehicle, from take-off to landing."""

    vehicle_id: int
    takeoff_utc_s: float
    landing_utc_s: float | None
    """None where the record ends before the vehicle has landed."""
    duration_s: float
    """Time in the air, as far as it is recorded."""
    distance_m: float
    """Length of the way through the recorded positions, which are one second apart."""
    max_height_m: float
    """Greatest height above the mission's origin."""
    battery_takeoff: float | None
    """Fraction of the battery's charge; None where it was not reported."""
    battery_landing: float | None

    @property
    def battery_used(self) -> float | None:
        """Fraction of the battery's charge that the flight has used; None where it was not reported."""
        if self.battery_takeoff is None or self.battery_landing is None:
            return None
        return self.battery_takeoff - self.battery_landing


@dataclass(frozen=True, slots=True)
class LogEntry:
    """An entry of the log of events and communications."""

    utc_s: float
    severity: str
    source: str
    """Vehicle that it concerns; empty for the mission as a whole."""
    text: str


@dataclass(frozen=True, slots=True)
class Raster:
    """A raster of the mission on the ground, north up."""

    kind: PictureKind
    png: bytes = field(repr=False)
    west_m: float
    south_m: float
    east_m: float
    north_m: float


@dataclass(frozen=True, slots=True)
class FindingPicture:
    """A picture of a finding's surroundings, north up."""

    caption: str
    width_m: float
    jpeg: bytes = field(repr=False)


@dataclass(frozen=True, slots=True)
class ReportedFinding:
    """A finding with the times that are not part of it."""

    finding: Finding
    found_utc_s: float | None
    """None for a finding of an earlier sortie or of a survey."""
    seen_utc_s: float | None
    decided_utc_s: float | None
    """Time since which its status and its operator are what they are.

    None while nobody has decided, and for a decision of an earlier sortie.
    """
    pictures: tuple[FindingPicture, ...] = ()
    pictures_missing: str = ""
    """Why it has no pictures; empty where it has."""


@dataclass(frozen=True, slots=True)
class Handover:
    """Everything that is handed over of a sortie or a survey."""

    operation: str
    """Name of the operation: of its first sortie's folder."""
    sortie: int
    version: str
    """Version of the program that has recorded it."""
    start_utc_s: float
    """Time of the first record."""
    end_utc_s: float
    """Time of the last record."""
    outcome: Outcome | None
    """None while the mission goes on, and when its program was killed."""
    final: MissionSnapshot
    findings: tuple[ReportedFinding, ...]
    """Findings that count, the confirmed ones first, the rejected ones last."""
    merged: tuple[Finding, ...]
    """Findings that have turned out to be an earlier one."""
    flights: tuple[LoggedFlight, ...]
    tracks_enu_m: Mapping[int, tuple[tuple[EnuPoint, ...], ...]]
    """Ways flown by each vehicle, one per flight."""
    frames: Mapping[int, int]
    """Number of frames by vehicle."""
    operators: tuple[str, ...]
    """Names of those who have commanded or decided something, in the order of the record."""
    log: tuple[LogEntry, ...]
    audit: str
    """Result of the verification of the audit chain, with its digest."""
    searched: Raster | None
    """What was searched: by probability of detection, else by independent views, else by frames; None: not known."""

    @property
    def frame(self) -> LocalFrame | None:
        """Frame of the mission; None while its origin is not known."""
        return None if self.final.origin is None else LocalFrame(self.final.origin)

    @property
    def is_survey(self) -> bool:
        """Whether frames of a recorded flight were examined, without vehicles."""
        return not self.final.vehicles
