"""The settings that a recorded mission was flown with."""

from __future__ import annotations

from aos_gcs.config.file import parse_config
from aos_gcs.config.settings import mission_settings
from aos_gcs.errors import ConfigurationError
from aos_gcs.planning.settings import MissionSettings
from aos_gcs.store.reader import MissionReader


def recorded_settings(reader: MissionReader) -> MissionSettings | None:
    """Return the settings of a record; None for one of another version, whose settings mean nothing to this one."""
    configuration = reader.manifest().get("configuration")
    try:
        return mission_settings(parse_config(configuration if isinstance(configuration, dict) else {}))
    except ConfigurationError:
        return None
