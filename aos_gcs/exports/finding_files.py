"""Findings as files that other tools open: GeoJSON (RFC 7946), KML 2.2 and GPX 1.1."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final
from xml.etree import ElementTree as ET

from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.mission.model.findings import Finding

KML = "http://www.opengis.net/kml/2.2"
_GPX = "http://www.topografix.com/GPX/1/1"
_NOT_IN_XML: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold, even escaped. Comments have them where they were pasted from other programs."""


@dataclass(frozen=True, slots=True)
class PlacedFinding:
    """A finding and where on the globe it is."""

    finding: Finding
    position: GeodeticPosition
    started_utc_s: float | None = None
    """Clock time at which the mission's time was 0; None where it is not known."""

    @property
    def name(self) -> str:
        """Label on a map."""
        return f"Finding {self.finding.finding_id}"

    def clock_time(self, mission_time_s: float) -> str | None:
        """Return a mission time as clock time of ISO 8601; None where it is that of another sortie or not known."""
        if self.started_utc_s is None or self.finding.found_in or not math.isfinite(mission_time_s):
            return None
        moment = datetime.fromtimestamp(self.started_utc_s + mission_time_s, UTC)
        return moment.isoformat(timespec="seconds").replace("+00:00", "Z")

    def properties(self) -> dict[str, Any]:
        """Return what is known of it beside its place; nothing that is unknown is among it."""
        finding, ellipse = self.finding, self.finding.ellipse
        values = {
            "kind": finding.kind.value,
            "status": finding.status.value,
            "sigma_m": _rounded(finding.sigma_m, 2),
            "ellipse_semi_major_m": None if ellipse is None else _rounded(ellipse.semi_major_m, 2),
            "ellipse_semi_minor_m": None if ellipse is None else _rounded(ellipse.semi_minor_m, 2),
            "ellipse_heading_deg": None if ellipse is None else _rounded(math.degrees(ellipse.heading_rad), 1),
            "sightings": finding.sightings or None,
            "person_confidence": _rounded(finding.person_confidence, 3),
            "significance": _rounded(finding.significance, 1),
            "reasons": "; ".join(finding.reasons) or None,
            "found_at_s": _rounded(finding.found_at_s, 1),
            "seen_at_s": _rounded(finding.seen_at_s, 1),
            "found_at": self.clock_time(finding.found_at_s),
            "seen_at": self.clock_time(finding.seen_at_s),
            "comment": finding.comment or None,
            "assignee": finding.assignee or None,
            "operator": finding.operator or None,
            "same_as": finding.merged_into,
            "found_in": finding.found_in or None,
        }
        return {name: value for name, value in values.items() if value is not None}

    def description(self) -> str:
        """Return what is known of it as one line."""
        return "; ".join(f"{name.replace('_', ' ')}: {value}" for name, value in self.properties().items())


def to_geojson(findings: Sequence[PlacedFinding]) -> str:
    """Return a collection of points, longitude first; altitudes above mean sea level."""
    features = [
        {
            "type": "Feature",
            "id": placed.finding.finding_id,
            "geometry": {"type": "Point", "coordinates": _coordinates(placed.position)},
            "properties": {"name": placed.name} | placed.properties(),
        }
        for placed in findings
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=1, ensure_ascii=False) + "\n"


def to_kml(findings: Sequence[PlacedFinding]) -> str:
    """Return placemarks on the ground."""
    root = ET.Element("kml", xmlns=KML)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = "Findings"
    for placed in findings:
        document.append(placemark(placed, placed.description()))
    return xml_document(root)


def placemark(placed: PlacedFinding, description: str) -> ET.Element:
    """Return a placemark of KML on the ground, with this text in its balloon."""
    element = ET.Element("Placemark", id=f"finding-{placed.finding.finding_id}")
    ET.SubElement(element, "name").text = placed.name
    ET.SubElement(element, "description").text = description
    if (seen_at := placed.clock_time(placed.finding.seen_at_s)) is not None:
        ET.SubElement(ET.SubElement(element, "TimeStamp"), "when").text = seen_at
    point = ET.SubElement(element, "Point")
    ET.SubElement(point, "altitudeMode").text = "clampToGround"
    ET.SubElement(point, "coordinates").text = ",".join(map(str, _coordinates(placed.position)))
    return element


def to_gpx(findings: Sequence[PlacedFinding]) -> str:
    """Return waypoints."""
    root = ET.Element("gpx", xmlns=_GPX, version="1.1", creator="aos-gcs")
    for placed in findings:
        longitude_deg, latitude_deg, altitude_m = _coordinates(placed.position)
        waypoint = ET.SubElement(root, "wpt", lat=str(latitude_deg), lon=str(longitude_deg))
        ET.SubElement(waypoint, "ele").text = str(altitude_m)
        if (seen_at := placed.clock_time(placed.finding.seen_at_s)) is not None:
            ET.SubElement(waypoint, "time").text = seen_at
        ET.SubElement(waypoint, "name").text = placed.name
        ET.SubElement(waypoint, "desc").text = placed.description()
    return xml_document(root)


FORMATS: dict[str, tuple[str, Callable[[Sequence[PlacedFinding]], str]]] = {
    "geojson": ("application/geo+json", to_geojson),
    "kml": ("application/vnd.google-earth.kml+xml", to_kml),
    "gpx": ("application/gpx+xml", to_gpx),
}
"""Media type and writer by the suffix of the file."""


def _coordinates(position: GeodeticPosition) -> tuple[float, float, float]:
    return round(position.longitude_deg, 7), round(position.latitude_deg, 7), round(position.altitude_amsl_m, 1)


def _rounded(value: float | None, digits: int) -> float | None:
    return round(value, digits) if value is not None and math.isfinite(value) else None


def readable(text: str) -> str:
    """Return a text with replacements for the characters that XML cannot hold."""
    return _NOT_IN_XML.sub("\ufffd", text)


def xml_document(root: ET.Element) -> str:
    """Return an indented document; characters that XML cannot hold are replaced."""
    ET.indent(root)
    text = readable(ET.tostring(root, encoding="unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'
