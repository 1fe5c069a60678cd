"""Maps as cloud-optimised GeoTIFF."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError
from aos_gcs.extras import load_extra
from aos_gcs.imaging.model import MapRaster

BLOCK_CELLS = 512

_LAYOUT = {"tiled": True, "blockxsize": BLOCK_CELLS, "blockysize": BLOCK_CELLS, "bigtiff": "IF_SAFER"}


def write_geotiff(
    path: Path,
    values: NDArray[Any],
    raster: MapRaster,
    crs: str,
    *,
    descriptions: Sequence[str],
    nodata: float | None,
) -> None:
    """Write a map: deflated tiles with overviews, band by band.

    Memory does not grow with the map when ``values`` live in a file. An uncompressed copy lies beside ``path`` while it
    is written.

    Args:
        path: new file; an existing one is replaced.
        values: shape (rows, columns, bands), any real type.
        raster: place of the cells; rows must lead against y, north-up.
        crs: PROJ or WKT text, see :class:`~aos_gcs.exports.georeference.Georeference`.
        descriptions: descriptions of the bands.
        nodata: value that stands for no data; None: every value is one.

    Raises:
        ConfigurationError: if rasterio is not installed, or the file cannot be written.
    """
    rasterio: Any = load_extra("rasterio", "geo", "Writing a GeoTIFF")
    load_extra("rasterio.shutil", "geo", "Writing a GeoTIFF")
    # It logs what GDAL says before it raises the same words.
    logging.getLogger("rasterio").setLevel(logging.ERROR)
    raw = path.with_name(f"{path.name}.raw")
    to_plane = raster.to_plane
    r = raster.resolution_m
    profile = {
        "driver": "GTiff",
        "height": raster.rows,
        "width": raster.columns,
        "count": values.shape[2],
        "dtype": values.dtype.name,
        "nodata": nodata,
        "transform": rasterio.Affine(r, 0.0, raster.x_m, 0.0, float(to_plane[1, 1]), raster.y_m),
    }
    try:
        # A map may well begin at the origin with cells of one metre, which rasterio takes for an accident.
        with (
            warnings.catch_warnings(action="ignore", category=rasterio.errors.NotGeoreferencedWarning),
            rasterio.open(raw, "w", crs=rasterio.CRS.from_string(crs), **profile, **_LAYOUT) as dataset,
        ):
            for _, window in dataset.block_windows(1):
                rows, columns = window.toslices()
                dataset.write(np.moveaxis(values[rows, columns], 2, 0), window=window)
            for band, description in enumerate(descriptions, start=1):
                dataset.set_band_description(band, description)
        predictor = "FLOATING_POINT" if values.dtype.kind == "f" else "STANDARD"
        rasterio.shutil.copy(
            raw,
            path,
            driver="COG",
            compress="DEFLATE",
            predictor=predictor,
            blocksize=BLOCK_CELLS,
            # Averages would invent counts that no cell has.
            overview_resampling="AVERAGE" if values.dtype.kind == "f" else "NEAREST",
            bigtiff="IF_SAFER",
        )
    except (rasterio.errors.RasterioError, rasterio.errors.CRSError, OSError) as error:
        raise ConfigurationError(f"Cannot write {path}: {error}.") from error
    finally:
        raw.unlink(missing_ok=True)
