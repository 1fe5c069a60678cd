"""Marks and drawings of others, as proposals: points, circles, drawn areas and lines, and routes.

Only what people have set is proposed (``how`` begins with ``h``): positions that devices report of themselves, and what
other stations tell of their vehicles, are none. Of the XML nothing is believed: numbers are finite and on the globe,
texts short and without control characters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final
from xml.etree.ElementTree import Element

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL, AmslM, EllipsoidalM, amsl_m
from aos_gcs.input_values import printable, shown
from aos_gcs.mission.model.proposals import (
    MAX_NAME,
    MAX_PROPOSAL_POINTS,
    MAX_REMARKS,
    MAX_UID,
    Proposal,
    ProposalShape,
)
from aos_gcs.sharing.heights import UndulationM
from aos_gcs.sharing.tak.incoming import time_of

SOURCE: Final = "TAK"
_DELETION: Final = "t-x-d-d"
_MARKS: Final = ("b-m-p-", "a-")
_SENSOR_POINTS: Final = "b-m-p-s-p-"
"""Places that sensors look at: they move all the time."""
_DRAWINGS: Final = ("u-d-", "b-m-r")
_ROUTE: Final = "b-m-r"
_CIRCLE_CORNERS: Final = 32
_MAX_RADIUS_M: Final = 50_000.0
_UNKNOWN_HAE_M: Final = 9_999_999.0
_LOWEST_M, _HIGHEST_M = -1_000.0, 20_000.0
"""Range of heights that are believed."""


@dataclass(frozen=True, slots=True)
class Withdrawal:
    """Names of marks that their sender has deleted."""

    uids: tuple[str, ...]


def read_mark(event: Element, undulation_m: UndulationM | None, utc_s: float) -> Proposal | Withdrawal | None:
    """Return what an event proposes or takes back; None if it is neither.

    Args:
        event: an event that was parsed.
        undulation_m: height of the geoid, by which heights above the ellipsoid become altitudes; None: not known.
        utc_s: present time of this machine.

    Raises:
        InputDataError: it would be a proposal, but says what cannot be; the text begins with its label.
    """
    kind = event.get("type", "")
    if kind == _DELETION:
        uids = (link.get("uid", "") for link in event.iterfind("detail/link"))
        return Withdrawal(tuple(uid for uid in uids if 0 < len(uid) <= MAX_UID)[:MAX_PROPOSAL_POINTS])
    if not _is_proposal(event, kind):
        return None
    name = _name(event)
    try:
        return _proposal(event, kind, name, undulation_m, utc_s)
    except InputDataError as error:
        raise InputDataError(f"{name}: {str(error).removesuffix('.')}") from error


def _is_proposal(event: Element, kind: str) -> bool:
    """Return whether a person has set this mark or drawn this shape; positions of participants are neither."""
    if not kind.startswith(_MARKS + _DRAWINGS) or kind.startswith(_SENSOR_POINTS):
        return False
    if not event.get("how", "").startswith("h"):
        return False
    contact = event.find("detail/contact")
    is_participant = event.find("detail/takv") is not None or (contact is not None and contact.get("endpoint"))
    return not is_participant


def _proposal(event: Element, kind: str, name: str, undulation_m: UndulationM | None, utc_s: float) -> Proposal:
    uid = event.get("uid", "")
    if not 0 < len(uid) <= MAX_UID:
        raise InputDataError(f"a uid of {len(uid)} characters")
    sent_utc_s, stale_utc_s = time_of(event, "time"), time_of(event, "stale")
    if stale_utc_s <= utc_s:
        raise InputDataError("it was out of date when it came; compare the sender's clock with this machine's")
    centre = event.find("point")
    place = _place(centre.get("lat"), centre.get("lon")) if centre is not None else None
    if kind.startswith(_DRAWINGS):
        shape, points = _drawing(event, kind, place)
        altitude_m = None
    elif place is None or place == (0.0, 0.0):
        raise InputDataError("it has no place")
    else:
        shape, points = ProposalShape.POINT, (place,)
        altitude_m = _altitude_m(centre, place, undulation_m)
    proposal = Proposal(
        uid=uid,
        source=SOURCE,
        name=name,
        sender=_sender(event),
        kind=_text(kind, MAX_NAME),
        shape=shape,
        points_deg=points,
        altitude_amsl_m=altitude_m,
        remarks=_text(event.findtext("detail/remarks") or "", MAX_REMARKS),
        sent_utc_s=sent_utc_s,
        stale_utc_s=stale_utc_s,
        received_utc_s=utc_s,
    )
    proposal.require_bounds()
    return proposal


def _drawing(
    event: Element, kind: str, centre: tuple[float, float] | None
) -> tuple[ProposalShape, tuple[tuple[float, float], ...]]:
    """Return the form and the points of a drawing: a circle or an ellipse, or what its corners say."""
    ellipse = event.find("detail/shape/ellipse")
    if ellipse is not None:
        if centre is None:
            raise InputDataError("a circle without a centre")
        return ProposalShape.AREA, _ellipse(ellipse, centre)
    corners = list(_corners(event))
    is_closed = len(corners) > 3 and corners[0] == corners[-1]
    polyline = event.find("detail/shape/polyline")
    closes = is_closed or kind.startswith("u-d-r") or (polyline is not None and polyline.get("closed") == "true")
    if closes and kind != _ROUTE:
        return ProposalShape.AREA, tuple(corners[:-1] if is_closed else corners)
    return ProposalShape.LINE, tuple(corners)


def _corners(event: Element) -> Iterator[tuple[float, float]]:
    """Yield the corners of a drawing, in either of the forms that programs write; too many are refused."""
    links = (link.get("point", "").split(",") for link in event.iterfind("detail/link") if link.get("point"))
    pairs: list[tuple[str | None, str | None]] = [(one[0], one[1] if len(one) > 1 else None) for one in links]
    pairs = pairs or [(one.get("lat"), one.get("lon")) for one in event.iterfind("detail/shape/polyline/vertex")]
    if len(pairs) > MAX_PROPOSAL_POINTS + 1:
        raise InputDataError(f"it has {len(pairs)} points; {MAX_PROPOSAL_POINTS} at most are possible")
    for latitude, longitude in pairs:
        yield _place(latitude, longitude)


def _ellipse(ellipse: Element, centre: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """Return the polygon about an ellipse, so that what is kept out of it is kept out of the ellipse as well."""
    major_m, minor_m = (_number(ellipse.get(axis), axis) for axis in ("major", "minor"))
    if not (0.0 < major_m <= _MAX_RADIUS_M and 0.0 < minor_m <= _MAX_RADIUS_M):
        raise InputDataError(f"a circle of {major_m:g} by {minor_m:g} m")
    heading_rad = math.radians(_number(ellipse.get("angle", "0"), "angle"))
    outer = 1.0 / math.cos(math.pi / _CIRCLE_CORNERS)
    frame = LocalFrame(GeodeticPosition(*centre, SEA_LEVEL))

    def corner(angle_rad: float) -> tuple[float, float]:
        along_m, across_m = outer * major_m * math.cos(angle_rad), outer * minor_m * math.sin(angle_rad)
        east_m = along_m * math.sin(heading_rad) + across_m * math.cos(heading_rad)
        north_m = along_m * math.cos(heading_rad) - across_m * math.sin(heading_rad)
        place = frame.to_geodetic((east_m, north_m, 0.0))
        return round(place.latitude_deg, 7), round(place.longitude_deg, 7)

    return tuple(corner(math.tau * index / _CIRCLE_CORNERS) for index in range(_CIRCLE_CORNERS))


def _altitude_m(point: Element | None, place: tuple[float, float], undulation_m: UndulationM | None) -> AmslM | None:
    """Return the altitude above mean sea level of a point, whose height is above the ellipsoid; None if not known."""
    undulation = None if undulation_m is None else undulation_m(*place)
    if point is None or undulation is None or not point.get("hae"):
        return None
    hae_m = EllipsoidalM(_number(point.get("hae"), "hae"))
    return amsl_m(hae_m, undulation) if hae_m != _UNKNOWN_HAE_M and _LOWEST_M <= hae_m <= _HIGHEST_M else None


def _place(latitude: str | None, longitude: str | None) -> tuple[float, float]:
    latitude_deg, longitude_deg = _number(latitude, "latitude"), _number(longitude, "longitude")
    if not (abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0):
        raise InputDataError(f"{latitude_deg:g}, {longitude_deg:g} is no latitude and longitude")
    return latitude_deg, longitude_deg


def _number(text: str | None, name: str) -> float:
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputDataError(f"{name} {shown(text)} is no number")
    return number


def _name(event: Element) -> str:
    contact = event.find("detail/contact")
    callsign = "" if contact is None else contact.get("callsign", "")
    return _text(callsign or event.get("uid", ""), MAX_NAME) or "a mark without a name"


def _sender(event: Element) -> str:
    """Return the call sign of who has made a mark, as ATAK and its servers write it."""
    creator = event.find("detail/creator")
    if creator is not None and creator.get("callsign"):
        return _text(creator.get("callsign", ""), MAX_NAME)
    for link in event.iterfind("detail/link"):
        if link.get("parent_callsign"):
            return _text(link.get("parent_callsign", ""), MAX_NAME)
    return ""


def _text(text: str, most: int) -> str:
    """Return a text on one line, without control characters, cut to a length."""
    return printable(" ".join(text[: 4 * most].split()))[:most]
