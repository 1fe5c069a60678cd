"""Objects on a map of CalTopo: findings are markers; area, legs flown and tracks of the vehicles are shapes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.mission.model.findings import Finding, FindingStatus
from aos_gcs.mission.model.snapshot import MissionSnapshot
from aos_gcs.sharing.wording import finding_remarks, finding_title, finding_uid, is_shown

_TAG: Final = re.compile(r"\[aos-gcs ([^\]]{1,200})\]")
_MAX_TEXT: Final = 2000
_RED, _ORANGE, _YELLOW, _GREEN, _BLUE = "FF0000", "FF8C00", "FFD700", "00A000", "0060FF"
_TRACK_SPACING_M: Final = 5.0
MAX_TRACK_POINTS: Final = 400
"""Most points of a vehicle's track: a longer one is thinned out."""
Points = Sequence[tuple[float, float]]


@dataclass(frozen=True, slots=True)
class MapObject:
    """One object on the map."""

    uid: str
    """Our name of it, which its description carries."""
    kind: str
    """``Marker`` or ``Shape``."""
    payload: Mapping[str, Any]


def uid_of(feature: Mapping[str, Any]) -> str | None:
    """Return our name of an object that the service lists; None for those of others."""
    properties = feature.get("properties")
    description = properties.get("description") if isinstance(properties, Mapping) else None
    found = _TAG.search(description) if isinstance(description, str) else None
    return None if found is None else found.group(1)


class VehicleTracks:
    """Tracks of the vehicles, a point every few metres; bounded, since long ones are thinned out."""

    def __init__(self) -> None:
        self._points: dict[int, list[tuple[float, float]]] = {}
        self._spacing_m: dict[int, float] = {}

    def note(self, vehicle_id: int, east_m: float, north_m: float) -> None:
        """Note a position."""
        points = self._points.setdefault(vehicle_id, [])
        spacing_m = self._spacing_m.setdefault(vehicle_id, _TRACK_SPACING_M)
        if points and math.dist(points[-1], (east_m, north_m)) < spacing_m:
            return
        points.append((east_m, north_m))
        if len(points) > MAX_TRACK_POINTS:
            del points[1:-1:2]
            self._spacing_m[vehicle_id] = 2.0 * spacing_m

    def lines(self) -> Iterator[tuple[int, Points]]:
        """Yield the tracks that have a length."""
        return ((vehicle_id, points) for vehicle_id, points in self._points.items() if len(points) > 1)


def objects(snapshot: MissionSnapshot, tracks: VehicleTracks, name: str) -> dict[str, MapObject]:
    """Return what is to be on the map, by our names; nothing before the mission's origin is known.

    Args:
        snapshot: state of the mission.
        tracks: tracks of the vehicles.
        name: name of this station.
    """
    if snapshot.origin is None:
        return {}
    drawing = _Drawing(snapshot, LocalFrame(snapshot.origin), name)
    made = [*drawing.markers(), *drawing.areas(), *drawing.tracks(tracks)]
    return {one.uid: one for one in made}


@dataclass(frozen=True, slots=True)
class _Drawing:
    snapshot: MissionSnapshot
    frame: LocalFrame
    name: str

    def markers(self) -> Iterator[MapObject]:
        for finding in filter(is_shown, self.snapshot.findings):
            position = self.frame.to_geodetic(finding.position_enu_m)
            uid = f"{self.name}.{finding_uid(finding, self.snapshot.mission_id)}"
            point = [round(position.longitude_deg, 7), round(position.latitude_deg, 7)]
            style = {"marker-symbol": "point", "marker-size": "1", "marker-color": _colour(finding)}
            remarks = finding_remarks(finding, position, self.snapshot)
            geometry = {"type": "Point", "coordinates": point}
            yield _object(uid, "Marker", (finding_title(finding), remarks), geometry, style)

    def areas(self) -> Iterator[MapObject]:
        snapshot = self.snapshot
        prefix = f"{self.name}.{snapshot.mission_id}"
        if snapshot.area_enu_m:
            ring = self._line([*snapshot.area_enu_m, snapshot.area_enu_m[0]])
            outline = {"type": "Polygon", "coordinates": [ring]}
            style = _stroke(_ORANGE) | {"fill": f"#{_ORANGE}", "fill-opacity": 0.05}
            yield _object(f"{prefix}.area", "Shape", (f"{self.name} search area", ""), outline, style)
        for number, leg in enumerate(snapshot.legs_enu_m[: snapshot.leg], start=1):
            geometry = {"type": "LineString", "coordinates": self._line(leg)}
            title = f"{self.name} leg {number}, flown"
            yield _object(f"{prefix}.leg.{number}", "Shape", (title, ""), geometry, _stroke(_GREEN))

    def tracks(self, tracks: VehicleTracks) -> Iterator[MapObject]:
        for vehicle_id, points in tracks.lines():
            geometry = {"type": "LineString", "coordinates": self._line(points)}
            uid = f"{self.name}.{self.snapshot.mission_id}.track.{vehicle_id}"
            yield _object(uid, "Shape", (f"{self.name} {vehicle_id} track", ""), geometry, _stroke(_BLUE))

    def _line(self, points: Points) -> list[list[float]]:
        places = (self.frame.to_geodetic((east_m, north_m, 0.0)) for east_m, north_m in points)
        return [[round(place.longitude_deg, 7), round(place.latitude_deg, 7)] for place in places]


def _object(
    uid: str, kind: str, texts: tuple[str, str], geometry: Mapping[str, Any], style: Mapping[str, Any]
) -> MapObject:
    title, remarks = texts
    description = f"{remarks[:_MAX_TEXT]}\n[aos-gcs {uid}]".strip()
    properties = {"class": kind, "title": title, "description": description, **style}
    return MapObject(uid, kind, {"type": "Feature", "geometry": geometry, "properties": properties})


def _stroke(colour: str) -> dict[str, Any]:
    return {"stroke": f"#{colour}", "stroke-width": 2, "stroke-opacity": 1}


def _colour(finding: Finding) -> str:
    if finding.status is FindingStatus.CONFIRMED:
        return _RED
    return _ORANGE if finding.is_claimed else _YELLOW
