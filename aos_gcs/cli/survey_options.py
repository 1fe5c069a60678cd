"""Recording of ``aos-gcs integrate``: options for the poses and the camera of the images."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer

from aos_gcs.cameras.calibration import Calibration, read_calibration, warning
from aos_gcs.cameras.intrinsics import Intrinsics, parse_lens
from aos_gcs.cameras.lens_files import read_lens_file
from aos_gcs.errors import ConfigurationError
from aos_gcs.geometry.distortion import LensDistortion, LensModel
from aos_gcs.geometry.geodesy import GeodeticPosition
from aos_gcs.geometry.heights import SEA_LEVEL, AmslM
from aos_gcs.geotags.sensors import Sensor
from aos_gcs.input_values import finite_numbers, printable
from aos_gcs.surveys.conventions import NAMES, PoseConvention, parse_convention
from aos_gcs.surveys.model import Survey, SurveyImage
from aos_gcs.surveys.photos import read_photos
from aos_gcs.surveys.poses_file import MAX_ALTITUDE_M, is_place, read_poses
from aos_gcs.surveys.radiometric.dji import find_library
from aos_gcs.surveys.radiometric.settings import MeasurementConditions, TemperatureSettings

PANEL = "Recording"

MIN_FOV_DEG, MAX_FOV_DEG = 0.1, 170.0
"""Fields of view of cameras, with some room: beyond them pictures show next to nothing, or all up to the horizon."""
_MAX_DIGITS = 9
"""Most digits of the number of an image."""

ImageFolder = Annotated[Path, typer.Argument(help="Folder with the recorded images.", show_default=False)]
Poses = Annotated[
    Path | None,
    typer.Option(
        help='JSON: {"images": [{"imagefile": NAME, "M3x4": ROWS}, ...]}, M3x4 from world to camera. Without it, '
        "the images are photographs (JPEG, else TIFF) with positions in their metadata.",
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
Camera = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Camera file instead of --fov: OpenCV or ROS (YAML, XML, JSON), OpenDroneMap (cameras.json).",
        rich_help_panel=PANEL,
    ),
]
CalibrationFile = Annotated[
    Path | None,
    typer.Option(
        "--calibration",
        metavar="FILE",
        help="Result of aos-gcs calibrate: camera, mount and clock offset.",
        rich_help_panel=PANEL,
    ),
]
Convention = Annotated[
    str | None,
    typer.Option(
        metavar="NAMES",
        help=f"Meaning of the poses, names separated by commas: {', '.join(NAMES)}. With the axes of the world named, "
        "poses are turned to x east, y north, z up.",
        show_default="world-to-camera,opencv",
        rich_help_panel=PANEL,
    ),
]
FrameRange = Annotated[
    str | None,
    typer.Option(
        "--frames",
        metavar="A:B[:STEP]",
        help="Range of images to use, counted from 0 in the order of the poses file or of the names: from A up to, but "
        "not including, B, in steps of STEP.",
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
SensorName = Annotated[
    Sensor | None,
    typer.Option(
        "--sensor",
        help="Sensor whose photographs are used, where a folder has those of several.",
        rich_help_panel=PANEL,
    ),
]
Degrees = Annotated[
    str | None,
    typer.Option(
        "--degrees",
        metavar="SETTINGS",
        help="Read the temperatures of radiometric photographs of FLIR and DJI, degrees Celsius. SETTINGS are "
        "'recorded', or replace what the camera was set to: emissivity=0.97,distance=20,humidity=0.6,reflected=5,"
        "air=12 (metres, share, degrees Celsius).",
        rich_help_panel=PANEL,
    ),
]
DjiSdk = Annotated[
    Path | None,
    typer.Option(
        "--dji-sdk",
        metavar="DIR",
        help="Folder of DJI's Thermal SDK for Linux, by which --degrees reads the photographs of DJI.",
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


@dataclass(frozen=True, slots=True)
class CameraOptions:
    """Camera of a recording as given by the options."""

    fov_deg: float | None = None
    camera: Path | None = None
    lens: str | None = None
    fisheye: str | None = None
    calibration: Path | None = None

    def read(self) -> tuple[float | Intrinsics | None, LensDistortion | None, Calibration | None]:
        """Return the field of view (rad) or the intrinsics, the lens that replaces theirs, and the calibration.

        Raises:
            ConfigurationError: if a value is not valid, or options exclude each other.
            InputDataError: if a file cannot be used.
        """
        if self.calibration is None:
            return _optics(self.fov_deg, self.camera), _distortion(self.lens, self.fisheye), None
        others = (
            ("--fov", self.fov_deg),
            ("--camera", self.camera),
            ("--lens", self.lens),
            ("--fisheye", self.fisheye),
        )
        for name, value in others:
            if value is not None:
                raise ConfigurationError(f"--calibration and {name} exclude each other: it contains the camera.")
        calibration = read_calibration(self.calibration)
        doubtful = warning(calibration, self.calibration)
        if doubtful is not None:
            typer.echo(doubtful, err=True)
        return calibration.intrinsics, None, calibration


def open_survey(
    folder: Path,
    *,
    poses: Path | None,
    optics: CameraOptions,
    origin: str | None = None,
    convention: str | None = None,
    frames: str | None = None,
    ground_amsl_m: float | None = None,
    sensor: Sensor | None = None,
    degrees: str | None = None,
    dji_sdk: Path | None = None,
    skip_broken: bool = False,
    on_terrain: bool = False,
) -> Survey:
    """Open a recording; the number of skipped images is printed on standard error.

    Raises:
        ConfigurationError: if options are not valid, or do not go together.
        InputDataError: if the recording is unreadable, or nothing of it can be used.
    """
    camera, lens, calibration = optics.read()
    chosen = slice(None) if frames is None else _frames(frames)
    if dji_sdk is not None and degrees is None:
        raise ConfigurationError("--dji-sdk requires --degrees.")
    if poses is not None:
        if ground_amsl_m is not None:
            raise ConfigurationError("--ground applies to photographs with their own positions, not to --poses.")
        if sensor is not None:
            raise ConfigurationError("--sensor applies to photographs whose tags name their sensor, not to --poses.")
        survey = read_poses(
            poses,
            folder,
            camera,
            lens=lens,
            origin=None if origin is None else _origin(origin),
            convention=PoseConvention() if convention is None else parse_convention(convention),
            frames=chosen,
            temperatures=_temperatures(degrees, dji_sdk),
            skip_broken=skip_broken,
        )
    else:
        for name, value in (("--origin", origin), ("--convention", convention)):
            if value is not None:
                raise ConfigurationError(f"{name} applies to --poses: photographs have positions in their metadata.")
        if ground_amsl_m is not None and not abs(ground_amsl_m) <= MAX_ALTITUDE_M:
            raise ConfigurationError(
                f"--ground must lie between {-MAX_ALTITUDE_M:,.0f} and {MAX_ALTITUDE_M:,.0f} m, got {ground_amsl_m:g}."
            )
        survey = read_photos(
            folder,
            ground_amsl_m=ground_amsl_m,
            optics=camera,
            lens=lens,
            sensor=sensor,
            frames=chosen,
            temperatures=_temperatures(degrees, dji_sdk),
            on_terrain=on_terrain,
        )
    report_skipped(len(survey.images) + len(survey.left_out), list(survey.left_out.items()))
    for remark in (*survey.warnings, *survey.remarks):
        typer.echo(printable(remark), err=True)
    if survey.without_pose:
        count, first = len(survey.without_pose), survey.without_pose[0]
        text = f"{count} images of the folder have no pose and take no part; the first is {first}"
        typer.echo(printable(text), err=True)
    return survey if calibration is None else _calibrated(survey, calibration)


def _calibrated(survey: Survey, calibration: Calibration) -> Survey:
    """Return a survey with the poses of a calibrated mount and clock."""
    images: Sequence[SurveyImage] = survey.images
    if calibration.clock_offset_s:
        from aos_gcs.surveys.motion import moved  # noqa: PLC0415 - keeps the help fast

        shifted = moved(images, calibration.clock_offset_s)
        if shifted is None:
            typer.echo("The clock offset of the calibration is not applied: the images have no times.", err=True)
        images = shifted or images
    return replace(survey, images=tuple(replace(image, pose=calibration.pose(image.pose)) for image in images))


def report_skipped(total: int, reasons: Sequence[tuple[str, str]]) -> None:
    """Print on standard error how many images are skipped, and why the first; names and reasons are given."""
    if reasons:
        name, reason = reasons[0]
        typer.echo(printable(f"{len(reasons)} of {total} images are skipped; {name}: {reason}"), err=True)


def _optics(fov_deg: float | None, camera: Path | None) -> float | Intrinsics | None:
    """Return the field of view in radians, or the intrinsics of a camera file."""
    if fov_deg is not None and not MIN_FOV_DEG <= fov_deg <= MAX_FOV_DEG:
        raise ConfigurationError(
            f"--fov must lie between {MIN_FOV_DEG:g} and {MAX_FOV_DEG:g} degrees, got {fov_deg:g}."
        )
    if camera is None:
        return None if fov_deg is None else math.radians(fov_deg)
    if fov_deg is not None:
        raise ConfigurationError("--camera and --fov exclude each other: the camera file has the focal lengths.")
    return read_lens_file(camera)


def _frames(text: str) -> slice:
    """Return a range of images."""
    parts = text.split(":")
    numbers = [int(part) if _is_count(part) else None for part in parts]
    is_valid = len(parts) in (2, 3) and all(_is_count(part) or not part for part in parts)
    start, stop, step = (*numbers, None, None)[:3]
    if not is_valid or step == 0 or (stop is not None and stop <= (start or 0)):
        raise ConfigurationError(f"--frames needs a range A:B[:STEP] of images counted from 0, got {text!r}.")
    return slice(start, stop, step)


def _is_count(text: str) -> bool:
    return text.isdecimal() and len(text) <= _MAX_DIGITS


_SCENE = {
    "emissivity": ("emissivity", 0.01, 1.0),
    "distance": ("distance_m", 0.0, 10_000.0),
    "humidity": ("humidity", 0.0, 1.0),
    "reflected": ("reflected_c", -100.0, 100.0),
    "air": ("air_c", -60.0, 60.0),
}
"""Settings of ``--degrees``: field, least and largest value."""


def _temperatures(degrees: str | None, dji_sdk: Path | None) -> TemperatureSettings | None:
    if degrees is None:
        return None
    return TemperatureSettings(_conditions(degrees), None if dji_sdk is None else find_library(dji_sdk))


def _conditions(text: str) -> MeasurementConditions:
    """Return the conditions under which temperatures are read."""
    values: dict[str, float] = {}
    for part in [] if text.strip() == "recorded" else text.split(","):
        name, _, value = part.partition("=")
        if name.strip() not in _SCENE:
            raise ConfigurationError(f"--degrees needs 'recorded' or NAME=VALUE of {', '.join(_SCENE)}, got {part!r}.")
        field, least, most = _SCENE[name.strip()]
        if field in values:
            raise ConfigurationError(f"--degrees gives {name.strip()} twice: leave one out.")
        number = finite_numbers(value)
        if len(number) != 1 or not least <= number[0] <= most:
            raise ConfigurationError(
                f"--degrees: {name.strip()} must lie between {least:g} and {most:g}, got {value!r}."
            )
        values[field] = number[0]
    return MeasurementConditions(**values)


def _distortion(lens: str | None, fisheye: str | None) -> LensDistortion | None:
    if lens is not None and fisheye is not None:
        raise ConfigurationError("--lens and --fisheye exclude each other: a camera has one of them.")
    if lens is not None:
        return parse_lens(LensModel.BROWN_CONRADY, [*lens.split(",")], "--lens")
    return None if fisheye is None else parse_lens(LensModel.FISHEYE, [*fisheye.split(",")], "--fisheye")


def _origin(text: str) -> GeodeticPosition:
    """Return a position; at sea level where no altitude is given."""
    numbers = finite_numbers(text)
    if len(numbers) not in (2, 3) or not is_place(*numbers):
        raise ConfigurationError(f"--origin needs LATITUDE,LONGITUDE[,ALTITUDE] in degrees and metres, got {text!r}.")
    return GeodeticPosition(numbers[0], numbers[1], AmslM(numbers[2]) if len(numbers) == 3 else SEA_LEVEL)
