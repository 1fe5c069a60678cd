"""A small rendered recording, and the command line that integrates it."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.geometry.projection import intersect_plane

FOV_DEG = 50.0
PLANE_Z = 12.0

Document = dict[str, list[dict[str, Any]]]


def texture(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return 120 + 60 * np.sin(0.9 * points[:, 0]) * np.cos(0.7 * points[:, 1])


class Flight:
    """A small recording in a world with z down: the cameras look along +z at a textured plane."""

    def __init__(self, folder: Path) -> None:
        self.images = folder / "images"
        self.images.mkdir()
        self.poses = folder / "poses.json"
        self.out = folder / "integral.npy"
        self.camera = CameraModel.from_fov(60, 60, np.radians(FOV_DEG))
        self.document: Document = {"images": []}
        for index, x in enumerate((-1.0, -0.3, 0.4, 1.0)):
            centre = np.array([x, 0.2 * x, -10.0])
            R_world2cam = cv2.Rodrigues(np.array([0.02 * index, 0.05, 0.3]))[0]
            image = self.render(Pose(centre, R_world2cam.T))
            cv2.imwrite(str(self.images / f"{index}.png"), np.round(image).astype(np.uint8))
            rows = np.column_stack((R_world2cam, -R_world2cam @ centre)).tolist()
            rows[0][0] = str(rows[0][0])
            self.document["images"].append({"imagefile": f"{index}.png", "M3x4": rows})
        self.save()

    def save(self) -> None:
        self.poses.write_text(json.dumps(self.document))

    def render(self, pose: Pose, size: int = 60, camera: CameraModel | None = None) -> NDArray[np.float64]:
        camera = camera or CameraModel.from_fov(size, size, np.radians(FOV_DEG))
        u, v = np.meshgrid(np.arange(camera.width_px), np.arange(camera.height_px))
        points = intersect_plane(np.stack((u.ravel(), v.ravel()), axis=1), camera, pose, PLANE_Z)
        return texture(points).reshape(u.shape)

    def pose(self, index: int) -> Pose:
        M = np.array(self.document["images"][index]["M3x4"], dtype=float)
        return Pose(-M[:, :3].T @ M[:, 3], M[:, :3].T)

    def arguments(self, **options: object) -> list[str]:
        values: dict[str, object] = {
            "--poses": self.poses,
            "--fov": FOV_DEG,
            "--plane-z": PLANE_Z,
            "--view": 1,
            "--size": 48,
            "--out": self.out,
        }
        values |= {"--" + name.replace("_", "-"): value for name, value in options.items()}
        # None leaves an option out, True gives it as a flag.
        given = [(name,) if value is True else (name, value) for name, value in values.items() if value is not None]
        return ["integrate", str(self.images), *(str(item) for option in given for item in option)]
