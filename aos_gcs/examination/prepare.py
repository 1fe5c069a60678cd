"""What a recording is examined with: windows, ground, and the errors of its poses."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.errors import ConfigurationError, InputDataError
from aos_gcs.examination.examiner import Examination
from aos_gcs.examination.search import SearchSettings
from aos_gcs.examination.windows import ground_height_m, plan_windows
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.surveys.model import Survey


def prepared(survey: Survey, surface: FocalSurface, imaging: ImagingSettings, minimum_count: int) -> Examination:
    """Return the examination of a recording.

    Args:
        survey: recording in an east-north-up world.
        surface: ground, in that world.
        imaging: detector, and its limits.
        minimum_count: frames that must agree on an anomaly.

    Raises:
        ConfigurationError: a frame needs another to agree with.
        InputDataError: the ground is below no image.
    """
    if minimum_count < 1:
        raise ConfigurationError(f"--min-count must be at least 1, got {minimum_count}.")
    ground_m = ground_height_m(survey.images, surface)
    if math.isnan(ground_m):
        raise InputDataError("No image was taken above the terrain: check that both are in the same world.")
    settings = SearchSettings(imaging, minimum_count, DetectionSettings().threshold_m2, _uncertainty(survey))
    # A thermal recording is a grey picture to its files.
    bands = ("thermal",) if survey.bands == ("grey",) else survey.bands
    return Examination(survey, bands, surface, plan_windows(survey.images, ground_m), settings, ground_m)


def _uncertainty(survey: Survey) -> Uncertainty:
    """Return the errors of positions, those of missions where the recording does not tell its own."""
    sigmas_m = [image.position_sigma_m for image in survey.images if image.position_sigma_m is not None]
    if not sigmas_m:
        return Uncertainty()
    east_m, north_m, up_m = np.median(np.array(sigmas_m), axis=0)
    return Uncertainty(
        position_horizontal_m=float(math.hypot(east_m, north_m) / math.sqrt(2.0)), position_vertical_m=float(up_m)
    )
