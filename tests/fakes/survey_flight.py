"""A small flight over a textured ground, as DJI's photographs."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyproj
import rasterio
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition, LocalFrame
from aos_gcs.geometry.poses import Pose, nadir_pose
from aos_gcs.geometry.projection import intersect_plane
from tests.fakes.photographs import exif_block, write_photograph, xmp_packet

TAKEOFF = GeodeticPosition(48.3069, 14.2858, 310.0)
HEIGHT_M = 20.0
SIZE = (96, 72)
FOCAL_35MM = 28
FOCAL_PX = FOCAL_35MM / math.hypot(36, 24) * math.hypot(*SIZE)
CAMERA = CameraModel.from_fov(*SIZE, 2 * math.atan(SIZE[0] / 2 / FOCAL_PX))
HOT_M = (3.0, 4.0)


def write_flat_terrain(path: Path, height_m: float = TAKEOFF.altitude_amsl_m) -> Path:
    """Write a GeoTIFF of level ground around the flight."""
    crs, cell_m, count = "EPSG:32633", 5.0, 60
    easting_m, northing_m = pyproj.Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(
        TAKEOFF.longitude_deg, TAKEOFF.latitude_deg
    )
    half_m = cell_m * count / 2.0
    transform = rasterio.Affine(cell_m, 0.0, easting_m - half_m, 0.0, -cell_m, northing_m + half_m)
    profile = {"driver": "GTiff", "width": count, "height": count, "count": 1, "dtype": "float32", "crs": crs}
    with rasterio.open(path, "w", transform=transform, **profile) as dataset:
        dataset.write(np.full((count, count), height_m, dtype=np.float32), 1)
    return path


def texture(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    return 120 + 40 * np.sin(0.5 * x) * np.cos(0.4 * y)


def render(pose: Pose, camera: CameraModel, hot: bool = False) -> NDArray[np.uint8]:
    u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
    x, y, _ = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, 0.0).T
    values = texture(x, y)
    if hot:
        # Weak texture: against a strong one nothing stands out.
        values = 100.0 + (values - 120.0) / 8.0
        values[np.hypot(x - HOT_M[0], y - HOT_M[1]) < 0.2] = 255.0
    return np.round(values).astype(np.uint8).reshape(v.shape)


class Photographs:
    """The photographs of the flight, written into a folder, and arguments for commands that use them."""

    def __init__(self, folder: Path, *, hot: bool = False, camera: CameraModel = CAMERA) -> None:
        self.images = folder / "photographs"
        self.images.mkdir()
        self.out = folder / "map.tif"
        self.tags: dict[str, dict[str, Any]] = {}
        frame = LocalFrame(TAKEOFF)
        for index in range(6):
            # The first photograph's place is the origin of the map.
            position = np.array([4.0 * index, 3.0 * (index % 2), HEIGHT_M])
            yaw_deg = 25.0 * index
            place = frame.to_geodetic(position)
            tags = {
                "drone-dji:GpsLatitude": f"{place.latitude_deg:.9f}",
                "drone-dji:GpsLongitude": f"{place.longitude_deg:.9f}",
                "drone-dji:AbsoluteAltitude": f"{place.altitude_amsl_m:.3f}",
                "drone-dji:RelativeAltitude": f"+{HEIGHT_M:.3f}",
                "drone-dji:GimbalYawDegree": yaw_deg,
                "drone-dji:GimbalPitchDegree": -90.0,
                "drone-dji:GimbalRollDegree": 0.0,
            }
            image = render(nadir_pose(position, math.radians(yaw_deg)), camera, hot)
            self.write(f"{index}.jpg", image, tags)

    def write(self, name: str, image: NDArray[np.uint8], tags: dict[str, Any]) -> None:
        self.tags[name] = tags
        write_photograph(self.images / name, image, exif_block(camera={0xA405: FOCAL_35MM}), xmp_packet(tags))

    def strip(self, name: str, *names: str) -> None:
        """Write a photograph again without some tags."""
        image = cv2.imread(str(self.images / name), cv2.IMREAD_UNCHANGED)
        left = {tag: value for tag, value in self.tags[name].items() if tag.partition(":")[2] not in names}
        self.write(name, np.asarray(image, dtype=np.uint8), left)

    def change(self, name: str, **values: object) -> None:
        """Write a photograph again with other values of some of DJI's tags."""
        image = cv2.imread(str(self.images / name), cv2.IMREAD_UNCHANGED)
        changed = {f"drone-dji:{tag}": value for tag, value in values.items()}
        self.write(name, np.asarray(image, dtype=np.uint8), self.tags[name] | changed)

    def raise_takeoff(self, names: Iterable[str], by_m: float) -> None:
        """Write photographs again as those of a flight from a higher place, at the same altitude."""
        for name in names:
            self.change(name, RelativeAltitude=f"+{HEIGHT_M - by_m:.3f}")

    def arguments(self, *options: object) -> list[str]:
        return ["integrate", str(self.images), "--out", str(self.out), *map(str, options)]
