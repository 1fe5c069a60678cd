"""Rasters as NumPy arrays, GeoTIFF and pictures with world files, each written as a whole or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.exports.files import replaced_whole, written_whole
from aos_gcs.exports.geotiff import write_geotiff
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.pictures import encode_png

TIFF_SUFFIXES = (".tif", ".tiff")
RASTER_SUFFIXES = (".npy", *TIFF_SUFFIXES)


@dataclass(frozen=True, slots=True, eq=False)
class MapPlace:
    """Place of a map in its world and on the earth."""

    raster: MapRaster
    crs: str | None
    """Coordinate system as PROJ or WKT text; None: not georeferenced."""


def write_raster(
    path: Path, values: NDArray[Any], place: MapPlace | None, bands: tuple[str, ...], nodata: float | None
) -> None:
    """Write a raster as the suffix of its file says: GeoTIFF for a map with a place on the earth, else NumPy's format.

    Args:
        path: file that is written, or replaced.
        values: shape (rows, columns) or (rows, columns, bands).
        place: place of a map; None for a view.
        bands: descriptions of a GeoTIFF's bands.
        nodata: value that stands for no data in a GeoTIFF; None: every value is data.

    Raises:
        ConfigurationError: if the file cannot be written.
    """
    if place is not None and place.crs is not None and path.suffix.lower() in TIFF_SUFFIXES:
        layers = values if values.ndim == 3 else values[:, :, np.newaxis]
        with replaced_whole(path) as temporary:
            write_geotiff(temporary, layers, place.raster, place.crs, descriptions=bands, nodata=nodata)
    else:
        with written_whole(path) as file:
            np.save(file, values)


def write_picture(path: Path, rgba: NDArray[np.uint8]) -> None:
    """Write an RGBA image, shape (rows, columns, 4), as a PNG file.

    Raises:
        ConfigurationError: if the file cannot be written.
    """
    with written_whole(path) as file:
        file.write(encode_png(rgba))


def world_file_path(picture: Path) -> Path:
    """Return the path of the world file beside a PNG picture."""
    return picture.with_suffix(".pgw")


def write_world_file(picture: Path, raster: MapRaster) -> None:
    """Write the six lines beside a picture of a map from which a GIS takes its place.

    Raises:
        ConfigurationError: if the file cannot be written.
    """
    (dx_m, _, x_m), (_, dy_m, y_m), _ = raster.to_plane
    lines = "".join(f"{value!r}\n" for value in map(float, (dx_m, 0.0, 0.0, dy_m, x_m, y_m)))
    with written_whole(world_file_path(picture)) as file:
        file.write(lines.encode("ascii"))
