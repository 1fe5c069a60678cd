"""``aos-gcs calibrate``: camera, mount and clock, or poses, from a recorded flight above textured ground."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from aos_gcs.cameras.calibration import PARAMETERS, calibration_document, encode_calibration
from aos_gcs.cli import survey_options
from aos_gcs.cli.output import progress
from aos_gcs.cli.survey_options import CameraOptions, open_survey
from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.exports.files import check_apart, check_suffix, check_writable, written_whole
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import Pose
from aos_gcs.surveys.conventions import PoseConvention, parse_convention
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.poses_writing import corrected_document, poses_document

if TYPE_CHECKING:
    from aos_gcs.surveys.calibration.calibrate import Result

PANEL = "Calibration"

MAX_ERROR_SIGMAS = 1.3
"""Root mean square of the errors of recorded poses, in their standard deviations, from which these are doubted."""

MIN_GAIN = 0.1
"""Share by which the residual in images that took no part must fall. Drifting positions feign some per cent."""

_LARGE_GAIN = 0.5
"""The same, from which values far from the given ones are borne out."""
_ALIKE_FOCAL = 0.001
"""Share by which focal lengths of one camera differ at most."""
_LABELS = ("yaw", "pitch", "roll", "focal length", "k1", "k2", "clock offset")
_DIGITS = ("{:.3f}°", "{:.3f}°", "{:.3f}°", "{:.2f} px", "{:.5f}", "{:.5f}", "{:.4f} s")


def calibrate(
    image_folder: survey_options.ImageFolder,
    *,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Camera, mount and clock, for integrate --calibration and for the cameras of missions.",
            rich_help_panel=PANEL,
        ),
    ] = None,
    poses_out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Copy of --poses, or poses of photographs, with the errors corrected that differ from one image to "
            "the next; camera and mount stay as they are given.",
            rich_help_panel=PANEL,
        ),
    ] = None,
    poses: survey_options.Poses = None,
    fov: survey_options.Fov = None,
    camera: survey_options.Camera = None,
    lens: survey_options.Lens = None,
    fisheye: survey_options.Fisheye = None,
    convention: survey_options.Convention = None,
    frames: survey_options.FrameRange = None,
    ground: survey_options.Ground = None,
    sensor: survey_options.SensorName = None,
    position_sigma: Annotated[
        float,
        typer.Option(
            metavar="M",
            help="Standard deviation of the recorded positions from one image to the next, metres: 0.02 for RTK. "
            "Tags of photographs that contain it take precedence.",
            rich_help_panel=PANEL,
        ),
    ] = 0.15,
    position_drift: Annotated[
        float,
        typer.Option(
            metavar="M",
            help="Standard deviation of the drift that recorded positions share with their neighbours, metres: 2 for "
            "receivers without corrections. For --out; positions whose tags contain their accuracy do not drift.",
            rich_help_panel=PANEL,
        ),
    ] = 0.0,
    attitude_sigma: Annotated[
        float,
        typer.Option(
            metavar="DEG",
            help="Standard deviation of the recorded attitudes from one image to the next, degrees.",
            rich_help_panel=PANEL,
        ),
    ] = 0.2,
    force: Annotated[
        bool,
        typer.Option(
            "--force",
            help="Write --out even if the result is doubtful; the file records the doubts, and its users are warned.",
            rich_help_panel=PANEL,
        ),
    ] = False,
) -> None:
    """Calibrate a camera by a flight: mount angles, focal length, lens and clock offset, with their covariance.

    Needs images that overlap by 60 % and poses in any world; for the clock offset and the roll of the mount, lines in
    opposite and crossing directions and images with times; for the focal length, two heights. What the flight does not
    tell stays as it was, and is named. The result is tried on images left out of the fit; where it describes them no
    better, or is doubtful otherwise, it is not written. --poses-out corrects poses instead, or beside it, by what
    neighbours show.
    """
    for name, value in (("--position-sigma", position_sigma), ("--attitude-sigma", attitude_sigma)):
        if not (math.isfinite(value) and value > 0.0):
            raise ConfigurationError(f"{name} must be a positive number, got {value:g}.")
    if not (math.isfinite(position_drift) and position_drift >= 0.0):
        raise ConfigurationError(f"--position-drift must be a number of at least 0, got {position_drift:g}.")
    _check_outputs(out, poses_out, poses, camera)
    survey = open_survey(
        image_folder,
        poses=poses,
        optics=CameraOptions(fov, camera, lens, fisheye),
        convention=convention,
        frames=frames,
        ground_amsl_m=ground,
        sensor=sensor,
    )
    sigmas = position_sigma, attitude_sigma
    # First, as it does not depend on whether the calibration is doubtful.
    if poses_out is not None:
        if poses is None:
            document = _photographs_document(image_folder, survey, sigmas)
        else:
            images = list(zip([image.path for image in survey.images], _refine(survey, sigmas), strict=True))
            meaning = PoseConvention() if convention is None else parse_convention(convention)
            document = corrected_document(poses, image_folder, images, meaning)
        with written_whole(poses_out) as file:
            file.write(json.dumps(document).encode())
    if out is not None:
        _calibrate(survey, sigmas, position_drift, out, force=force)


def _check_outputs(out: Path | None, poses_out: Path | None, poses: Path | None, camera: Path | None) -> None:
    if out is None and poses_out is None:
        raise ConfigurationError("Nothing to write: give --out FILE.json, --poses-out FILE.json, or both.")
    outputs = {"--out": out, "--poses-out": poses_out}
    for option, path in outputs.items():
        if path is not None:
            check_writable(path)
            check_suffix(option, path, ".json")
    check_apart(
        [path for path in outputs.values() if path is not None],
        None,
        [path for path in (poses, camera) if path is not None],
    )


def _calibrate(survey: Survey, sigmas: tuple[float, float], drift_m: float, out: Path, *, force: bool) -> None:
    """Write camera, mount and clock of a survey, by standard deviations of positions (m) and attitudes (deg).

    Raises:
        InputDataError: if the result is doubtful, unless forced.
    """
    from aos_gcs.surveys.calibration.calibrate import (  # noqa: PLC0415 - keeps the other commands' help fast
        MAX_IMAGES,
        calibrate,
    )

    with progress("Searching images for features", min(MAX_IMAGES, len(survey.images))) as advance:
        result = calibrate(survey, sigmas[0], math.radians(sigmas[1]), drift_m, advance)
    degrees = np.array([math.degrees(1.0)] * 3 + [1.0] * 4)
    covariance = result.covariance * np.outer(degrees, degrees)
    lens_now = result.camera.distortion
    k1, k2 = (0.0, 0.0) if lens_now is None else lens_now.coefficients[:2]
    values = np.array(
        [*np.degrees(result.boresight_rad), result.camera.fx_px, k1, k2, result.clock_offset_s], dtype=np.float64
    )
    _report(values, covariance, result.is_determined)
    held_out = result.held_out
    typer.echo(
        f"{result.points} points in {result.images} images; median residual {result.before_px:.2f} px before, "
        f"{result.after_px:.2f} px after, with corrected poses; in images left out of the fit, with poses as recorded, "
        f"{held_out.before_px:.2f} px before, {held_out.after_px:.2f} px after"
    )
    doubts = _doubts(result, sigmas, drift_m)
    for doubt in doubts:
        typer.echo(doubt, err=True)
    if doubts and not force:
        raise InputDataError(
            f"The calibration is doubtful for the reasons above: {out} is not written. Follow them, or write it with "
            "--force, which records the doubts in the file."
        )
    not_determined = [name for name, is_known in zip(PARAMETERS, result.is_determined, strict=True) if not is_known]
    left_out = [held_out.before_px, held_out.after_px]
    statistics = {
        "not_determined": not_determined,
        "images": result.images,
        "points": result.points,
        "median_residual_px": [result.before_px, result.after_px],
        "held_out_residual_px": left_out if np.isfinite(left_out).all() else None,
        "doubts": doubts,
    }
    document = calibration_document(result.camera, result.boresight_rad, result.clock_offset_s, covariance, statistics)
    with written_whole(out) as file:
        file.write(encode_calibration(document))


def _doubts(result: Result, sigmas: tuple[float, float], drift_m: float) -> list[str]:
    """Return the reasons to doubt a calibration, each with its remedy."""
    doubts = _pose_doubts(sigmas, (result.position_error_sigmas, result.attitude_error_sigmas))
    if result.position_error_sigmas > MAX_ERROR_SIGMAS and not drift_m:
        doubts.append("Positions of receivers without corrections also drift between lines: add --position-drift 2.")
    before_px, after_px = result.held_out.before_px, result.held_out.after_px
    surprising = [label for label, is_far in zip(_LABELS, result.is_surprising, strict=True) if is_far]
    if surprising:
        is_borne_out = after_px < (1.0 - _LARGE_GAIN) * before_px
        doubts.append(
            f"Far from the given values: {', '.join(surprising)}. Check poses, --convention and field of view."
            + (" Images left out of the fit bear it out: --force is right where these were guesses." * is_borne_out)
        )
    if math.isnan(before_px):
        doubts.append("No stretch of the flight has enough points to try the result on: take more images.")
    elif after_px > (1.0 - MIN_GAIN) * before_px:
        doubts.append(
            f"Images left out of the fit are described no better: median residual {before_px:.2f} px by the given "
            f"camera, {after_px:.2f} px by the calibration. Keep the given one, or fly opposite and crossing lines at "
            "two heights; errors of single poses are corrected by --poses-out."
        )
    return doubts


def _photographs_document(folder: Path, survey: Survey, sigmas: tuple[float, float]) -> dict[str, object]:
    """Return a poses file of photographs with the corrected poses."""
    camera = _one_camera(survey)
    images = [
        (image.path.relative_to(folder).as_posix(), pose, image.taken_at_s)
        for image, pose in zip(survey.images, _refine(survey, sigmas), strict=True)
    ]
    return poses_document(images, survey.origin, camera)


def _one_camera(survey: Survey) -> CameraModel:
    """Return the camera of all photographs of a survey, which a poses file describes once.

    Raises:
        InputDataError: if they differ by more than their tags are rounded.
    """
    first = survey.images[0]
    for image in survey.images:
        one, other = first.camera, image.camera
        is_of_size = (one.width_px, one.height_px) == (other.width_px, other.height_px)
        if not is_of_size or abs(other.fx_px / one.fx_px - 1.0) > _ALIKE_FOCAL:
            raise InputDataError(
                f"--poses-out describes one camera, but {first.path.name} and {image.path.name} have different sizes "
                "or focal lengths: put photographs of one size and zoom into a folder of their own."
            )
    return first.camera


def _refine(survey: Survey, sigmas: tuple[float, float]) -> tuple[Pose, ...]:
    """Return the corrected poses of a survey, by standard deviations of positions (m) and attitudes (deg)."""
    from aos_gcs.surveys.calibration.refinement import refine_poses  # noqa: PLC0415

    with progress("Comparing images with their neighbours", len(survey.images)) as advance:
        refined = refine_poses(survey, sigmas[0], math.radians(sigmas[1]), advance)
    for doubt in _pose_doubts(sigmas, (refined.position_error_sigmas, refined.attitude_error_sigmas)):
        typer.echo(doubt, err=True)
    typer.echo(
        f"poses of {refined.corrected} of {len(survey.images)} images corrected; median residual "
        f"{refined.before_px:.2f} px before, {refined.after_px:.2f} px after"
    )
    return refined.poses


def _pose_doubts(sigmas: tuple[float, float], errors: tuple[float, float]) -> list[str]:
    """Return in words which recorded poses err by more than they are told to."""
    return [
        f"Recorded poses err by more than {option} says, which bends the result: repeat with {option} "
        f"{sigma * found:.2g} or more."
        for option, sigma, found in zip(("--position-sigma", "--attitude-sigma"), sigmas, errors, strict=True)
        if found > MAX_ERROR_SIGMAS
    ]


def _report(values: NDArray[np.float64], covariance: NDArray[np.float64], is_determined: NDArray[np.bool_]) -> None:
    sigmas = np.sqrt(np.diag(covariance))
    for label, digits, value, sigma, known in zip(_LABELS, _DIGITS, values, sigmas, is_determined, strict=True):
        text = f"{digits.format(value)} ± {digits.format(sigma)}" if known else "not determined by this flight"
        typer.echo(f"{label}: {text}")
