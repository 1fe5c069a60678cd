"""Image files of a mission's frames, written before the rows that name them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

import numpy as np

from aos_gcs.geometry.rotations import quaternion_from_R
from aos_gcs.ports import Capture
from aos_gcs.store.codec import dump
from aos_gcs.store.images import encode_image
from aos_gcs.store.lasting_files import replace_file, sync_names
from aos_gcs.store.schema import FRAMES_NAME


@dataclass(frozen=True, slots=True)
class FrameRow:
    """A frame whose image file is on the disk, as the table of frames has it."""

    values: tuple[object, ...]
    """Values in the order of the columns."""


def write_frames(folder: Path, frames: Sequence[tuple[int, Capture]]) -> list[FrameRow | Exception]:
    """Write the image files of frames, given with their steps; return the row of each, or why it is lost.

    The files and their names are on the disk then, so that no row lacks its file after a loss of power.
    """
    rows = [_written(folder / FRAMES_NAME, step, frame) for step, frame in frames]
    try:
        sync_names(folder / FRAMES_NAME)
    except OSError as error:
        return [error] * len(rows)
    return rows


def _written(folder: Path, step: int, frame: Capture) -> FrameRow | Exception:
    try:
        return _write(folder, step, frame)
    except Exception as error:  # whatever it is: the frame is lost, and counted
        return error


def _write(folder: Path, step: int, frame: Capture) -> FrameRow:
    encoded = encode_image(frame.image, frame.bands)
    name = f"{step:05d}_{frame.vehicle_id:03d}_{frame.image_index:05d}{encoded.suffix}"
    replace_file(folder / name, encoded.content, is_lasting=True)
    return FrameRow(
        (
            step,
            frame.vehicle_id,
            frame.image_index,
            frame.utc_s,
            frame.time_sigma_s,
            frame.position.latitude_deg,
            frame.position.longitude_deg,
            frame.position.altitude_amsl_m,
            dump(quaternion_from_R(frame.R_cam2enu).tolist()),
            dump(frame.R_cam2enu.tolist()),
            dump(frame.camera),
            dump(frame.bands),
            frame.image.dtype.name,
            f"{FRAMES_NAME}/{name}",
            frame_digest(frame),
        )
    )


def frame_digest(frame: Capture) -> str:
    """Return a text that is the same for the same pixels, pose and camera and differs for others, 32 characters."""
    pose = dump((frame.position, frame.R_cam2enu, frame.camera, frame.bands, frame.image.dtype.str, frame.image.shape))
    digest = blake2b(np.ascontiguousarray(frame.image).data, digest_size=16)
    digest.update(pose.encode())
    return digest.hexdigest()
