"""GeoJSON files about the origin of the tests, as operators draw them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from aos_gcs.geometry.geodesy import LocalFrame
from tests.fakes.fleet import ORIGIN


def write_features(path: Path, features: Sequence[Any], **members: Any) -> str:
    """Write features, with other members of the collection, and return the path."""
    path.write_text(json.dumps({"type": "FeatureCollection", "features": list(features), **members}), "utf-8")
    return str(path)


def ring_deg(west_m: float, south_m: float, east_m: float, north_m: float) -> list[list[float]]:
    """Return the ring of a rectangle, longitude first."""
    corners = ((west_m, south_m), (east_m, south_m), (east_m, north_m), (west_m, north_m), (west_m, south_m))
    places = [LocalFrame(ORIGIN).to_geodetic((*corner, 0.0)) for corner in corners]
    return [[place.longitude_deg, place.latitude_deg] for place in places]


def polygon(*bounds_m: float, **properties: Any) -> dict[str, Any]:
    """Return the feature of a rectangle: west, south, east and north in metres."""
    geometry = {"type": "Polygon", "coordinates": [ring_deg(*bounds_m)]}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def point(east_m: float, north_m: float, **properties: Any) -> dict[str, Any]:
    """Return the feature of a point."""
    place = LocalFrame(ORIGIN).to_geodetic((east_m, north_m, 0.0))
    geometry = {"type": "Point", "coordinates": [place.longitude_deg, place.latitude_deg]}
    return {"type": "Feature", "properties": properties, "geometry": geometry}
