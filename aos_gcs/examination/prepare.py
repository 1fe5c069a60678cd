"""What a recording is examined with: windows, ground, and the errors of its poses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from aos_gcs.errors import InputDataError
from aos_gcs.examination.examiner import Examination
from aos_gcs.examination.search import ExaminationSettings
from aos_gcs.examination.windows import examined_ground, plan_windows
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.views import FocalSurface
from aos_gcs.surveys.model import Survey
from aos_gcs.surveys.seen_ground import ground_height_m, seen_ground
from aos_gcs.surveys.window_anomalies import Detection


def prepared(survey: Survey, surface: FocalSurface, detection: Detection, terrain_name: str = "") -> Examination:
    """Return the examination of a recording.

    Args:
        survey: recording in an east-north-up world.
        surface: ground, in that world.
        detection: detector, and its limits.
        terrain_name: name of the file with the heights of the ground, for texts.

    Raises:
        InputDataError: the ground is below no image.
    """
    ground_m = ground_height_m(survey.images, surface)
    if math.isnan(ground_m):
        raise InputDataError("No image was taken above the terrain: check that both are in the same world.")
    windows = plan_windows(survey.images, ground_m)
    # The rate is that of the survey: what several windows examine is given to chance as often.
    seen = seen_ground(survey.images, surface, ground_m)
    examined = examined_ground(seen, [window.frames for window in windows])
    rate_per_ha = detection.false_alarms_per_ha / examined.windows_per_place
    settings = ExaminationSettings(replace(detection, false_alarms_per_ha=rate_per_ha), _uncertainty(survey))
    # A thermal recording is a grey picture to its files.
    bands = ("thermal",) if survey.bands == ("grey",) else survey.bands
    return Examination(survey, bands, surface, windows, settings, ground_m, terrain_name)


def _uncertainty(survey: Survey) -> Uncertainty:
    """Return the errors of positions, those of missions where the recording does not tell its own."""
    sigmas_m = [image.position_sigma_m for image in survey.images if image.position_sigma_m is not None]
    if not sigmas_m:
        return Uncertainty()
    east_m, north_m, up_m = np.median(np.array(sigmas_m), axis=0)
    return Uncertainty(
        position_horizontal_m=float(math.hypot(east_m, north_m) / math.sqrt(2.0)), position_vertical_m=float(up_m)
    )
