"""Segments of a search: named polygons whose probability of detection is followed one by one, from a GeoJSON file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.input_values import require_file, shown
from aos_gcs.prior.shapes import PlaceDeg, geometry_of, properties_of, read_features, ring_of, to_enu_m

MAX_SEGMENTS: Final = 50
MAX_CORNERS: Final = 500
MAX_NAME: Final = 60
SUFFIXES: Final = (".geojson", ".json")

Polygon = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Segment:
    """A part of the ground that is searched and reported by itself."""

    name: str
    area_enu_m: Polygon


def read_segments(name: str) -> tuple[tuple[str, tuple[PlaceDeg, ...]], ...]:
    """Return the names and the outlines of the segments of a file.

    Args:
        name: path of a GeoJSON file of polygons, each with ``name`` or ``title`` among its properties.

    Raises:
        InputDataError: it cannot be used; the text names the file, the feature and the remedy.
    """
    path = Path(name)
    if not name.isprintable() or path.suffix.lower() not in SUFFIXES:
        raise InputDataError(f"The segments {name!a} must be a GeoJSON file (.geojson).")
    require_file(path, f"The file of segments {name}")
    status = path.stat()
    return _read(name, (status.st_mtime_ns, status.st_size))


def segments_about(name: str, origin: GeodeticPosition) -> tuple[Segment, ...]:
    """Return the segments of a file in the local frame of an origin; raises what :func:`read_segments` does."""
    frame = LocalFrame(origin)
    return tuple(
        Segment(label, tuple((float(east_m), float(north_m)) for east_m, north_m in to_enu_m(frame, ring_deg)))
        for label, ring_deg in read_segments(name)
    )


@lru_cache(maxsize=2)
def _read(name: str, _file_version: tuple[int, int]) -> tuple[tuple[str, tuple[PlaceDeg, ...]], ...]:
    path = Path(name)
    features = read_features(path)
    if not 1 <= len(features) <= MAX_SEGMENTS:
        raise InputDataError(f"{path} holds {len(features)} features: name 1 to {MAX_SEGMENTS} segments.")
    found = tuple((_name(feature, number, path), _outline(feature, path)) for number, feature in enumerate(features, 1))
    names = [label for label, _ in found]
    for label in names:
        if names.count(label) > 1:
            raise InputDataError(f"{path}: two segments are named {label!r}: name them differently.")
    return found


def _name(feature: Mapping[str, Any], number: int, path: Path) -> str:
    properties = properties_of(feature)
    stated = properties.get("name") or properties.get("title")
    label = str(stated).strip() if isinstance(stated, str | int) and not isinstance(stated, bool) else ""
    if not label or len(label) > MAX_NAME or not label.isprintable():
        raise InputDataError(
            f"{path}: feature {number} needs a name of 1 to {MAX_NAME} characters (property name or title), but has "
            f"{shown(stated)}."
        )
    return label


def _outline(feature: Mapping[str, Any], path: Path) -> tuple[PlaceDeg, ...]:
    geometry = geometry_of(feature, path)
    rings = geometry.get("coordinates")
    if geometry.get("type") != "Polygon" or not isinstance(rings, list) or not rings:
        raise InputDataError(f"{path} holds a {shown(geometry.get('type'))}: a segment is one polygon.")
    if len(rings) > 1:
        raise InputDataError(f"{path} holds a polygon with holes: draw segments without holes.")
    ring_deg = ring_of(rings[0], path)
    if len(ring_deg) > MAX_CORNERS:
        raise InputDataError(f"{path} holds a segment of {len(ring_deg)} corners, {MAX_CORNERS} at most: simplify it.")
    return ring_deg
