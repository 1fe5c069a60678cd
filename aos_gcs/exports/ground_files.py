"""Searched ground as files that other tools open: a GeoTIFF of probabilities, and its gaps as GeoJSON polygons."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.exports.files import replaced_whole
from aos_gcs.exports.georeference import LocalGeoreference
from aos_gcs.exports.geotiff import write_geotiff
from aos_gcs.exports.outlines import Ring, outlines
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.groundmap.figures import Polygon, ViewRaster
from aos_gcs.groundmap.ground_map import GroundMap
from aos_gcs.groundmap.tile import COLOUR_CELL_M, COLOUR_CELLS, TILE_M, VIEW_CELL_M
from aos_gcs.imaging.model import MapRaster
from aos_gcs.prior.model import AreaPrior
from aos_gcs.prior.segments import Segment

LEAST_GAP_M2: Final = 4.0
"""Smaller gaps are left out: nobody is sent there for them."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchedGround:
    """Searched ground of a mission, as it is recorded."""

    raster: ViewRaster
    """Numbers of independent views."""
    origin: GeodeticPosition
    """Origin of the frame of raster and area."""
    area_enu_m: Polygon
    """Search area."""
    occlusion: float | None
    """Share of the ground that one image does not see; None where the forest is not described."""
    frames: int
    """Frames on the map."""
    prior: AreaPrior | None = None
    """Probability by place in the area, before the search; None without a prior."""
    segments: tuple[Segment, ...] = ()
    """Segments that the mission has named."""

    def detection(self, posture: Posture) -> NDArray[np.float64]:
        """Return the probability of detection of each cell, shape (rows, columns).

        Raises:
            ConfigurationError: the forest is not described.
        """
        if self.occlusion is None:
            raise ConfigurationError(
                "The probability of detection is not known: the mission's configuration has no section [forest]."
            )
        return np.asarray(detection_by_views(self.occlusion, DETECTABILITY[posture])[self.raster.views])


def write_ground_raster(path: Path, ground: SearchedGround) -> None:
    """Write views and, where the forest is described, probabilities of detection as a cloud-optimised GeoTIFF.

    Bands: ``views``, ``detection standing``, ``detection sitting``, ``detection lying`` (0 to 1); cells of one metre.

    Raises:
        ConfigurationError: rasterio is not installed, or the file cannot be written.
    """
    raster = ground.raster
    bands = {"views": raster.views.astype(np.float32)}
    if ground.occlusion is not None:
        bands |= {f"detection {one}": ground.detection(one).astype(np.float32) for one in Posture}
    rows, columns = raster.views.shape
    place = MapRaster(raster.west_m, raster.north_m, VIEW_CELL_M, rows, columns, rows_along_y=False)
    with replaced_whole(path) as temporary:
        write_geotiff(
            temporary,
            np.dstack(list(bands.values())),
            place,
            LocalGeoreference(ground.origin).crs(0.0),
            descriptions=tuple(bands),
            nodata=None,
        )


def write_forest_floor(path: Path, ground: GroundMap) -> None:
    """Write the integral of all frames on the ground as a cloud-optimised GeoTIFF, with cells of 0.25 m.

    Bands: ``red``, ``green``, ``blue`` (0 to 255) and ``thermal`` (degrees Celsius, or what the cameras give in their
    place); NaN where no frame has one.

    Raises:
        ConfigurationError: there is no tile, rasterio is not installed, or the file cannot be written.
    """
    if not ground.views:
        raise ConfigurationError("The map of searched ground has no tile: nothing was searched.")
    rows, columns = zip(*ground.views, strict=True)
    first_row, first_column = min(rows), min(columns)
    height, width = max(rows) - first_row + 1, max(columns) - first_column + 1
    values = np.full((height * COLOUR_CELLS, width * COLOUR_CELLS, 4), np.nan, dtype=np.float32)
    for index in sorted(ground.views):
        tile = ground.tile(index)
        if tile is not None:
            top, left = (index[0] - first_row) * COLOUR_CELLS, (index[1] - first_column) * COLOUR_CELLS
            values[top : top + COLOUR_CELLS, left : left + COLOUR_CELLS] = tile.means()
    west_m, north_m = first_column * TILE_M, -first_row * TILE_M
    place = MapRaster(west_m, north_m, COLOUR_CELL_M, values.shape[0], values.shape[1], rows_along_y=False)
    with replaced_whole(path) as temporary:
        write_geotiff(
            temporary,
            values,
            place,
            LocalGeoreference(ground.header.origin).crs(0.0),
            descriptions=("red", "green", "blue", "thermal"),
            nodata=float("nan"),
        )


def gaps_geojson(ground: SearchedGround, posture: Posture, below: float) -> str:
    """Return the parts of the search area with a low probability of detection as a GeoJSON text (RFC 7946).

    Args:
        ground: searched ground.
        posture: posture of the person.
        below: probability below which a place is a gap, 0 to 1.

    Raises:
        ConfigurationError: the forest is not described, or ``below`` is out of its range.
    """
    if not 0.0 < below <= 1.0:
        raise ConfigurationError(f"below must be above 0 and at most 1, got {below:g}.")
    probability = ground.detection(posture)
    gap = ground.raster.inside(ground.area_enu_m) & (probability < below)
    _, labels, statistics, _ = cv2.connectedComponentsWithStats(gap.astype(np.uint8), connectivity=4)
    sizes = np.asarray(statistics[:, cv2.CC_STAT_AREA])
    features = []
    for label, rings in sorted(outlines(np.asarray(labels)).items()):
        if sizes[label] * VIEW_CELL_M**2 < LEAST_GAP_M2:
            continue
        properties = {
            "area_m2": float(sizes[label]) * VIEW_CELL_M**2,
            "mean_detection": round(float(probability[labels == label].mean()), 3),
            "posture": posture.value,
            "below": below,
        }
        coordinates = [_placed(ring, ground) for ring in rings]
        geometry = {"type": "Polygon", "coordinates": coordinates}
        features.append({"type": "Feature", "properties": properties, "geometry": geometry})
    return json.dumps({"type": "FeatureCollection", "features": features})


def _placed(ring: Ring, ground: SearchedGround) -> list[tuple[float, float]]:
    """Return the corners of a ring, longitude first, the first one again at the end."""
    georeference = LocalGeoreference(ground.origin)
    places = []
    for row, column in (*ring, ring[0]):
        east_m = ground.raster.west_m + column * VIEW_CELL_M
        north_m = ground.raster.north_m - row * VIEW_CELL_M
        latitude, longitude = georeference.latitude_longitude_deg(east_m, north_m, 0.0)
        places.append((round(longitude, 7), round(latitude, 7)))
    return places
