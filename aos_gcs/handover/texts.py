"""Texts of a hand-over: times with their zone, places with their error, and what others have written, made harmless."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import datetime, tzinfo
from typing import Final
from xml.sax.saxutils import escape
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.geodesy import EnuPoint, LocalFrame
from aos_gcs.geometry.notations import Notation, written
from aos_gcs.mission.model.findings import KIND_NAMES, Finding, FindingStatus
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.mission.model.snapshot import MissionSnapshot

OUTCOMES: Final = {
    None: "Not closed: in flight, or interrupted",
    Outcome.OPEN: "Open",
    Outcome.FOUND: "Possible person found",
    Outcome.NOT_FOUND: "Nothing found",
    Outcome.ABORTED: "Aborted",
    Outcome.FAILED: "Failed",
}
STATUSES: Final = {
    FindingStatus.NEW: "Not decided",
    FindingStatus.CONFIRMED: "Confirmed",
    FindingStatus.REJECTED: "Rejected",
}
NOTATIONS: Final = {
    Notation.DECIMAL: "decimal degrees",
    Notation.DMS: "degrees, minutes, seconds",
    Notation.UTM: "UTM",
    Notation.MGRS: "MGRS",
}
UNKNOWN: Final = "-"
_REPLACEMENT: Final = "\N{REPLACEMENT CHARACTER}"


@dataclass(frozen=True, slots=True)
class Writer:
    """Writes times and places as a team writes them."""

    zone: tzinfo
    zone_name: str
    notation: Notation
    frame: LocalFrame | None

    def time(self, utc_s: float | None) -> str:
        """Return date, time and zone; a dash for a time that is not known."""
        return UNKNOWN if utc_s is None else f"{datetime.fromtimestamp(utc_s, self.zone):%Y-%m-%d %H:%M:%S %Z}"

    def place(self, position_enu_m: EnuPoint) -> str:
        """Return a place on the globe, or in metres from the origin where that is not known."""
        if self.frame is None:
            return f"{position_enu_m[0]:.1f} m east, {position_enu_m[1]:.1f} m north of the origin"
        position = self.frame.to_geodetic(position_enu_m)
        return written(position.latitude_deg, position.longitude_deg, self.notation)


def make_writer(time_zone: str, notation: Notation, frame: LocalFrame | None) -> Writer:
    """Return the writer of a team.

    Raises:
        ConfigurationError: the time zone is not known on this machine.
    """
    try:
        zone = ZoneInfo(time_zone)
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise ConfigurationError(
            f"time_zone: {shortened(time_zone, 60)!r} is not known here; name one as in Europe/Vienna, or UTC."
        ) from error
    return Writer(zone, time_zone, notation, frame)


def shortened(text: str, most: int) -> str:
    """Return a text on one line, cut where it is longer than that; the cut is told."""
    head = " ".join(text[: 2 * most].split())
    if len(text) <= most:
        return head
    return f"{head[:most]} … (shortened from {len(text):,} characters)"


def markup(text: str, most: int = 2000) -> str:
    """Return a text as a paragraph's markup that shows it, whatever it contains, shortened."""
    return escape("".join(one if one.isprintable() else _REPLACEMENT for one in shortened(text, most)))


def error_text(finding: Finding) -> str:
    """Return how well the place of a finding is known, as standard deviations."""
    if finding.ellipse is not None:
        ellipse = finding.ellipse
        axes = f"± {ellipse.semi_major_m:.1f} m x {ellipse.semi_minor_m:.1f} m"
        return f"{axes}, longer axis towards {math.degrees(ellipse.heading_rad):.0f}°"
    if finding.sigma_m is not None and math.isfinite(finding.sigma_m):
        return f"± {finding.sigma_m:.1f} m"
    return "not known"


def kind_text(finding: Finding) -> str:
    """Return what a finding is believed to be."""
    name = KIND_NAMES[finding.kind]
    return name if finding.person_confidence is None else f"{name} ({finding.person_confidence:.0%} a person)"


def searched_lines(final: MissionSnapshot) -> tuple[str, ...]:
    """Return what share of the area was searched, and how likely a person there was noticed where that is known."""
    seen = final.covered_fraction if final.ground is None else final.ground.seen_fraction
    if final.ground is None or final.ground.detection is None:
        return (percent(seen),)
    detection = final.ground.detection
    shares = f"standing {detection.standing:.0%}, sitting {detection.sitting:.0%}, lying {detection.lying:.0%}"
    return percent(seen), f"Mean probability of detection: {shares}"


def percent(fraction: float | None) -> str:
    """Return a share; a dash where it is not known."""
    return UNKNOWN if fraction is None or not math.isfinite(fraction) else f"{fraction:.0%}"


def duration(seconds: float) -> str:
    """Return a duration in minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"
