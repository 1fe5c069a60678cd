"""A base map of the simulated forest, as an orthophoto would show it: ground, relief and crowns, nothing that moves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.basemaps.archive import tile_archive
from aos_gcs.basemaps.mercator import WorldBox, from_degrees
from aos_gcs.basemaps.picture import PictureSource
from aos_gcs.basemaps.pyramid import KIND, Pyramid
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_sim.world.scene import Scene

FloatArray = NDArray[np.float64]
Picture = NDArray[np.uint8]

CELL_M: Final = 0.25
_ABOUT_M = 120.0
"""Width of the strip about the forest that the map shows."""
_LIGHT_ENU = np.array([-0.5, 0.5, math.sqrt(0.5)])
"""Direction of the light: from the north-west, at 45 degrees."""
_CROWN = np.array([62.0, 92.0, 44.0])
_SHADE, _HIGHLIGHT = 0.55, 1.22
_SUB_PIXEL_BITS = 4


def draw_map(path: Path, scene: Scene, origin: GeodeticPosition) -> None:
    """Write the base map of a scene as a PMTiles archive.

    Raises:
        ConfigurationError: the pmtiles library is missing, or the file cannot be written.
    """
    low_m, high_m = scene.area_enu_m.min(axis=0) - _ABOUT_M, scene.area_enu_m.max(axis=0) + _ABOUT_M
    picture = forest_picture(scene, low_m, high_m)
    pyramid = Pyramid([_placed(picture, low_m, high_m, origin)])
    with tile_archive(path) as archive:
        pyramid.write(archive, lambda _: None)
        archive.finish(KIND, pyramid.box, {"name": "Simulated forest", "type": "baselayer"})


def forest_picture(scene: Scene, low_enu_m: FloatArray, high_enu_m: FloatArray) -> Picture:
    """Return a scene from above, shape (rows, columns, 4): red, green, blue and opacity; row 0 is the northern one.

    Args:
        scene: ground, relief and trees.
        low_enu_m: south-western corner, shape (2,).
        high_enu_m: north-eastern corner.
    """
    columns, rows = (int(count) for count in np.ceil((high_enu_m - low_enu_m) / CELL_M))
    east_m = low_enu_m[0] + (np.arange(columns) + 0.5) * CELL_M
    north_m = high_enu_m[1] - (np.arange(rows) + 0.5) * CELL_M
    colours = np.empty((rows, columns, 3), dtype=np.float32)
    for row, north in enumerate(north_m):
        colours[row] = scene.ground.sample(east_m, np.full(columns, north))[:, :3]
        if scene.relief is not None:
            rise_east, rise_north = scene.relief.gradient(east_m, np.full(columns, north))
            slope = np.sqrt(1.0 + rise_east**2 + rise_north**2)
            light = (_LIGHT_ENU[2] - _LIGHT_ENU[0] * rise_east - _LIGHT_ENU[1] * rise_north) / slope
            colours[row] *= (light / _LIGHT_ENU[2]).clip(0.3, 1.5)[:, None].astype(np.float32)
    picture = colours.clip(0.0, 255.0).astype(np.uint8)
    _draw_crowns(picture, scene, low_enu_m[0], high_enu_m[1])
    return np.dstack((picture, np.full((rows, columns), 255, dtype=np.uint8)))


def _draw_crowns(picture: Picture, scene: Scene, west_m: float, north_m: float) -> None:
    """Draw the crowns, low ones first: each with its shadow and a lit side."""
    forest = scene.forest
    rng = np.random.default_rng(scene.parameters.seed)
    tints = rng.normal(1.0, 0.08, (len(forest.height_m), 3))
    for tree in np.argsort(forest.height_m):
        radius_m = float(forest.crown_radius_m[tree])
        east_m, from_north_m = forest.trunk_enu_m[tree, 0] - west_m, north_m - forest.trunk_enu_m[tree, 1]
        green = (_CROWN * tints[tree]).clip(20.0, 200.0)
        for share, shift, brightness in ((1.0, 0.25, _SHADE), (1.0, 0.0, 1.0), (0.55, -0.28, _HIGHLIGHT)):
            middle_m = (east_m + shift * radius_m, from_north_m + shift * radius_m)
            _disc(picture, middle_m, share * radius_m, tuple((green * brightness).tolist()))


def _disc(picture: Picture, middle_m: tuple[float, float], radius_m: float, colour: tuple[float, ...]) -> None:
    scale = (1 << _SUB_PIXEL_BITS) / CELL_M
    centre = round(middle_m[0] * scale), round(middle_m[1] * scale)
    radius = max(1, round(radius_m * scale))
    cv2.circle(picture, centre, radius, colour, cv2.FILLED, cv2.LINE_AA, _SUB_PIXEL_BITS)


def _placed(picture: Picture, low_m: FloatArray, high_m: FloatArray, origin: GeodeticPosition) -> PictureSource:
    """Return a picture at its place; over some hundred metres degrees are linear in metres to a centimetre."""
    frame, middle_m = LocalFrame(origin), (low_m + high_m) / 2.0
    middle, east, north = (
        frame.to_geodetic((*(middle_m + shift_m), 0.0)) for shift_m in ((0.0, 0.0), (100.0, 0.0), (0.0, 100.0))
    )
    per_m = np.array(
        [
            [east.longitude_deg - middle.longitude_deg, north.longitude_deg - middle.longitude_deg],
            [east.latitude_deg - middle.latitude_deg, north.latitude_deg - middle.latitude_deg],
        ]
    )
    to_m = np.linalg.inv(per_m / 100.0)

    def to_pixels(longitude: FloatArray, latitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        across, up = longitude - middle.longitude_deg, latitude - middle.latitude_deg
        east_m = middle_m[0] + to_m[0, 0] * across + to_m[0, 1] * up
        north_m = middle_m[1] + to_m[1, 0] * across + to_m[1, 1] * up
        return (east_m - low_m[0]) / CELL_M - 0.5, (high_m[1] - north_m) / CELL_M - 0.5

    corners = [frame.to_geodetic((x, y, 0.0)) for x in (low_m[0], high_m[0]) for y in (low_m[1], high_m[1])]
    x, y = from_degrees(
        np.array([corner.longitude_deg for corner in corners]), np.array([corner.latitude_deg for corner in corners])
    )
    box = WorldBox(float(x.min()), float(y.min()), float(x.max()), float(y.max()))
    return PictureSource(picture, box, (box.east - box.west) / picture.shape[1], to_pixels)
