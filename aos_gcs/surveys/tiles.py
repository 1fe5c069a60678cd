"""A survey's raster cut into tiles, each with the images that may see it.

Tiles lie on a lattice that depends on nothing but the raster, and every one is computed on its own: results are the
same to the last bit however many are held at a time, and whichever machine computes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import Plane
from aos_gcs.imaging.focal_plane import footprint
from aos_gcs.imaging.model import MapRaster
from aos_gcs.imaging.surfaces.ground import raster_part
from aos_gcs.imaging.surfaces.terrain import Terrain
from aos_gcs.imaging.views import FocalSurface, FocalView, ortho_view, perspective_view

TILE_CELLS = 1024
"""Edge of a tile."""

Window = tuple[slice, slice]
"""Rows and columns of the whole raster."""


class Placed(Protocol):
    """An image as far as its content does not matter."""

    @property
    def camera(self) -> CameraModel:
        """Camera that took it."""

    @property
    def pose(self) -> Pose:
        """Pose of its camera at exposure."""


class RasterTile(Protocol):
    """A part of a raster that can be computed on its own."""

    @property
    def window(self) -> Window:
        """Place in the whole raster."""

    @property
    def images(self) -> tuple[int, ...]:
        """Indices of the images that may see it, ascending."""

    @property
    def cell_m(self) -> float | None:
        """Edge of a cell; None where cells have different sizes."""

    def view(self, surface: FocalSurface) -> FocalView:
        """Return its raster on a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class MapTile:
    """A part of a map."""

    window: Window
    images: tuple[int, ...]
    raster: MapRaster

    @property
    def cell_m(self) -> float:
        """See :class:`RasterTile`."""
        return self.raster.resolution_m

    def view(self, surface: FocalSurface) -> FocalView:
        """See :class:`RasterTile`."""
        return ortho_view(self.raster, surface)


@dataclass(frozen=True, slots=True, eq=False)
class ViewTile:
    """All that a virtual camera sees: views are not cut."""

    images: tuple[int, ...]
    camera: CameraModel
    pose: Pose
    cell_m: None = None

    @property
    def window(self) -> Window:
        """See :class:`RasterTile`."""
        return slice(0, self.camera.height_px), slice(0, self.camera.width_px)

    def view(self, surface: FocalSurface) -> FocalView:
        """See :class:`RasterTile`."""
        return perspective_view(self.camera, self.pose, surface)


def map_tiles(
    raster: MapRaster, images: Sequence[Placed], surface: FocalSurface, edge_cells: int = TILE_CELLS
) -> list[MapTile]:
    """Return the tiles of a map that any image may see, row by row."""
    if isinstance(surface, Terrain):
        planes = [Plane(float(surface.lower_m[2])), Plane(float(surface.upper_m[2]))]
    else:
        planes = [surface]
    spans = np.array([_cell_span(raster, image, planes) for image in images]).reshape(-1, 4)
    tiles = []
    for row in range(0, raster.rows, edge_cells):
        for column in range(0, raster.columns, edge_cells):
            rows, columns = (
                slice(row, min(row + edge_cells, raster.rows)),
                slice(column, min(column + edge_cells, raster.columns)),
            )
            meets = (
                (spans[:, 0] < rows.stop)
                & (spans[:, 1] > rows.start)
                & (spans[:, 2] < columns.stop)
                & (spans[:, 3] > columns.start)
            )
            if meets.any():
                indices = tuple(int(index) for index in np.flatnonzero(meets))
                tiles.append(MapTile((rows, columns), indices, raster_part(raster, (rows, columns))))
    return tiles


def grouped(
    tiles: Sequence[RasterTile], cell_bytes: int, max_bytes: int, least_groups: int = 1
) -> list[list[RasterTile]]:
    """Divide tiles into groups whose sums fit into memory, in their order; a group has at least one tile.

    Args:
        tiles: tiles of a map.
        cell_bytes: memory that a cell takes until its tile is done.
        max_bytes: largest size of the sums of a group.
        least_groups: number of groups of about equal work, if there are enough tiles for it.
    """
    groups: list[list[RasterTile]] = []
    used_bytes = 0
    work = np.array([_cells(tile) * len(tile.images) for tile in tiles])
    shares = np.floor(least_groups * (np.cumsum(work) - work / 2) / max(work.sum(), 1))
    for tile, share, before in zip(tiles, shares, np.roll(shares, 1), strict=True):
        tile_bytes = _cells(tile) * cell_bytes
        if not groups or used_bytes + tile_bytes > max_bytes or share != before:
            groups.append([])
            used_bytes = 0
        groups[-1].append(tile)
        used_bytes += tile_bytes
    return groups


def _cells(tile: RasterTile) -> int:
    rows, columns = tile.window
    return int((rows.stop - rows.start) * (columns.stop - columns.start))


def _cell_span(raster: MapRaster, image: Placed, planes: Sequence[Plane]) -> NDArray[np.float64]:
    """Return the first and last row and column, shape (4,), that bound what an image sees; infinite if nothing.

    Args:
        raster: raster of the map.
        image: image that is projected.
        planes: the surface, or the planes that it lies between.
    """
    outline_m = np.concatenate([footprint(image.camera, image.pose, plane) for plane in planes])
    if not len(outline_m):
        return np.array([np.inf, -np.inf, np.inf, -np.inf])
    to_cells = np.linalg.inv(raster.to_plane)
    column, row, _ = to_cells @ np.column_stack((outline_m, np.ones(len(outline_m)))).T
    # Cells reach half a cell beyond their centres; another half is for rounding.
    return np.array([row.min() - 1.0, row.max() + 1.0, column.min() - 1.0, column.max() + 1.0])
