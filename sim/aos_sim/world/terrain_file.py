"""The ground of a scene as an elevation model, for programs that fly over it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_sim.world.relief import Relief
from aos_sim.world.terrain import drop_of_earth_m, local_projection

_VERTICAL = "EPSG:5773"
"""Heights above the geoid EGM96, which simulated altitudes count from."""


def write_geotiff(path: Path, relief: Relief, origin: GeodeticPosition) -> None:
    """Write the heights above mean sea level as a GeoTIFF, about 0.5 MB, in a projection about the origin.

    Raises:
        ConfigurationError: rasterio or pyproj is not installed, or the file cannot be written.
    """
    rasterio: Any = load_extra("rasterio", "geo", "Writing an elevation model")
    pyproj: Any = load_extra("pyproj", "geo", "Writing an elevation model")
    rows, columns = relief.heights_m.shape
    east_m = relief.west_m + relief.cell_m * np.arange(columns)
    north_m = relief.south_m + relief.cell_m * np.arange(rows)
    amsl_m = origin.altitude_amsl_m + relief.heights_m + drop_of_earth_m(*np.meshgrid(east_m, north_m))
    system = pyproj.crs.CompoundCRS("Simulated ground", [local_projection(origin), _VERTICAL])
    # Heights stand at the centres of the file's cells, and its rows begin in the north.
    west_m, north_edge_m = relief.west_m - relief.cell_m / 2, north_m[-1] + relief.cell_m / 2
    try:
        with rasterio.open(
            path,
            "w",
            driver="GTiff",
            height=rows,
            width=columns,
            count=1,
            dtype="float32",
            crs=rasterio.crs.CRS.from_wkt(system.to_wkt()),
            transform=rasterio.Affine(relief.cell_m, 0.0, west_m, 0.0, -relief.cell_m, north_edge_m),
        ) as dataset:
            dataset.write(amsl_m[::-1].astype(np.float32), 1)
    except (OSError, rasterio.errors.RasterioError) as error:
        raise ConfigurationError(f"--terrain-file {path} cannot be written: {error}.") from error
