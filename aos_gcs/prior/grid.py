"""Priors of GeoTIFF files: each cell's value is how likely a place in it is, compared with others."""

from __future__ import annotations

import logging
import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from aos_gcs.errors import InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.heights import SEA_LEVEL
from aos_gcs.height_rasters import check_file, gdal_reason
from aos_gcs.prior.model import FloatArray

MAX_CELLS: Final = 4_000_000
"""Greatest number of cells: 20 km x 20 km in cells of 10 m."""
_NODES: Final = 8
"""Places along each axis between which the mapping of the local frame to the file's cells is interpolated."""
_COLOURS: Final = frozenset({"palette", "red", "green", "blue", "alpha"})


@dataclass(frozen=True, slots=True, eq=False)
class GridPrior:
    """A raster of densities in a coordinate system of the Earth."""

    density: NDArray[np.float64]
    """Probability per square metre, shape (rows, columns)."""
    to_cells: Any
    """Affine mapping of coordinates to columns and rows, edges of cells being whole numbers."""
    to_crs: Any
    """Transformer of longitude and latitude to coordinates."""

    def density_per_m2(self, frame: LocalFrame, places_enu_m: FloatArray) -> FloatArray:
        """Return the probability per square metre at places; see :class:`~aos_gcs.prior.model.Prior`."""
        columns, rows = self._cells(frame, places_enu_m)
        height, width = self.density.shape
        is_known = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        found = self.density[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        return np.where(is_known, found, 0.0)

    def _cells(self, frame: LocalFrame, places_m: FloatArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the columns and rows in which places lie, interpolated between nodes: a local frame is nearly flat."""
        low_m, high_m = places_m.min(axis=0), places_m.max(axis=0)
        extent_m = np.maximum(high_m - low_m, 1.0)
        steps = np.linspace(0.0, 1.0, _NODES)
        nodes = [
            frame.to_geodetic((low_m[0] + u * extent_m[0], low_m[1] + v * extent_m[1], 0.0))
            for v in steps
            for u in steps
        ]
        x, y = self.to_crs.transform([one.longitude_deg for one in nodes], [one.latitude_deg for one in nodes])
        cells = np.array(_mapped(self.to_cells, np.array(x), np.array(y))).reshape(2, _NODES, _NODES)
        scaled = (places_m - low_m) / extent_m * (_NODES - 1)
        first = np.clip(np.floor(scaled).astype(np.int64), 0, _NODES - 2)
        u, v = (scaled - first).T
        column, row = first.T
        near = cells[:, row, column] * (1 - u) + cells[:, row, column + 1] * u
        far = cells[:, row + 1, column] * (1 - u) + cells[:, row + 1, column + 1] * u
        found = np.where(np.isfinite(near + far), near * (1 - v) + far * v, -1.0)
        columns, rows = np.floor(np.clip(found, -1.0, 2.0**31)).astype(np.int64)
        return columns, rows


def read_grid(path: Path) -> GridPrior:
    """Read a prior from a GeoTIFF.

    Raises:
        InputDataError: it is none; the text names the file and the remedy.
        ConfigurationError: rasterio or pyproj is not installed.
    """
    rasterio: Any = load_extra("rasterio", "geo", "Reading a probability map")
    pyproj: Any = load_extra("pyproj", "geo", "Reading a probability map")
    # It logs what GDAL says before it raises the same words.
    logging.getLogger("rasterio").setLevel(logging.CRITICAL)
    check_file(path, f"The probability map {path}")
    try:
        with (
            warnings.catch_warnings(action="ignore", category=rasterio.errors.NotGeoreferencedWarning),
            rasterio.open(path) as dataset,
        ):
            _check_layout(dataset, path)
            crs = pyproj.CRS.from_user_input(dataset.crs.to_wkt())
            values = _values(dataset, path)
            transform = dataset.transform
    except rasterio.errors.RasterioError as error:
        raise InputDataError(f"The probability map {path} cannot be read: {gdal_reason(error)}.") from error
    except pyproj.exceptions.CRSError as error:
        raise InputDataError(
            f"The coordinate system of {path} is not known: warp it to one such as EPSG:4326."
        ) from error
    if not (crs.is_geographic or crs.is_projected):
        raise InputDataError(f"{path} is in {crs.name}, which has no places in a plane or in degrees: warp it.")
    to_crs = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True)
    cell_m2 = _cell_m2(transform, to_crs, values.shape)
    if not (math.isfinite(cell_m2) and cell_m2 > 0.0):
        raise InputDataError(f"The place of {path} is not on the Earth: state its coordinate system correctly.")
    return GridPrior(values / (float(values.sum()) * cell_m2), ~transform, to_crs)


def _mapped(affine: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return coordinates by an affine mapping."""
    return affine.a * x + affine.b * y + affine.c, affine.d * x + affine.e * y + affine.f


def _check_layout(dataset: Any, path: Path) -> None:
    if dataset.crs is None:
        raise InputDataError(
            f"The probability map {path} states no coordinate system: set it (gdal_edit.py -a_srs EPSG:CODE {path})."
        )
    if dataset.transform.is_identity or dataset.transform.determinant == 0.0:
        raise InputDataError(f"The probability map {path} is a picture whose place is not known: georeference it.")
    colours = {getattr(colour, "name", "") for colour in dataset.colorinterp} & _COLOURS
    if colours or dataset.count != 1:
        raise InputDataError(
            f"The probability map {path} has {dataset.count} bands or colours: export the values as one band."
        )
    if dataset.width * dataset.height > MAX_CELLS:
        raise InputDataError(
            f"The probability map {path} has {dataset.width} x {dataset.height} cells, {MAX_CELLS:,} are allowed: cut "
            "it, or make its cells larger (gdalwarp -te, -tr)."
        )
    if "complex" in dataset.dtypes[0]:
        raise InputDataError(f"The probability map {path} has complex numbers: export real ones.")


def _values(dataset: Any, path: Path) -> NDArray[np.float64]:
    """Return the values, 0 in cells that the file declares to be without data."""
    masked = dataset.read(1, masked=True)
    values = np.asarray(np.ma.getdata(masked), dtype=np.float64) * dataset.scales[0] + dataset.offsets[0]
    values[np.ma.getmaskarray(masked)] = 0.0
    if not np.isfinite(values).all():
        count = int(np.count_nonzero(~np.isfinite(values)))
        raise InputDataError(
            f"The probability map {path} has {count} cells that are no finite number: declare them as nodata, or set "
            "them to 0."
        )
    if (values < 0.0).any():
        raise InputDataError(
            f"The probability map {path} has negative values, down to {values.min():g}: set them to 0, or declare them "
            "as nodata."
        )
    if not (values > 0.0).any():
        raise InputDataError(f"Every value of the probability map {path} is 0: it says nothing of where the person is.")
    return np.asarray(values)


def _cell_m2(transform: Any, to_crs: Any, shape: tuple[int, ...]) -> float:
    """Return the area of a cell in the middle of the raster."""
    row, column = shape[0] // 2, shape[1] // 2
    corners = [_mapped(transform, column + right, row + down) for right, down in ((0, 0), (1, 0), (1, 1), (0, 1))]
    degrees = [to_crs.transform(x, y, direction="INVERSE") for x, y in corners]
    places = [GeodeticPosition(latitude_deg, longitude_deg, SEA_LEVEL) for longitude_deg, latitude_deg in degrees]
    if not all(math.isfinite(one.latitude_deg) and math.isfinite(one.longitude_deg) for one in places):
        return math.nan
    frame = LocalFrame(places[0])
    east_m, north_m = np.array([frame.to_enu(place)[:2] for place in places]).T
    return abs(float(east_m @ np.roll(north_m, -1) - north_m @ np.roll(east_m, -1))) / 2.0
