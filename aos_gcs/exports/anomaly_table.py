"""Anomalies of a map as GeoJSON (RFC 7946), plain JSON or CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Sequence
from typing import Any

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.georeference import Georeference
from aos_gcs.surveys.anomalies import MapBlob

COLUMNS = (
    *("id", "x_m", "y_m", "z_m", "latitude_deg", "longitude_deg"),
    *("area_m2", "max_count", "agreement", "significance", "thumbnail", "length_m", "longer_than_a_person"),
)


def encode_anomalies(
    blobs: Sequence[MapBlob], georeference: Georeference | None, suffix: str, thumbnails: Sequence[str] = ()
) -> str:
    """Return a table of blobs, in their order.

    Args:
        blobs: see :class:`~aos_gcs.surveys.anomalies.MapBlob`.
        georeference: georeference of their world; without it, latitude and longitude are left empty.
        suffix: ``.geojson``, ``.json`` or ``.csv``.
        thumbnails: paths of the pictures of the first blobs.

    Raises:
        ConfigurationError: if the suffix is another one, or GeoJSON is asked for without a georeference.
    """
    if suffix not in FORMATS:
        raise ConfigurationError(f"A table of anomalies is written as {', '.join(FORMATS)}, not as {suffix!r}.")
    if suffix == ".geojson" and georeference is None:
        raise ConfigurationError("GeoJSON holds latitudes and longitudes, and the place of the map is not known.")
    pictures = [*thumbnails, *[None] * (len(blobs) - len(thumbnails))]
    rows = enumerate(zip(blobs, pictures, strict=True), start=1)
    return FORMATS[suffix]([_row(number, blob, picture, georeference) for number, (blob, picture) in rows])


def _row(number: int, blob: MapBlob, picture: str | None, georeference: Georeference | None) -> dict[str, Any]:
    place = None if georeference is None else georeference.latitude_longitude_deg(*blob.position_m)
    x_m, y_m, z_m = (round(value, 3) for value in blob.position_m)
    latitude_deg, longitude_deg = (None, None) if place is None else (round(angle, 8) for angle in place)
    figures = (round(blob.area_m2, 4), blob.max_count, round(blob.agreement, 4))
    significance = None if blob.significance is None else round(blob.significance, 2)
    length = (None, None) if blob.length_m is None else (round(blob.length_m, 2), blob.is_longer_than_a_person)
    values = (number, x_m, y_m, z_m, latitude_deg, longitude_deg, *figures, significance, picture, *length)
    return dict(zip(COLUMNS, values, strict=True))


def _geojson(rows: Sequence[dict[str, Any]]) -> str:
    features = [
        {
            "type": "Feature",
            "id": row["id"],
            "geometry": {"type": "Point", "coordinates": [row["longitude_deg"], row["latitude_deg"]]},
            "properties": {name: value for name, value in row.items() if not name.endswith("_deg")},
        }
        for row in rows
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}, indent=1) + "\n"


def _json(rows: Sequence[dict[str, Any]]) -> str:
    return json.dumps({"anomalies": rows}, indent=1) + "\n"


def _csv(rows: Sequence[dict[str, Any]]) -> str:
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


FORMATS: dict[str, Callable[[Sequence[dict[str, Any]]], str]] = {".geojson": _geojson, ".json": _json, ".csv": _csv}
"""Writer of a table, by the suffix of its file."""
