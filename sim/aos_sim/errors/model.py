"""The error model as a whole, in grades; docs/simulator.md gives the sources of the values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from aos_gcs.errors import ConfigurationError
from aos_sim.errors.attitude import AttitudeErrors
from aos_sim.errors.gimbal import GimbalErrors
from aos_sim.errors.optics import OpticsErrors
from aos_sim.errors.position import PositionErrors
from aos_sim.errors.thermal import ThermalErrors
from aos_sim.errors.timing import TimingErrors
from aos_sim.errors.wind import Wind


class Grade(StrEnum):
    """Grade of the errors."""

    NONE = "none"
    """Exact poses, still air, and cameras without errors but white noise."""
    RTK = "rtk"
    """Vehicles and cameras as in the field, positions with corrections from a base."""
    GNSS = "gnss"
    """The same, positions by satellites alone."""


@dataclass(frozen=True, slots=True)
class ErrorModel:
    """Everything in which a simulated vehicle and its camera differ from ideal ones."""

    position: PositionErrors = field(default_factory=PositionErrors)
    attitude: AttitudeErrors = field(default_factory=AttitudeErrors)
    gimbal: GimbalErrors = field(default_factory=GimbalErrors)
    timing: TimingErrors = field(default_factory=TimingErrors)
    wind: Wind = field(default_factory=Wind)
    thermal: ThermalErrors = field(default_factory=lambda: ThermalErrors(netd_k=0.08))
    optics: OpticsErrors = field(default_factory=lambda: OpticsErrors(colour_noise=2.0))

    def with_wind(self, mean_mps: float | None) -> ErrorModel:
        """Return the model with another mean wind; None leaves it as it is.

        Raises:
            ConfigurationError: the wind is negative.
        """
        return self if mean_mps is None else replace(self, wind=replace(self.wind, mean_mps=mean_mps))


NONE = ErrorModel()
RTK = ErrorModel(
    position=PositionErrors(
        bias_m=(0.01, 0.02), drift_m=(0.01, 0.02), drift_s=30.0, white_m=(0.003, 0.005), barometer_m=0.2
    ),
    attitude=AttitudeErrors(
        tilt_bias_rad=math.radians(0.7),
        tilt_drift_rad=math.radians(0.3),
        heading_bias_rad=math.radians(2.9),
        heading_drift_rad=math.radians(0.7),
        drift_s=60.0,
    ),
    gimbal=GimbalErrors(
        tilt_rad=math.radians(0.7), pan_rad=math.radians(0.5), jitter_rad=math.radians(0.1), lag_s=0.05
    ),
    timing=TimingErrors(delay_s=0.03, clock_s=0.03, jitter_s=0.01),
    wind=Wind(mean_mps=3.0),
    thermal=ThermalErrors(
        netd_k=0.08,
        offset_k=1.0,
        shading_k=0.3,
        column_k=0.05,
        pixel_k=0.03,
        nuc_period_s=180.0,
        nuc_step_k=0.2,
        drift_k_per_min=0.1,
    ),
    optics=OpticsErrors(
        thermal_blur_px=0.55,
        colour_blur_px=0.5,
        colour_noise=2.0,
        vignetting=0.3,
        exposure_s=0.004,
        thermal_lag_s=0.01,
        jpeg_quality=90,
    ),
)
GNSS = replace(
    RTK,
    position=PositionErrors(
        fix_type=mavlink.GPS_FIX_TYPE_3D_FIX,
        bias_m=(0.8, 1.5),
        drift_m=(0.6, 1.0),
        drift_s=120.0,
        white_m=(0.02, 0.03),
        smoothing_s=1.0,
        barometer_m=0.3,
    ),
)
GRADES: Mapping[str, ErrorModel] = {Grade.NONE: NONE, Grade.RTK: RTK, Grade.GNSS: GNSS}


def error_model(grade: str, option: str = "--errors") -> ErrorModel:
    """Return the model of a grade.

    Args:
        grade: value of :class:`Grade`.
        option: name of the field that it comes from, for messages.

    Raises:
        ConfigurationError: there is no such grade.
    """
    if grade not in GRADES:
        raise ConfigurationError(f"{option} must be one of {', '.join(Grade)}, got {grade!r}.")
    return GRADES[grade]
