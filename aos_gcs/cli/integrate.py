"""``aos-gcs integrate``: integral images of recorded flights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.cli.files import check_writable, written_whole
from aos_gcs.cli.output import progress
from aos_gcs.cli.recordings import RecordedView, read_frames, read_poses, recorded_camera
from aos_gcs.cli.surface_options import FocusOptions, check_map_options, describe_map, focus_options, world_file
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.imaging.ground import choose_raster, covered_part
from aos_gcs.imaging.integral import ViewIntegral
from aos_gcs.imaging.model import GroundRaster
from aos_gcs.imaging.pictures import encode_png, shade_integral
from aos_gcs.imaging.views import FocalView, ortho_view, perspective_view

MAX_SIZE_PX = 16_384
DEFAULT_SIZE_PX = 512


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
    tilt: Annotated[
        str | None,
        typer.Option(
            metavar="NORTH_DEG,EAST_DEG",
            help="Tilt the plane: z grows by the tangents of these angles along y and along x, and is Z (or what "
            "autofocus finds) below the mean of all cameras.",
        ),
    ] = None,
    dem: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Focus on a terrain instead of a plane: .obj, .obj.gz or GeoTIFF (.tif)."),
    ] = None,
    dem_offset: Annotated[
        float | None, typer.Option(metavar="DZ", help="Shift the terrain by DZ along z, metres.", show_default="0")
    ] = None,
    dem_origin: Annotated[
        str | None,
        typer.Option(
            metavar="LAT,LON,ALT",
            help="Where the poses' world, x east, y north, z up, has its origin: places a GeoTIFF about it. Without, "
            "the GeoTIFF's own coordinates are those of the poses.",
        ),
    ] = None,
    view: Annotated[
        int | None,
        typer.Option(metavar="INDEX", help="The virtual camera takes the pose of this entry of the poses, from 0."),
    ] = None,
    ortho: Annotated[
        float | None,
        typer.Option(metavar="RES", help="A map instead of a view: all that is seen, seen along z, RES metres a cell."),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(metavar="FILE.npy", help="Integral: float32, NaN where no image covers; (H, W) or (H, W, 3)."),
    ],
    size: Annotated[
        int | None, typer.Option(help="Width and height of a view, pixels.", show_default=str(DEFAULT_SIZE_PX))
    ] = None,
    count: Annotated[
        Path | None, typer.Option(metavar="FILE.npy", help="Also write how many images cover each pixel: uint16.")
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png",
            help="Also write the integral as a picture with stretched contrast; with --ortho, and a world file .pgw.",
        ),
    ] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Single precision: several times faster.")] = False,
) -> None:
    """See through foliage: average recorded images on a focal surface, as one virtual camera sees it, or as a map.

    Every image is projected to the surface, given in the poses' own world, whatever its axes are; what lies on the
    surface stays sharp, and what lies before it blurs away. The virtual camera has the field of view of the images.
    """
    world = png.with_suffix(".pgw") if png is not None and ortho is not None else None
    _check(fov, size, [path for path in (out, count, png, world) if path is not None])
    check_map_options(ortho, view, size, autofocus=autofocus is not None)
    focus = focus_options(plane_z=plane_z, autofocus=autofocus, tilt=tilt, dem=dem, offset_m=dem_offset, at=dem_origin)
    views = read_poses(poses, image_folder)
    camera = recorded_camera(views[0], math.radians(fov))
    raster: GroundRaster | None = None
    target: FocalView
    if ortho is None:
        target = _virtual_view(views, _checked_view(view, views, poses), size, camera, focus)
    else:
        surface = focus.surface(views, camera, views[0].pose)
        raster = choose_raster([(camera, recorded.pose) for recorded in views], surface, ortho)
        target = ortho_view(raster, surface)
    integral, coverage, bands = _integrate(views, camera, target, exact=not fast)
    if raster is not None:
        raster, window = covered_part(raster, coverage)
        integral, coverage = integral[window], coverage[window]
        typer.echo(describe_map(raster), err=True)
    with written_whole(out) as file:
        np.save(file, integral[:, :, 0] if len(bands) == 1 else integral)
    if count is not None:
        with written_whole(count) as file:
            np.save(file, coverage)
    if png is not None:
        with written_whole(png) as file:
            file.write(encode_png(shade_integral(integral, bands)))
    if world is not None and raster is not None:
        with written_whole(world) as file:
            file.write(world_file(raster).encode("ascii"))


def _virtual_view(
    views: Sequence[RecordedView], index: int, size: int | None, recorded: CameraModel, focus: FocusOptions
) -> FocalView:
    edge_px = DEFAULT_SIZE_PX if size is None else size
    camera = CameraModel.from_fov(edge_px, edge_px, recorded.horizontal_fov_rad)
    pose = views[index].pose
    return perspective_view(camera, pose, focus.surface(views, camera, pose))


def _integrate(
    views: Sequence[RecordedView], camera: CameraModel, target: FocalView, *, exact: bool
) -> tuple[NDArray[np.float32], NDArray[np.uint16], tuple[str, ...]]:
    """Return the integral, its coverage and its bands; images that have no part in it are counted and told."""
    integral: ViewIntegral | None = None
    bands: tuple[str, ...] = ()
    unused: list[str] = []
    with progress("Integrating images", len(views)) as advance:
        for frame, recorded in zip(read_frames(views, camera.horizontal_fov_rad), views, strict=True):
            if integral is None:
                bands = frame.bands
                integral = ViewIntegral(target, bands, exact=exact)
            if not integral.add(frame):
                unused.append(recorded.path.name)
            advance(1)
    if integral is None or len(unused) == len(views):
        raise ConfigurationError(
            "No image sees any of the focal surface in this view: check its height, and that the surface is given in "
            "the world of the poses."
        )
    if unused:
        typer.echo(f"{len(unused)} of {len(views)} images see nothing of it, the first is {unused[0]}", err=True)
    return integral.mean(), integral.coverage, bands


def _checked_view(view: int | None, views: Sequence[RecordedView], poses: Path) -> int:
    if view is None or not 0 <= view < len(views):
        raise ConfigurationError(f"--view {view} is out of range: {poses} has the views 0 to {len(views) - 1}.")
    return view


def _check(fov: float, size: int | None, outputs: list[Path]) -> None:
    if not 0.0 < fov < 180.0:
        raise ConfigurationError(f"--fov must lie between 0 and 180 degrees, got {fov:g}.")
    if size is not None and not 1 <= size <= MAX_SIZE_PX:
        raise ConfigurationError(f"--size must lie between 1 and {MAX_SIZE_PX} pixels, got {size}.")
    if len({path.absolute() for path in outputs}) < len(outputs):
        raise ConfigurationError("--out, --count and --png must name different files.")
    for path in outputs:
        check_writable(path)
