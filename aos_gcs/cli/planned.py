"""Places of a mission that a configuration file plans."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from aos_gcs.errors import ConfigurationError

if TYPE_CHECKING:
    from aos_gcs.geometry.geodesy import GeodeticPosition
    from aos_gcs.planning.settings import MissionSettings


def read_settings(path: Path) -> MissionSettings:
    """Return the settings of a configuration file.

    Raises:
        ConfigurationError: it cannot be read or used.
    """
    from aos_gcs.config.file import read_config  # noqa: PLC0415 - keeps the other commands' help fast
    from aos_gcs.config.settings import mission_settings  # noqa: PLC0415

    return mission_settings(read_config(path))


def planned_places(settings: MissionSettings, name: str) -> tuple[GeodeticPosition, list[GeodeticPosition]]:
    """Return the launch site of a mission, and the corners of its search area.

    Args:
        settings: settings of the mission.
        name: subject of the error's sentence.

    Raises:
        ConfigurationError: the settings lack one of them.
    """
    from aos_gcs.geometry.geodesy import LocalFrame  # noqa: PLC0415 - keeps the other commands' help fast

    if settings.origin is None or not settings.area_enu_m:
        raise ConfigurationError(f"{name}: mission.origin_deg and the search area are needed to know its places.")
    frame = LocalFrame(settings.origin)
    return settings.origin, [frame.to_geodetic((*corner, 0.0)) for corner in settings.area_enu_m]
