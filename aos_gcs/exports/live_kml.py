"""A mission in flight as KML that Google Earth and CalTopo ask for again and again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final
from xml.etree import ElementTree as ET

from aos_gcs.exports.finding_files import KML, PlacedFinding, placemark, xml_document
from aos_gcs.geometry.geodesy import EnuPoint, GeodeticPosition, LocalFrame
from aos_gcs.mission.model.findings import FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.mission.model.vehicles import Task

REFRESH_S: Final = 10
"""Interval in which programs ask again."""


def network_link(address: str, name: str) -> str:
    """Return the file that people open once: it names the address of the live document.

    Args:
        address: URL of the live document.
        name: label in the program's list.
    """
    root = ET.Element("kml", xmlns=KML)
    link = ET.SubElement(root, "NetworkLink")
    ET.SubElement(link, "name").text = name
    place = ET.SubElement(link, "Link")
    ET.SubElement(place, "href").text = address
    ET.SubElement(place, "refreshMode").text = "onInterval"
    ET.SubElement(place, "refreshInterval").text = str(REFRESH_S)
    return xml_document(root)


def live_kml(snapshot: MissionSnapshot, origin: GeodeticPosition) -> str:
    """Return vehicles with known positions, search area, legs flown, and findings that count.

    Args:
        snapshot: state of the mission.
        origin: origin of its frame.
    """
    root = ET.Element("kml", xmlns=KML)
    document = ET.SubElement(root, "Document")
    ET.SubElement(document, "name").text = f"Mission {snapshot.mission_id}"
    frame = LocalFrame(origin)
    for name, elements in (
        ("Findings", _findings(snapshot, frame)),
        ("Vehicles", _vehicles(snapshot, frame)),
        ("Search", _search(snapshot, frame)),
    ):
        folder = ET.SubElement(document, "Folder")
        ET.SubElement(folder, "name").text = name
        folder.extend(elements)
    return xml_document(root)


def _findings(snapshot: MissionSnapshot, frame: LocalFrame) -> Iterator[ET.Element]:
    for finding in snapshot.findings:
        if finding.status is not FindingStatus.REJECTED and finding.merged_into is None:
            placed = PlacedFinding(finding, frame.to_geodetic(finding.position_enu_m), snapshot.started_utc_s)
            yield placemark(placed, placed.description())


def _vehicles(snapshot: MissionSnapshot, frame: LocalFrame) -> Iterator[ET.Element]:
    for vehicle in snapshot.vehicles:
        if vehicle.position_enu_m is None:
            continue
        element = ET.Element("Placemark", id=f"vehicle-{vehicle.telemetry.vehicle_id}")
        ET.SubElement(element, "name").text = f"Vehicle {vehicle.telemetry.vehicle_id}"
        state = "link lost" if vehicle.task is Task.LOST else vehicle.task.value
        ET.SubElement(element, "description").text = state
        point = ET.SubElement(element, "Point")
        ET.SubElement(point, "altitudeMode").text = "absolute"
        ET.SubElement(point, "coordinates").text = _coordinates(frame, [vehicle.position_enu_m])
        yield element


def _search(snapshot: MissionSnapshot, frame: LocalFrame) -> Iterator[ET.Element]:
    if snapshot.area_enu_m:
        element = ET.Element("Placemark", id="area")
        ET.SubElement(element, "name").text = "Search area"
        corners = [(east_m, north_m, 0.0) for east_m, north_m in (*snapshot.area_enu_m, snapshot.area_enu_m[0])]
        # An outline: a filled polygon would hide the map.
        _add_line(element, frame, corners)
        yield element
    for number, leg in enumerate(snapshot.legs_enu_m[: snapshot.leg], start=1):
        element = ET.Element("Placemark", id=f"leg-{number}")
        ET.SubElement(element, "name").text = f"Leg {number}, flown"
        _add_line(element, frame, [(east_m, north_m, 0.0) for east_m, north_m in leg])
        yield element


def _add_line(element: ET.Element, frame: LocalFrame, points_enu_m: Sequence[EnuPoint]) -> None:
    line = ET.SubElement(element, "LineString")
    ET.SubElement(line, "tessellate").text = "1"
    ET.SubElement(line, "coordinates").text = _coordinates(frame, points_enu_m)


def _coordinates(frame: LocalFrame, points_enu_m: Sequence[EnuPoint]) -> str:
    places = map(frame.to_geodetic, points_enu_m)
    return " ".join(f"{one.longitude_deg:.7f},{one.latitude_deg:.7f},{one.altitude_amsl_m:.1f}" for one in places)
