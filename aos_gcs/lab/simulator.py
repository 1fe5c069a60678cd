"""The installed simulator, found through its entry points."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from aos_gcs.errors import ConfigurationError


def simulator_part(group: str, purpose: str) -> Any:
    """Return what the installed simulator offers under a group of entry points.

    Args:
        group: group of the entry points.
        purpose: what it could do, for the message.

    Raises:
        ConfigurationError: no simulator is installed.
    """
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        return point.load()
    raise ConfigurationError(f"No simulator is installed that could {purpose}; install aos-gcs[lab].")
