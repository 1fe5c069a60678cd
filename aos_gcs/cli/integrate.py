"""``aos-gcs integrate``: integral images of recorded flights."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
import typer

from aos_gcs.cli.autofocus_options import focal_height_m, focal_height_or_range
from aos_gcs.cli.files import check_writable, written_whole
from aos_gcs.cli.output import progress
from aos_gcs.cli.recordings import BANDS_OF_CHANNELS, read_frames, read_poses
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.integral import integrate_view
from aos_gcs.imaging.pictures import encode_png, shade_integral

MAX_SIZE_PX = 16_384

Item = TypeVar("Item")


def integrate(
    image_folder: Annotated[Path, typer.Argument(help="Folder with the recorded images.", show_default=False)],
    *,
    poses: Annotated[
        Path,
        typer.Option(help='JSON: {"images": [{"imagefile": NAME, "M3x4": ROWS}, ...]}, M3x4 from world to camera.'),
    ],
    fov: Annotated[float, typer.Option(metavar="DEG", help="Full horizontal field of view of the images, degrees.")],
    plane_z: Annotated[
        float | None, typer.Option(metavar="Z", help="The focal plane z = Z, in the world of the poses, metres.")
    ] = None,
    autofocus: Annotated[
        str | None,
        typer.Option(metavar="LOW,HIGH", help="Find the plane from z = LOW to HIGH that the view is in focus on."),
    ] = None,
    view: Annotated[
        int, typer.Option(metavar="INDEX", help="The virtual camera takes the pose of this entry of the poses, from 0.")
    ],
    out: Annotated[
        Path,
        typer.Option(metavar="FILE.npy", help="Integral: float32, NaN where no image covers; (H, W) or (H, W, 3)."),
    ],
    size: Annotated[int, typer.Option(help="Width and height of the integral, pixels.")] = 512,
    count: Annotated[
        Path | None, typer.Option(metavar="FILE.npy", help="Also write how many images cover each pixel: uint16.")
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png", help="Also write the integral as a picture with stretched contrast."),
    ] = None,
) -> None:
    """See through foliage: average recorded images on a focal plane, as one virtual camera sees it.

    Every image is projected to the plane z = Z of the poses' own world, whatever its axes are; what lies on the plane
    stays sharp, and what lies before it blurs away. The virtual camera has the field of view of the images.
    """
    outputs = [path for path in (out, count, png) if path is not None]
    _check(fov, size, outputs)
    focus = focal_height_or_range(plane_z, autofocus)
    views = read_poses(poses, image_folder)
    if not 0 <= view < len(views):
        raise ConfigurationError(f"--view {view} is out of range: {poses} has the views 0 to {len(views) - 1}.")
    fov_rad = math.radians(fov)
    camera = CameraModel.from_fov(size, size, fov_rad)
    plane_height_m = focal_height_m(focus, views, camera, views[view].pose)
    with progress("Integrating images", len(views)) as advance:
        frames = _counted(read_frames(views, fov_rad), advance)
        integral, coverage = integrate_view(frames, camera, views[view].pose, plane_height_m)
    bands = BANDS_OF_CHANNELS[integral.shape[2]]
    with written_whole(out) as file:
        np.save(file, integral[:, :, 0] if len(bands) == 1 else integral)
    if count is not None:
        with written_whole(count) as file:
            np.save(file, coverage)
    if png is not None:
        with written_whole(png) as file:
            file.write(encode_png(shade_integral(integral, bands)))


def _check(fov: float, size: int, outputs: list[Path]) -> None:
    if not 0.0 < fov < 180.0:
        raise ConfigurationError(f"--fov must lie between 0 and 180 degrees, got {fov:g}.")
    if not 1 <= size <= MAX_SIZE_PX:
        raise ConfigurationError(f"--size must lie between 1 and {MAX_SIZE_PX} pixels, got {size}.")
    if len({path.absolute() for path in outputs}) < len(outputs):
        raise ConfigurationError("--out, --count and --png must name different files.")
    for path in outputs:
        check_writable(path)


def _counted(items: Iterable[Item], advance: Callable[[int], None]) -> Iterator[Item]:
    for item in items:
        yield item
        # The consumer has come back for more: it is done with this one.
        advance(1)
