"""Events of Cursor on Target 2.0: the XML of one mark, of its deletion, and of a ping.

``ce`` and ``le`` are radii of 90 % as ATAK shows them (CE90, LE90): the standard deviation along the major axis of the
ellipse times 2.146, and that of the height times 1.645.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from xml.etree import ElementTree as ET

from aos_gcs.exports.finding_files import readable
from aos_gcs.geometry.heights import EllipsoidalM

CE90 = 2.146
"""Radius of the circle that holds 90 % of a circular normal distribution, in standard deviations along an axis."""
LE90 = 1.645
"""Half the interval that holds 90 % of a normal distribution, in standard deviations."""
UNKNOWN = "9999999.0"
"""Value of heights and errors that are not known."""
PING_TYPE = "t-x-c-t"
"""Type of pings."""
_MAX_TEXT = 2000
"""Longest text that is sent; longer comments end there."""
_DELETION_STALE_S = 60.0
_PING_STALE_S = 20.0


@dataclass(frozen=True, slots=True)
class Mark:
    """One object on the maps of others."""

    uid: str
    type: str
    how: str
    latitude_deg: float
    longitude_deg: float
    hae_m: EllipsoidalM | None
    """Height above the ellipsoid; None if it is not known."""
    lifetime_s: float
    """Time after which it is stale unless it is sent again."""
    detail: str
    """Element ``detail`` as XML."""
    ce_m: float | None = None
    le_m: float | None = None
    is_live: bool = False
    """Whether it is sent with every state, as vehicles are, and left to become stale when it is gone."""

    def xml(self, utc_s: float) -> bytes:
        """Return the event at this time."""
        event = _event(self.uid, self.type, self.how, utc_s, self.lifetime_s)
        _add_point(event, self.latitude_deg, self.longitude_deg, (self.hae_m, self.ce_m, self.le_m))
        event.append(ET.fromstring(self.detail))  # noqa: S314 - our own
        return ET.tostring(event)


def deletion_xml(uid: str, utc_s: float) -> bytes:
    """Return the event that deletes a mark."""
    event = _event(f"{uid}.delete", "t-x-d-d", "h-g-i-g-o", utc_s, _DELETION_STALE_S)
    _add_point(event, 0.0, 0.0)
    detail = ET.SubElement(event, "detail")
    ET.SubElement(detail, "link", uid=uid, relation="none", type="none")
    ET.SubElement(detail, "__forcedelete")
    return ET.tostring(event)


def ping_uid(name: str) -> str:
    """Return the identifier of a station's pings."""
    return f"{name}-ping"


def ping_xml(name: str, utc_s: float) -> bytes:
    """Return the event that servers answer."""
    event = _event(ping_uid(name), PING_TYPE, "m-g", utc_s, _PING_STALE_S)
    _add_point(event, 0.0, 0.0)
    ET.SubElement(event, "detail")
    return ET.tostring(event)


def clean(text: str) -> str:
    """Return a text without characters that XML cannot hold, and not longer than maps can show."""
    return readable(text[:_MAX_TEXT])


def _event(uid: str, kind: str, how: str, utc_s: float, lifetime_s: float) -> ET.Element:
    now, stale = _time(utc_s), _time(utc_s + lifetime_s)
    return ET.Element("event", version="2.0", uid=uid, type=kind, how=how, time=now, start=now, stale=stale)


def _add_point(
    event: ET.Element,
    latitude_deg: float,
    longitude_deg: float,
    hae_ce_le_m: tuple[float | None, float | None, float | None] = (None, None, None),
) -> None:
    hae, ce, le = (UNKNOWN if value is None else f"{value:.2f}" for value in hae_ce_le_m)
    ET.SubElement(event, "point", lat=f"{latitude_deg:.7f}", lon=f"{longitude_deg:.7f}", hae=hae, ce=ce, le=le)


def _time(utc_s: float) -> str:
    return datetime.fromtimestamp(utc_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
