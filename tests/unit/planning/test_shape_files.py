"""Shapes from files of other programs, and files that mean harm."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aos_gcs.errors import InputDataError
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import AmslM
from aos_gcs.planning.shape_files import MAX_POINTS, MAX_SHAPES, MAX_TEXT, Place, ShapeRole, import_shapes

RING = [[14.0, 48.0], [14.1, 48.0], [14.1, 48.1], [14.0, 48.0]]
HOLE = [[14.05, 48.01], [14.06, 48.01], [14.06, 48.02], [14.05, 48.01]]
UTM = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}
PLACES = (Place(48.0, 14.0), Place(48.0, 14.1), Place(48.1, 14.1))

KML = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document>
  <Placemark><name>No-fly over the farm</name><Polygon><outerBoundaryIs><LinearRing><coordinates>
    14.0,48.0,0 14.1,48.0,0 14.1,48.1,0 14.0,48.0,0
  </coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>
  <Placemark><name>Car park</name><Point><coordinates>14.02,48.03</coordinates></Point></Placemark>
</Document></kml>"""

QGC = {
    "fileType": "Plan",
    "mission": {
        "plannedHomePosition": [48.03, 14.02, 262.0],
        "items": [
            {"type": "SimpleItem", "command": 22},
            {"type": "ComplexItem", "complexItemType": "survey", "polygon": [[48.0, 14.0], [48.0, 14.1], [48.1, 14.1]]},
        ],
    },
    "geoFence": {
        "polygons": [{"inclusion": True, "polygon": [[48.0, 14.0], [48.0, 14.1], [48.1, 14.1]]}],
        "circles": [{"inclusion": False, "circle": {"center": [48.05, 14.05], "radius": 50.0}}],
    },
    "rallyPoints": {"points": [[48.0, 14.01, 50.0]]},
}


def as_bytes(document: Any) -> bytes:
    return json.dumps(document).encode()


def circular(radius_m: float, *, inclusion: bool = True) -> dict[str, Any]:
    circle = {"inclusion": inclusion, "circle": {"center": [48.05, 14.05], "radius": radius_m}}
    return {"fileType": "Plan", "geoFence": {"circles": [circle]}}


def feature(properties: dict[str, str] | None, geometry: dict[str, Any] | None) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def test_geojson_with_holes_and_names() -> None:
    document = {
        "type": "FeatureCollection",
        "features": [
            feature({"name": "wood"}, {"type": "Polygon", "coordinates": [RING, HOLE]}),
            feature(None, {"type": "Point", "coordinates": [14.0, 48.0, 300.0]}),
            feature({"name": "Geofence"}, {"type": "MultiPolygon", "coordinates": [[RING]]}),
            feature({}, None),
        ],
    }
    shapes = import_shapes(as_bytes(document))
    assert [shape.role for shape in shapes] == [ShapeRole.AREA, ShapeRole.NO_GO, ShapeRole.LAUNCH, ShapeRole.FENCE]
    assert shapes[0].places == PLACES
    assert shapes[0].name == "wood"


def test_kml_placemarks() -> None:
    zone, car_park = import_shapes(KML.encode())
    assert (zone.role, zone.places) == (ShapeRole.NO_GO, PLACES)
    assert (car_park.role, car_park.name, car_park.places) == (ShapeRole.LAUNCH, "Car park", (Place(48.03, 14.02),))


def test_qgroundcontrol_plans() -> None:
    shapes = import_shapes(as_bytes(QGC))
    roles = [shape.role for shape in shapes]
    assert roles == [ShapeRole.AREA, ShapeRole.FENCE, ShapeRole.NO_GO, ShapeRole.LAUNCH, ShapeRole.RETURN]
    assert shapes[0].places == PLACES


@pytest.mark.parametrize(("inclusion", "corners_m"), [(True, 1000.0), (False, 1000.0 / math.cos(math.pi / 32))])
def test_a_circular_fence_is_no_larger_and_a_no_go_circle_no_smaller_than_drawn(
    *, inclusion: bool, corners_m: float
) -> None:
    """Imported fences reached up to 4.8 m beyond a circle of 1 km."""
    (shape,) = import_shapes(as_bytes(circular(1000.0, inclusion=inclusion)))
    frame = LocalFrame(GeodeticPosition(48.05, 14.05, AmslM(0.0)))
    places = [GeodeticPosition(place.latitude_deg, place.longitude_deg, AmslM(0.0)) for place in shape.places]
    radii_m = [float(np.linalg.norm(frame.to_enu(place)[:2])) for place in places]
    assert radii_m == pytest.approx([corners_m] * 32, rel=1e-5)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (
            as_bytes({"geoFence": {"circles": [{"circle": {"center": [48, 14], "radius": -1}}]}, "fileType": "Plan"}),
            "radius of -1 m",
        ),
        (
            as_bytes({"geoFence": {"circles": [{"circle": {"center": [48, 14], "radius": 1e9}}]}, "fileType": "Plan"}),
            "radius of 1e",
        ),
        (b"", "damaged"),
        (b"[]", "damaged"),
        (b"{}", "damaged"),
        (b"null", "damaged"),
        (b"PK\x03\x04", "ZIP"),
        (b"<kml><Placemark>", "well-formed"),
        (b"<html></html>", "neither polygons nor points"),
        (b'{"type": "FeatureCollection", "features": []}', "neither polygons nor points"),
        (b'{"type": "Polygon", "coordinates": [[[1e9, 48], [14, 48], [14, 49]]]}', "not a latitude"),
        (b'{"type": "Point", "coordinates": [NaN, NaN]}', "not a latitude"),
        (b'{"type": "Polygon", "coordinates": 7}', "damaged"),
        (b'{"type":"GeometryCollection","geometries":' * 50_000, "damaged"),
        (b"[" * 1_000_000, "damaged"),
        (as_bytes({"type": "Point", "coordinates": [450e3, 5.34e6]}), "WGS 84"),
        (as_bytes({"type": "Point", "coordinates": [14, 48], "crs": UTM}), "32633.*WGS 84"),
        (KML.replace("14.1,48.0,0", "east").encode(), "damaged"),
    ],
)
def test_broken_files_are_refused_with_the_reason(content: bytes, words: str) -> None:
    with pytest.raises(InputDataError, match=words):
        import_shapes(content)


def test_texts_from_a_file_are_shortened() -> None:
    content = "9" * 100_000
    with pytest.raises(InputDataError) as refused:
        import_shapes(KML.replace("14.1", f"east{content}").encode())
    assert len(str(refused.value)) < 400
    (shape, _) = import_shapes(KML.replace("the farm", content).encode())
    assert len(shape.name) == MAX_TEXT


@pytest.mark.parametrize("crs", ["urn:ogc:def:crs:OGC:1.3:CRS84", "urn:ogc:def:crs:EPSG::4326", "EPSG:4326"])
def test_geojson_may_name_the_only_system_that_it_has(crs: str) -> None:
    named = {"type": "name", "properties": {"name": crs}}
    (shape,) = import_shapes(as_bytes({"type": "Point", "coordinates": [14.0, 48.0], "crs": named}))
    assert shape.places == (Place(48.0, 14.0),)


def test_a_byte_order_mark_does_no_harm() -> None:
    assert len(import_shapes(b"\xef\xbb\xbf" + KML.encode())) == 2


@pytest.mark.parametrize(
    "declaration",
    [
        '<!DOCTYPE kml [<!ENTITY a "boom">]>',
        '<!DOCTYPE kml [<!ENTITY file SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE kml SYSTEM "http://127.0.0.1/evil.dtd">',
    ],
)
def test_entities_and_document_types_are_refused(declaration: str) -> None:
    with pytest.raises(InputDataError, match="document type or entities"):
        import_shapes(KML.replace("<kml", f"{declaration}<kml", 1).encode())


def test_too_many_shapes_and_points_are_refused() -> None:
    many = {"type": "MultiPolygon", "coordinates": [[RING]] * (MAX_SHAPES + 1)}
    with pytest.raises(InputDataError, match="more than 200 shapes"):
        import_shapes(as_bytes(many))
    long = {"type": "Polygon", "coordinates": [[[14.0 + 1e-6 * i, 48.0] for i in range(MAX_POINTS + 1)]]}
    with pytest.raises(InputDataError, match="simplify"):
        import_shapes(as_bytes(long))


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["type", "features", "geometry", "coordinates", "mission", "x"]), inner)
    ),
    max_leaves=12,
)


@given(st.binary(max_size=200) | json_values.map(as_bytes))
def test_whatever_comes_is_read_or_refused(content: bytes) -> None:
    with suppress(InputDataError):
        assert import_shapes(content)
