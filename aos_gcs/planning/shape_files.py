"""Shapes from the files of other programs: GeoJSON, KML and QGroundControl's plans.

What a shape is meant for is guessed from its place in the file or from its name; the operator decides. Files come from
anywhere: they are never trusted to be small, well formed or harmless.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Final
from xml.etree.ElementTree import Element, ParseError

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM

MAX_FILE_BYTES: Final = 4 * 1024 * 1024
MAX_SHAPES: Final = 200
MAX_POINTS: Final = 500
"""Greatest number of points of a shape."""

MAX_TEXT: Final = 120
"""Greatest number of characters of a text from a file that is shown."""

_CIRCLE_CORNERS = 32
_MAX_RADIUS_M = 100_000.0
_NO_GO = re.compile(r"no.?go|no.?fly|exclusion|keep.?out|forbidden", re.IGNORECASE)
_FENCE = re.compile(r"fence", re.IGNORECASE)
_WGS84 = re.compile(r"(CRS:?84|EPSG:(.*:)?(4326|4979))$", re.IGNORECASE)
"""Names of WGS 84 in older GeoJSON; RFC 7946 allows no other system."""
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


class ShapeRole(StrEnum):
    """Possible purpose of a shape."""

    AREA = "area"
    NO_GO = "no_go"
    FENCE = "fence"
    LAUNCH = "launch"
    RETURN = "return"


@dataclass(frozen=True, slots=True)
class Place:
    """A point on the map."""

    latitude_deg: float
    longitude_deg: float


@dataclass(frozen=True, slots=True)
class ImportedShape:
    """A polygon, or a single point."""

    role: ShapeRole
    name: str
    places: tuple[Place, ...]


def import_shapes(content: bytes) -> tuple[ImportedShape, ...]:
    """Return the polygons and points of a file; its format is seen from its content.

    Raises:
        InputDataError: the file is too large, damaged, of another format, or holds no shapes.
    """
    if len(content) > MAX_FILE_BYTES:
        raise InputDataError(f"The file is larger than {MAX_FILE_BYTES // 1024**2} MiB; leave out what is not needed.")
    content = content.removeprefix(_BYTE_ORDER_MARK)
    if content.startswith(b"PK"):
        raise InputDataError("The file is a ZIP archive (KMZ?); unpack it and import the .kml in it.")
    try:
        shapes = _bounded(_from_kml(content) if content.lstrip()[:1] == b"<" else _from_json(content))
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        raise InputDataError(
            f"The file is damaged, or no GeoJSON, KML or QGroundControl plan: {_short(error)}."
        ) from error
    if not shapes:
        raise InputDataError("The file holds neither polygons nor points.")
    return shapes


def _bounded(shapes: Iterator[ImportedShape]) -> tuple[ImportedShape, ...]:
    found: list[ImportedShape] = []
    for shape in shapes:
        if len(found) == MAX_SHAPES:
            raise InputDataError(f"The file holds more than {MAX_SHAPES} shapes; leave out what is not needed.")
        if len(shape.places) > MAX_POINTS:
            which = f"The shape '{_short(shape.name)}'" if shape.name else "A shape without a name"
            raise InputDataError(f"{which} has {len(shape.places)} points; simplify it to {MAX_POINTS} or fewer.")
        found.append(replace(shape, name=_short(shape.name)))
    return tuple(found)


def _short(text: object) -> str:
    """Return the beginning: what stands in a file may be as long as the file."""
    return str(text)[:MAX_TEXT]


def _place(latitude_deg: object, longitude_deg: object) -> Place:
    place = Place(float(str(latitude_deg)), float(str(longitude_deg)))
    if not (abs(place.latitude_deg) <= 90.0 and abs(place.longitude_deg) <= 180.0):
        where = f"{_short(latitude_deg)}, {_short(longitude_deg)}"
        raise InputDataError(f"{where} is not a latitude and longitude in degrees; export it in WGS 84 (EPSG:4326).")
    return place


def _ring(places: Sequence[Place]) -> tuple[Place, ...]:
    """Drop the repetition of the first point with which rings end in GeoJSON and KML."""
    return tuple(places[:-1] if len(places) > 1 and places[0] == places[-1] else places)


def _guessed(name: str) -> ShapeRole:
    if _NO_GO.search(name):
        return ShapeRole.NO_GO
    return ShapeRole.FENCE if _FENCE.search(name) else ShapeRole.AREA


# --- JSON -------------------------------------------------------------------------------------------------------------


def _from_json(content: bytes) -> Iterator[ImportedShape]:
    document = json.loads(content)
    if document.get("fileType") == "Plan":
        yield from _from_qgc(document)
    else:
        _check_crs(document)
        yield from _from_geojson(document, "")


def _check_crs(document: Mapping[str, Any]) -> None:
    crs = document.get("crs")
    if crs is None:
        return
    name = str(crs["properties"]["name"])
    if _WGS84.search(name) is None:
        raise InputDataError(f"The file's coordinates are in '{_short(name)}'; export it in WGS 84 (EPSG:4326).")


def _from_geojson(value: Mapping[str, Any], name: str) -> Iterator[ImportedShape]:
    kind = value["type"]
    if kind == "FeatureCollection":
        for feature in value["features"]:
            yield from _from_geojson(feature, "")
    elif kind == "Feature":
        if value["geometry"] is not None:
            yield from _from_geojson(value["geometry"], str((value.get("properties") or {}).get("name") or ""))
    elif kind == "GeometryCollection":
        for geometry in value["geometries"]:
            yield from _from_geojson(geometry, name)
    elif kind in {"Polygon", "MultiPolygon"}:
        polygons = [value["coordinates"]] if kind == "Polygon" else value["coordinates"]
        for outer, *holes in polygons:
            yield ImportedShape(_guessed(name), name, _geojson_ring(outer))
            for hole in holes:
                yield ImportedShape(ShapeRole.NO_GO, name, _geojson_ring(hole))
    elif kind == "Point":
        longitude_deg, latitude_deg, *_ = value["coordinates"]
        yield ImportedShape(ShapeRole.LAUNCH, name, (_place(latitude_deg, longitude_deg),))


def _geojson_ring(coordinates: Sequence[Sequence[float]]) -> tuple[Place, ...]:
    return _ring([_place(latitude_deg, longitude_deg) for longitude_deg, latitude_deg, *_ in coordinates])


def _from_qgc(document: Mapping[str, Any]) -> Iterator[ImportedShape]:
    mission, fence = document.get("mission", {}), document.get("geoFence", {})
    for item in mission.get("items", []):
        if item.get("type") == "ComplexItem" and item.get("polygon"):
            yield ImportedShape(ShapeRole.AREA, str(item.get("complexItemType", "")), _qgc_ring(item["polygon"]))
    for polygon in fence.get("polygons", []):
        yield ImportedShape(_qgc_role(polygon), "geofence", _qgc_ring(polygon["polygon"]))
    for circle in fence.get("circles", []):
        role, radius_m = _qgc_role(circle), float(circle["circle"]["radius"])
        if not 0.0 < radius_m <= _MAX_RADIUS_M:
            raise InputDataError(f"A circle of the file has a radius of {radius_m:g} m: give one of 100 km or less.")
        # What is kept out of a no-go circle keeps out of the polygon about it; a fence must not reach beyond its own.
        corners_m = radius_m if role is ShapeRole.FENCE else radius_m / math.cos(math.pi / _CIRCLE_CORNERS)
        yield ImportedShape(role, "geofence", _circle(_place(*circle["circle"]["center"]), corners_m))
    home = mission.get("plannedHomePosition")
    if home:
        yield ImportedShape(ShapeRole.LAUNCH, "planned home", (_place(*home[:2]),))
    for point in document.get("rallyPoints", {}).get("points", []):
        yield ImportedShape(ShapeRole.RETURN, "rally point", (_place(*point[:2]),))


def _qgc_role(shape: Mapping[str, Any]) -> ShapeRole:
    return ShapeRole.FENCE if shape.get("inclusion", True) else ShapeRole.NO_GO


def _qgc_ring(points: Sequence[Sequence[float]]) -> tuple[Place, ...]:
    return _ring([_place(latitude_deg, longitude_deg) for latitude_deg, longitude_deg, *_ in points])


def _circle(centre: Place, radius_m: float) -> tuple[Place, ...]:
    """Return the regular polygon whose corners lie on a circle."""
    frame = LocalFrame(GeodeticPosition(centre.latitude_deg, centre.longitude_deg, AmslM(0.0)))
    angles_rad = (math.tau * corner / _CIRCLE_CORNERS for corner in range(_CIRCLE_CORNERS))
    corners = [
        frame.to_geodetic(np.array([radius_m * math.cos(angle), radius_m * math.sin(angle), 0.0]))
        for angle in angles_rad
    ]
    return tuple(_place(corner.latitude_deg, corner.longitude_deg) for corner in corners)


# --- KML --------------------------------------------------------------------------------------------------------------


def _from_kml(content: bytes) -> Iterator[ImportedShape]:
    try:
        root = fromstring(content, forbid_dtd=True)
    except DefusedXmlException as error:
        text = "The file declares a document type or entities, which are refused; remove them."
        raise InputDataError(text) from error
    except ParseError as error:
        raise InputDataError(f"The file is not well-formed KML: {error}.") from error
    for placemark in root.iterfind(".//{*}Placemark"):
        name = (placemark.findtext("{*}name") or "").strip()
        for polygon in placemark.iterfind(".//{*}Polygon"):
            for outer in polygon.iterfind("{*}outerBoundaryIs"):
                yield ImportedShape(_guessed(name), name, _ring(_kml_places(outer)))
            for hole in polygon.iterfind("{*}innerBoundaryIs"):
                yield ImportedShape(ShapeRole.NO_GO, name, _ring(_kml_places(hole)))
        for point in placemark.iterfind(".//{*}Point"):
            yield ImportedShape(ShapeRole.LAUNCH, name, tuple(_kml_places(point)[:1]))


def _kml_places(element: Element) -> list[Place]:
    places = []
    for coordinates in element.iterfind(".//{*}coordinates"):
        for entry in (coordinates.text or "").split():
            longitude_deg, latitude_deg, *_ = entry.split(",")
            places.append(_place(latitude_deg, longitude_deg))
    if not places:
        raise InputDataError("A shape of the file has no coordinates.")
    return places
