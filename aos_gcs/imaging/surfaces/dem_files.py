"""Terrain from files: OBJ meshes and GeoTIFF elevation models."""

from __future__ import annotations

import gzip
import itertools
import logging
import math
import warnings
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.extras import load_extra
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.height_rasters import check_file, check_heights, gdal_reason, read_heights, refuse_impossible, unwrapped
from aos_gcs.imaging.surfaces.mesh import terrain_from_mesh
from aos_gcs.imaging.surfaces.terrain import Terrain

MAX_SAMPLES = 50_000_000
"""Largest number of samples of a GeoTIFF; larger ones are refused to limit the memory."""

MAX_MESH_BYTES = 250_000_000
"""Largest mesh, unpacked; a small file can unpack to far more."""


def read_dem(
    path: Path, origin: GeodeticPosition | None = None, R_mesh2world: NDArray[np.float64] | None = None
) -> Terrain:
    """Read a terrain.

    ``.obj`` and ``.obj.gz`` meshes have the coordinates of the world that the terrain is used in, or are turned to its
    axes by a rotation, shape (3, 3). A ``.tif`` has
    those of its own coordinate system, with z up; with ``origin`` it is brought to the east-north-up world there.

    Raises:
        ConfigurationError: if the kind of file is not known, does not go with ``origin``, or its library is missing.
        InputDataError: if the file is unreadable, or has no coordinate system where ``origin`` asks for one.
    """
    if is_geotiff(path):
        return _read_geotiff(path, origin)
    if not path.name.lower().endswith((".obj", ".obj.gz")):
        raise ConfigurationError(f"The terrain {path} is of no known kind: use .obj, .obj.gz or .tif.")
    if origin is not None:
        raise ConfigurationError(
            f"The terrain {path} is a mesh without a coordinate system: it must already have the coordinates of the "
            "poses, and no origin can be given for it."
        )
    vertices, triangles = _read_obj(path)
    try:
        return terrain_from_mesh(vertices if R_mesh2world is None else vertices @ R_mesh2world.T, triangles)
    except ValueError as error:
        raise InputDataError(f"The terrain {path} cannot be used: {error}.") from error


def is_geotiff(path: Path) -> bool:
    """Tell whether a file's name is that of a GeoTIFF."""
    return path.suffix.lower() in (".tif", ".tiff")


def read_dem_crs(path: Path) -> str | None:
    """Return the coordinate system of a GeoTIFF as WKT; None if it has none.

    Raises:
        ConfigurationError: if rasterio is not installed.
        InputDataError: if the file is unreadable.
    """
    with _opened(path) as dataset:
        return str(dataset.crs.to_wkt()) if dataset.crs else None


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Yield a raster file as rasterio's dataset; what is wrong with it is said in our own words."""
    rasterio: Any = load_extra("rasterio", "geo", "Reading a GeoTIFF")
    check_file(path, f"The terrain {path}")
    # It logs what GDAL says before it raises the same words.
    logging.getLogger("rasterio").setLevel(logging.CRITICAL)
    try:
        with (
            # Callers refuse files without a place themselves.
            warnings.catch_warnings(action="ignore", category=rasterio.errors.NotGeoreferencedWarning),
            rasterio.open(path) as dataset,
        ):
            yield dataset
    except rasterio.errors.RasterioError as error:
        raise InputDataError(f"The terrain {path} cannot be read: {gdal_reason(error)}.") from error


def _read_obj(path: Path) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    try:
        check_file(path, f"The terrain {path}")
        with gzip.open(path) if path.suffix.lower() == ".gz" else path.open("rb") as file:
            content = file.read(MAX_MESH_BYTES + 1)
        if len(content) > MAX_MESH_BYTES:
            raise InputDataError(
                f"The terrain {path} has more than {MAX_MESH_BYTES / 1e6:.0f} MB: cut out the area of the flight first."
            )
        text = content.decode("utf-8", "replace")
    except (OSError, EOFError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputDataError(f"The terrain {path} cannot be read: {reason}.") from error
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        kind, *fields = line.split() or [""]
        try:
            if kind == "v":
                vertices.append([float(field) for field in fields[:3]])
            elif kind == "f":
                triangles.extend(_fan([_vertex(field, len(vertices)) for field in fields]))
        except ValueError as error:
            raise InputDataError(f"The terrain {path} has an invalid line {number}: {line[:60]!r}.") from error
    points = np.array(vertices if {len(vertex) for vertex in vertices} == {3} else [], dtype=np.float64)
    corners = np.array(triangles, dtype=np.intp)
    if not triangles or not points.size or not np.isfinite(points).all() or corners.max() >= len(points):
        raise InputDataError(f"The terrain {path} is not a mesh of finite vertices and faces.")
    return points, corners


def _vertex(field: str, known: int) -> int:
    """Return the index of a face's vertex: numbered from 1, or backwards from the last one read."""
    number = int(field.split("/", maxsplit=1)[0])
    index = number - 1 if number > 0 else known + number
    if number == 0 or index < 0:
        raise ValueError(number)
    return index


def _fan(polygon: list[int]) -> Iterable[tuple[int, int, int]]:
    return ((polygon[0], second, third) for second, third in itertools.pairwise(polygon[1:]))


def _read_geotiff(path: Path, origin: GeodeticPosition | None) -> Terrain:
    with _opened(path) as dataset:
        if dataset.width * dataset.height > MAX_SAMPLES:
            raise InputDataError(
                f"The terrain {path} has {dataset.width} x {dataset.height} heights; cut out the area of the flight "
                f"first (at most {MAX_SAMPLES} heights)."
            )
        check_heights(dataset, path, f"The terrain {path}")
        heights = read_heights(dataset).astype(np.float64)
        refuse_impossible(heights, f"The terrain {path}")
        crs, to_world = dataset.crs, np.array(dataset.transform).reshape(3, 3)
    if not crs and np.array_equal(to_world, np.eye(3)):
        raise InputDataError(
            f"The terrain {path} has no georeference: it is a picture whose place is not known. Use one with a "
            "coordinate system, or at least with a geotransform in the coordinates of the poses."
        )
    if origin is not None and not crs:
        raise InputDataError(
            f"The terrain {path} has no coordinate system, so that it cannot be placed about an origin: assign one "
            "(gdal_edit.py -a_srs), or leave the origin out if its coordinates are those of the poses."
        )
    if origin is None and crs and crs.is_geographic:
        raise InputDataError(
            f"The terrain {path} is in degrees ({crs}), but the poses are in metres: give the geodetic origin of the "
            "poses' world, or project the terrain to metres first."
        )
    middle_x = float((to_world @ (heights.shape[1] / 2, heights.shape[0] / 2, 1.0))[0])
    place = _Local(crs, origin, middle_x) if origin is not None else _Own()
    try:
        return _resample(heights, to_world, place)
    except ValueError as error:
        raise InputDataError(f"The terrain {path} cannot be used: {error}.") from error


class _Own:
    """The raster's coordinates are those of the world."""

    def to_world(self, x: Any, y: Any) -> tuple[Any, Any]:
        return x, y

    from_world = to_world

    def z_m(self, _x_m: Any, _y_m: Any, heights: NDArray[np.float64]) -> NDArray[np.float64]:
        return heights


class _Local:
    """The world is east-north-up about an origin.

    Args:
        crs: coordinate system of the raster.
        origin: origin of the world.
        middle_x: coordinate of the raster's middle, which longitudes are near to: across or beside the 180th meridian
            it may count beyond 180 degrees, either way.
    """

    def __init__(self, crs: Any, origin: GeodeticPosition, middle_x: float) -> None:
        pyproj: Any = load_extra("pyproj", "geo", "Reading a GeoTIFF")
        self._pymap3d: Any = load_extra("pymap3d", "geo", "Reading a GeoTIFF")
        system = pyproj.CRS.from_wkt(crs.to_wkt())
        self._to_geodetic = pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True)
        self._turn = 2.0 * math.pi / system.axis_info[0].unit_conversion_factor if system.is_geographic else None
        """Whole turn in units of a coordinate system of angles; None for others."""
        self._middle_x = middle_x
        self._origin = (origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m)

    def to_world(self, x: Any, y: Any) -> tuple[Any, Any]:
        longitude_deg, latitude_deg = self._to_geodetic.transform(x, y)
        east_m, north_m, _ = self._pymap3d.geodetic2enu(latitude_deg, longitude_deg, self._origin[2], *self._origin)
        return east_m, north_m

    def from_world(self, x_m: Any, y_m: Any) -> tuple[Any, Any]:
        latitude_deg, longitude_deg, _ = self._pymap3d.enu2geodetic(x_m, y_m, 0.0, *self._origin)
        x, y = self._to_geodetic.transform(longitude_deg, latitude_deg, direction="INVERSE")
        return x if self._turn is None else unwrapped(np.asarray(x), self._middle_x, self._turn), y

    def z_m(self, x_m: Any, y_m: Any, heights: NDArray[np.float64]) -> NDArray[np.float64]:
        latitude_deg, longitude_deg, _ = self._pymap3d.enu2geodetic(x_m, y_m, 0.0, *self._origin)
        return np.asarray(self._pymap3d.geodetic2enu(latitude_deg, longitude_deg, heights, *self._origin)[2])


def _resample(heights: NDArray[np.float64], to_crs: NDArray[np.float64], place: _Own | _Local) -> Terrain:
    """Resample a raster, whose affine map takes pixel *corners* (column, row, 1) to coordinates, to a regular grid."""
    rows, columns = heights.shape
    if min(rows, columns) < 2:
        raise ValueError(f"a terrain needs at least 2 x 2 heights, got {rows} x {columns}")
    # Along the whole outline: the edges of a projected raster are curved in another system.
    across, down = np.linspace(0.5, columns - 0.5, 33), np.linspace(0.5, rows - 0.5, 33)
    outline = np.vstack(
        [np.column_stack((across, np.full(33, edge))) for edge in (0.5, rows - 0.5)]
        + [np.column_stack((np.full(33, edge), down)) for edge in (0.5, columns - 0.5)]
    )
    x, y, _ = to_crs @ np.column_stack((outline, np.ones(len(outline)))).T
    x_m, y_m = place.to_world(x, y)
    width_m, height_m = float(np.ptp(x_m)), float(np.ptp(y_m))
    spacing_m = math.sqrt(width_m * height_m / ((rows - 1) * (columns - 1)))
    if not math.isfinite(spacing_m) or spacing_m <= 0.0:
        raise ValueError("its outline cannot be placed in the world of the poses")
    xs = float(np.min(x_m)) + spacing_m * np.arange(math.floor(width_m / spacing_m + 1e-6) + 1)
    ys = float(np.min(y_m)) + spacing_m * np.arange(math.floor(height_m / spacing_m + 1e-6) + 1)
    grid_x, grid_y = np.meshgrid(xs, ys)
    own_x, own_y = place.from_world(grid_x, grid_y)
    flat = np.stack((np.ravel(own_x), np.ravel(own_y), np.ones(grid_x.size)))
    column, row, _ = np.linalg.inv(to_crs) @ flat
    # Samples on the very edge must not fall out of the raster by rounding.
    row, column = _snap(row - 0.5, rows), _snap(column - 0.5, columns)
    sampled = scipy.ndimage.map_coordinates(heights, (row, column), order=1, mode="constant", cval=np.nan)
    return Terrain(float(xs[0]), float(ys[0]), spacing_m, place.z_m(grid_x, grid_y, sampled.reshape(grid_x.shape)))


def _snap(index: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    clipped = np.clip(index, 0.0, size - 1.0)
    return np.where(np.abs(clipped - index) < 1e-3, clipped, index)
