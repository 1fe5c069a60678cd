"""Settings under which temperatures are read from radiometric photographs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class MeasurementConditions:
    """Conditions of a measurement; None: as the camera was set."""

    emissivity: float | None = None
    distance_m: float | None = None
    humidity: float | None = None
    """Relative, 0 to 1."""
    reflected_c: float | None = None
    """Apparent temperature of what the object reflects: of the sky, or of the crowns."""
    air_c: float | None = None


@dataclass(frozen=True, slots=True)
class TemperatureSettings:
    """Conditions of the measurement, and what else reads temperatures."""

    conditions: MeasurementConditions = MeasurementConditions()
    dji_library: Path | None = None
    """Library of DJI's Thermal SDK; None: photographs of DJI give no temperatures."""
