"""Drivers by their names: entry points of installed packages."""

from __future__ import annotations

from importlib.metadata import entry_points

from aos_gcs.errors import ConfigurationError
from aos_gcs.ports import Driver

DRIVER_GROUP = "aos_gcs.drivers"


def load_driver(name: str) -> Driver:
    """Return the driver of this name.

    Raises:
        ConfigurationError: there is none, or the package it needs is not installed.
    """
    points = {point.name: point for point in entry_points(group=DRIVER_GROUP)}
    if name not in points:
        raise ConfigurationError(f"link.driver: unknown driver {name!r}; known are: {', '.join(sorted(points))}.")
    try:
        driver: Driver = points[name].load()
    except ImportError as error:
        raise ConfigurationError(f"link.driver: {name} cannot be loaded ({error}); install what it needs.") from error
    return driver
