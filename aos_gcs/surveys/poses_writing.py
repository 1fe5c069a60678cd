"""Poses files as they are written: of images whose poses are known, and of corrected ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.conventions import PoseConvention
from aos_gcs.surveys.poses_file import INTRINSICS, LENSES, SIZE, read_document


def poses_document(
    images: Sequence[tuple[str, Pose, float | None]],
    origin: GeodeticPosition | None = None,
    camera: CameraModel | None = None,
) -> dict[str, object]:
    """Return the document that ``read_poses`` reads.

    Args:
        images: names, poses and times (s) of the images; None: a time that is not known.
        origin: origin of their world, where that is east-north-up.
        camera: camera of all images, where the document is to describe it.
    """
    entries: list[dict[str, object]] = []
    for name, pose, time_s in images:
        R_world2cam = pose.R_cam2enu.T
        M = np.column_stack([R_world2cam, -R_world2cam @ pose.position_enu_m])
        when = {} if time_s is None else {"time_s": round(time_s, 6)}
        entries.append({"imagefile": name, **when, "M3x4": M.tolist()})
    place = {} if origin is None else {"origin": [origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m]}
    described = {} if camera is None else _described(camera)
    return {**described, **place, "images": entries}


def _described(camera: CameraModel) -> dict[str, object]:
    """Return the fields of a camera."""
    fields: dict[str, object] = {name: getattr(camera, f"{name}_px") for name in (*INTRINSICS, *SIZE)}
    if camera.distortion is not None:
        name = next(name for name, model in LENSES.items() if model is camera.distortion.model)
        fields[name] = list(camera.distortion.coefficients)
    return fields


def corrected_document(
    poses_file: Path, image_folder: Path, images: Sequence[tuple[Path, Pose]], convention: PoseConvention
) -> dict[str, object]:
    """Return a copy of a poses file's document with the poses of some of its images replaced.

    Args:
        poses_file: file that the images were read with.
        image_folder: folder of the images.
        images: files and new poses; other entries stay as they are.
        convention: meaning of the file's matrices.

    Raises:
        InputDataError: if the file cannot be read any more.
    """
    document = read_document(poses_file)
    named = {path.relative_to(image_folder): pose for path, pose in images}
    by_stem = {path.with_suffix(""): pose for path, pose in named.items()}
    entries = []
    for entry in document["images"]:
        name = Path(entry["imagefile"])
        pose = named.get(name) or by_stem.get(name.with_suffix(""))
        entries.append(entry if pose is None else {**entry, "M3x4": convention.matrix(pose).tolist()})
    return {**document, "images": entries}
