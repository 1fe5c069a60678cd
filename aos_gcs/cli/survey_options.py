"""Recording of ``aos-gcs integrate``: options for the poses and the camera of the images."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.photos import read_photos
from aos_gcs.surveys.poses_file import parse_lens, read_poses

PANEL = "Recording"

ImageFolder = Annotated[Path, typer.Argument(help="Folder with the recorded images.", show_default=False)]
Poses = Annotated[
    Path | None,
    typer.Option(
        help='JSON: {"images": [{"imagefile": NAME, "M3x4": ROWS}, ...]}, M3x4 from world to camera. Without it, '
        "the images are JPEG photographs with positions in their metadata.",
        rich_help_panel=PANEL,
    ),
]
Fov = Annotated[
    float | None,
    typer.Option(
        metavar="DEG",
        help="Full horizontal field of view of the images, degrees. Photographs contain it.",
        rich_help_panel=PANEL,
    ),
]
Lens = Annotated[
    str | None,
    typer.Option(metavar="K1,K2,P1,P2[,K3]", help="Distortion of the lens (Brown-Conrady).", rich_help_panel=PANEL),
]
Fisheye = Annotated[
    str | None,
    typer.Option(metavar="K1,K2,K3,K4", help="Distortion of a fisheye lens (equidistant).", rich_help_panel=PANEL),
]
Origin = Annotated[
    str | None,
    typer.Option(
        metavar="LAT,LON[,ALT]",
        help="Origin of the poses' world (x east, y north, z up): georeferences the map, and places a GeoTIFF terrain. "
        "Without ALT, z are altitudes above sea level.",
        rich_help_panel=PANEL,
    ),
]
Ground = Annotated[
    float | None,
    typer.Option(
        metavar="ALT",
        help="Altitude of the ground below photographs, in their own altitude reference: z = 0. Without it, z = 0 is "
        "the place of takeoff.",
        rich_help_panel=PANEL,
    ),
]
SkipBroken = Annotated[
    bool,
    typer.Option(
        "--skip-broken",
        help="Skip images that cannot be read, instead of stopping at the first.",
        rich_help_panel=PANEL,
    ),
]


def open_survey(
    folder: Path,
    *,
    poses: Path | None,
    fov_deg: float | None,
    lens: str | None,
    fisheye: str | None,
    origin: str | None,
    ground_amsl_m: float | None,
    skip_broken: bool,
) -> Survey:
    """Open a recording; the number of skipped images is printed on standard error.

    Raises:
        ConfigurationError: if options are not valid, or do not go together.
        InputDataError: if the recording is unreadable, or nothing of it can be used.
    """
    if fov_deg is not None and not 0.0 < fov_deg < 180.0:
        raise ConfigurationError(f"--fov must lie between 0 and 180 degrees, got {fov_deg:g}.")
    fov_rad = None if fov_deg is None else math.radians(fov_deg)
    distortion = _distortion(lens, fisheye)
    if poses is not None:
        if fov_rad is None:
            raise ConfigurationError("--poses needs the field of view of the images: give it as --fov DEG.")
        if ground_amsl_m is not None:
            raise ConfigurationError("--ground applies to photographs with their own positions, not to --poses.")
        place = None if origin is None else _origin(origin)
        survey = read_poses(poses, folder, fov_rad, lens=distortion, origin=place, skip_broken=skip_broken)
    else:
        if origin is not None:
            raise ConfigurationError("--origin applies to --poses: photographs have positions in their metadata.")
        if ground_amsl_m is not None and not math.isfinite(ground_amsl_m):
            raise ConfigurationError(f"--ground must be a finite number of metres, got {ground_amsl_m}.")
        survey = read_photos(folder, ground_amsl_m=ground_amsl_m, horizontal_fov_rad=fov_rad, lens=distortion)
    report_skipped(len(survey.images) + len(survey.left_out), survey.left_out)
    return survey


def parse_numbers(text: str) -> list[float]:
    """Return numbers parted by commas; none at all unless all of them are finite."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return []
    return numbers if all(math.isfinite(number) for number in numbers) else []


def report_skipped(total: int, reasons: Mapping[str, str]) -> None:
    """Print on standard error how many images are skipped, and why the first."""
    if reasons:
        name, reason = next(iter(reasons.items()))
        typer.echo(f"{len(reasons)} of {total} images are skipped; {name}: {reason}", err=True)


def _distortion(lens: str | None, fisheye: str | None) -> LensDistortion | None:
    if lens is not None and fisheye is not None:
        raise ConfigurationError("--lens and --fisheye exclude each other: a camera has one of them.")
    if lens is not None:
        return parse_lens(LensModel.BROWN_CONRADY, [*lens.split(",")], "--lens")
    return None if fisheye is None else parse_lens(LensModel.FISHEYE, [*fisheye.split(",")], "--fisheye")


def _origin(text: str) -> GeodeticPosition:
    """Return a position; at sea level where no altitude is given."""
    numbers = parse_numbers(text)
    if len(numbers) not in (2, 3) or not (abs(numbers[0]) <= 90.0 and abs(numbers[1]) <= 180.0):
        raise ConfigurationError(f"--origin needs LATITUDE,LONGITUDE[,ALTITUDE] in degrees and metres, got {text!r}.")
    return GeodeticPosition(numbers[0], numbers[1], numbers[2] if len(numbers) == 3 else 0.0)
