"""Priors of GeoJSON files: polygons with a probability each, or a last known point with distance rings.

The rings are those of the statistics of lost-person behaviour (Koester, *Lost Person Behavior*, 2008): the distances
from the last known point within which 25, 50, 75 and 95 % of the persons of a category were found. Their numbers are
the user's: which ones fit depends on the person and the country.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.input_values import finite_number, shown
from aos_gcs.prior.model import FloatArray

DISTANCE_SHARES: Final = (0.25, 0.5, 0.75, 0.95)
"""Shares of persons found within the distances of a last known point."""
BEYOND: Final = 2.0
"""Multiple of the largest distance up to which the rest of the persons is spread evenly."""
MAX_BYTES: Final = 20_000_000
MAX_CORNERS: Final = 5000
_GREATEST_DISTANCE_M: Final = 1e6
_TOLERANCE: Final = 1e-6
_WGS84: Final = ("CRS84", "4326")

PlaceDeg = tuple[float, float]
"""Latitude and longitude."""


@dataclass(frozen=True, slots=True)
class WeightedPolygon:
    """A polygon with its holes, and the probability that the person is in it."""

    rings_deg: tuple[tuple[PlaceDeg, ...], ...]
    probability: float


@dataclass(frozen=True, slots=True)
class PolygonPrior:
    """Polygons, in each of which all places are as likely; where they overlap, their probabilities add."""

    polygons: tuple[WeightedPolygon, ...]

    def density_per_m2(self, frame: LocalFrame, places_enu_m: FloatArray) -> FloatArray:
        """Return the probability per square metre at places; see :class:`~aos_gcs.prior.model.Prior`."""
        density = np.zeros(len(places_enu_m))
        for polygon in self.polygons:
            rings_m = [to_enu_m(frame, ring_deg) for ring_deg in polygon.rings_deg]
            area_m2 = abs(_area_m2(rings_m[0])) - sum(abs(_area_m2(ring_m)) for ring_m in rings_m[1:])
            if area_m2 <= 0.0:
                continue
            inside = np.zeros(len(places_enu_m), dtype=np.bool_)
            for ring_m in rings_m:
                inside ^= inside_ring(places_enu_m, ring_m)
            density[inside] += polygon.probability / area_m2
        return density


@dataclass(frozen=True, slots=True)
class RingPrior:
    """A last known point, and the distances within which ``DISTANCE_SHARES`` of lost persons are found."""

    place_deg: PlaceDeg
    distances_m: tuple[float, float, float, float]

    def density_per_m2(self, frame: LocalFrame, places_enu_m: FloatArray) -> FloatArray:
        """Return the probability per square metre at places, even within each ring.

        See :class:`~aos_gcs.prior.model.Prior`.
        """
        (centre_m,) = to_enu_m(frame, (self.place_deg,))
        radii_m = np.array([0.0, *self.distances_m, BEYOND * self.distances_m[-1]])
        shares = np.diff([0.0, *DISTANCE_SHARES, 1.0])
        densities = np.append(shares / (math.pi * np.diff(radii_m**2)), 0.0)
        distance_m = np.hypot(*(places_enu_m - centre_m).T)
        return np.asarray(densities[np.searchsorted(radii_m, distance_m, side="right") - 1], dtype=np.float64)


def read_shapes(path: Path) -> PolygonPrior | RingPrior:
    """Read a prior from a GeoJSON file.

    Raises:
        InputDataError: it is none; the text names the file, the feature and the remedy.
    """
    features = read_features(path)
    if not features:
        raise InputDataError(f"{path} holds no feature: draw polygons with a probability, or a last known point.")
    kinds = {str(geometry_of(feature, path).get("type")) for feature in features}
    if kinds == {"Point"}:
        if len(features) > 1:
            raise InputDataError(f"{path} holds {len(features)} points: leave one last known point.")
        return _rings(features[0], path)
    if kinds <= {"Polygon", "MultiPolygon"}:
        return _polygons(features, path)
    raise InputDataError(
        f"{path} holds the geometries {', '.join(sorted(kinds))}: give either polygons, or one last known point."
    )


def read_features(path: Path) -> list[Mapping[str, Any]]:
    """Return the features of a GeoJSON file.

    Raises:
        InputDataError: it is none; the text names the file and the remedy.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputDataError(f"{path} is larger than {MAX_BYTES // 1_000_000} MB: simplify it.")
        document = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputDataError(f"{path} cannot be read: {error.strerror or error}.") from error
    except (ValueError, RecursionError) as error:
        raise InputDataError(f"{path} is not valid JSON: {error}.") from error
    return list(_features(document, path))


def inside_ring(places_m: FloatArray, ring_m: FloatArray) -> NDArray[np.bool_]:
    """Return which places, shape (k, 2), lie inside of a ring of corners, shape (m, 2)."""
    inside = np.zeros(len(places_m), dtype=np.bool_)
    east_m, north_m = places_m.T
    for (x_0, y_0), (x_1, y_1) in zip(ring_m.tolist(), np.roll(ring_m, -1, axis=0).tolist(), strict=True):
        if y_0 == y_1:
            continue
        crosses = (y_0 <= north_m) != (y_1 <= north_m)
        inside ^= crosses & (east_m < x_0 + (north_m - y_0) * (x_1 - x_0) / (y_1 - y_0))
    return inside


def _features(document: object, path: Path) -> Iterator[Mapping[str, Any]]:
    if not isinstance(document, dict):
        raise InputDataError(f"{path} is no GeoJSON: its text is not an object.")
    if (crs := document.get("crs")) is not None and not any(name in json.dumps(crs) for name in _WGS84):
        raise InputDataError(
            f"{path} is in the coordinate system {shown(crs)}: GeoJSON is in longitude and latitude (WGS 84); save it "
            "as EPSG:4326."
        )
    kind = document.get("type")
    if kind == "FeatureCollection" and isinstance(document.get("features"), list):
        found = document["features"]
    elif kind == "Feature":
        found = [document]
    else:
        raise InputDataError(f"{path} is no GeoJSON with features: its type is {shown(kind)}.")
    for feature in found:
        if not isinstance(feature, dict):
            raise InputDataError(f"{path} holds {shown(feature)} among its features.")
        yield feature


def geometry_of(feature: Mapping[str, Any], path: Path) -> Mapping[str, Any]:
    """Return the geometry of a feature.

    Raises:
        InputDataError: it has none.
    """
    geometry = feature.get("geometry")
    if not isinstance(geometry, dict):
        raise InputDataError(f"{path} holds a feature without a geometry: remove it.")
    return geometry


def properties_of(feature: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the properties of a feature; none where it has none."""
    properties = feature.get("properties")
    return properties if isinstance(properties, dict) else {}


# --- last known point -------------------------------------------------------------------------------------------------


def _rings(feature: Mapping[str, Any], path: Path) -> RingPrior:
    properties = properties_of(feature)
    stated = properties.get("distances_m")
    shares = ", ".join(f"{share:.0%}" for share in DISTANCE_SHARES)
    if not isinstance(stated, list) or len(stated) != len(DISTANCE_SHARES):
        raise InputDataError(
            f"{path}: the last known point needs the property distances_m, the four distances in metres within which "
            f"{shares} of lost persons of the category are found, but it is {shown(stated)}."
        )
    distances_m = [finite_number(value) for value in stated]
    known = [value for value in distances_m if value is not None and 0.0 < value <= _GREATEST_DISTANCE_M]
    if len(known) < len(DISTANCE_SHARES) or known != sorted(set(known)):
        raise InputDataError(
            f"{path}: distances_m must be four ascending numbers of metres above 0 ({shares}), but is {shown(stated)}."
        )
    place_deg = _place(geometry_of(feature, path).get("coordinates"), path)
    return RingPrior(place_deg, (known[0], known[1], known[2], known[3]))


# --- polygons ---------------------------------------------------------------------------------------------------------


def _polygons(features: Sequence[Mapping[str, Any]], path: Path) -> PolygonPrior:
    fields = [next((name for name in ("probability", "weight") if name in properties_of(one)), "") for one in features]
    if "" in fields:
        raise InputDataError(
            f"{path}: feature {fields.index('') + 1} has neither probability (0 to 1) nor weight among its properties: "
            "state one of them for each polygon."
        )
    if len(set(fields)) > 1:
        raise InputDataError(f"{path} states probability for some polygons and weight for others: use one of them.")
    field = fields[0]
    values = [_value(properties_of(feature)[field], f"{path}: {field} of feature {number}", field) for number, feature
              in enumerate(features, 1)]  # fmt: skip
    total = sum(values)
    if total <= 0.0:
        raise InputDataError(f"{path}: every {field} is 0: state where the person is likely to be.")
    if field == "probability" and total > 1.0 + _TOLERANCE:
        raise InputDataError(
            f"{path}: the probabilities of the polygons add up to {total:g}, 1 at most: state them as shares of 1, or "
            "as weight."
        )
    scale = total if field == "weight" else max(1.0, total)
    polygons = tuple(
        polygon
        for value, feature in zip(values, features, strict=True)
        for polygon in _parts(geometry_of(feature, path), value / scale, path)
    )
    if sum(len(ring) for polygon in polygons for ring in polygon.rings_deg) > MAX_CORNERS:
        raise InputDataError(f"{path}: the polygons have more than {MAX_CORNERS} corners: simplify them.")
    return PolygonPrior(polygons)


def _value(value: object, name: str, field: str) -> float:
    number = finite_number(value)
    if number is None:
        raise InputDataError(f"{name} must be a finite number, but is {shown(value)}.")
    if number < 0.0:
        raise InputDataError(f"{name} must not be negative, but is {number:g}: state 0 where the person cannot be.")
    if field == "probability" and number > 1.0:
        raise InputDataError(f"{name} must be 0 to 1, but is {number:g}: state a share of 1, or weight instead.")
    return number


def _parts(geometry: Mapping[str, Any], probability: float, path: Path) -> Iterator[WeightedPolygon]:
    """Yield the polygons of a geometry; several share its probability by their areas."""
    coordinates = geometry.get("coordinates")
    listed = [coordinates] if geometry.get("type") == "Polygon" else coordinates
    if not isinstance(listed, list) or not listed:
        raise InputDataError(f"{path} holds a polygon without coordinates: remove it.")
    parts = [tuple(ring_of(ring, path) for ring in part) if isinstance(part, list) else () for part in listed]
    if not all(parts):
        raise InputDataError(f"{path} holds a polygon without coordinates: remove it.")
    areas = [_degree_area(rings) for rings in parts]
    if any(area <= 0.0 for area in areas):
        raise InputDataError(f"{path} holds a polygon without an area: remove it, or draw it again.")
    for rings, area in zip(parts, areas, strict=True):
        yield WeightedPolygon(rings, probability * area / sum(areas))


def ring_of(ring: object, path: Path) -> tuple[PlaceDeg, ...]:
    """Return the corners of a ring of coordinates, each once.

    Raises:
        InputDataError: it is none; the text names the file.
    """
    if not isinstance(ring, list):
        raise InputDataError(f"{path} holds a ring that is no list of places: {shown(ring)}.")
    places = tuple(_place(place, path) for place in ring)
    places = places[:-1] if len(places) > 1 and places[0] == places[-1] else places
    if len(places) < 3:
        raise InputDataError(f"{path} holds a ring of {len(places)} corners: a polygon has 3 or more.")
    return places


def _place(place: object, path: Path) -> PlaceDeg:
    numbers = [finite_number(value) for value in place[:2]] if isinstance(place, list) else []
    if len(numbers) < 2 or numbers[0] is None or numbers[1] is None:
        raise InputDataError(f"{path} holds a place that is no pair of numbers: {shown(place)}.")
    longitude_deg, latitude_deg = numbers[0], numbers[1]
    if abs(latitude_deg) > 90.0 or abs(longitude_deg) > 180.0:
        raise InputDataError(
            f"{path} holds the place {shown(place)}, which is no longitude and latitude: save it as EPSG:4326."
        )
    return latitude_deg, longitude_deg


def _degree_area(rings: Sequence[Sequence[PlaceDeg]]) -> float:
    outer, *holes = (abs(_area_m2(np.array(ring))) for ring in rings)
    return outer - sum(holes)


def _area_m2(ring: FloatArray) -> float:
    x, y = ring.T - ring[0][:, np.newaxis]
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0


def to_enu_m(frame: LocalFrame, places_deg: Sequence[PlaceDeg]) -> FloatArray:
    """Return places in a local frame, horizontal, shape (k, 2)."""
    altitude_m = frame.origin.altitude_amsl_m
    return np.array([frame.to_enu(GeodeticPosition(*place_deg, altitude_m))[:2] for place_deg in places_deg])
