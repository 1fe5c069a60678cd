"""Settings of this driver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from aos_gcs.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class MavlinkOptions:
    """``DriverContext.options`` of this driver."""

    position_hz: float = 5.0
    """Rate of positions that each vehicle is asked for."""
    camera_fov_deg: float | None = None
    """Horizontal field of view of every camera; overrides what the cameras say."""
    image_hosts: tuple[str, ...] = ()
    """Hosts besides the vehicle's own that images may be fetched from."""
    max_image_mib: float = 64.0

    @classmethod
    def parse(cls, options: Mapping[str, object]) -> MavlinkOptions:
        """Check and take over the options.

        Raises:
            ConfigurationError: an option is unknown or out of range.
        """
        known = [field.name for field in fields(cls)]
        unknown = sorted(set(options) - set(known))
        if unknown:
            raise ConfigurationError(f"unknown option {unknown[0]!r} of the mavlink driver: use {', '.join(known)}")
        fov_deg = options.get("camera_fov_deg")
        return cls(
            position_hz=_number(options, "position_hz", cls().position_hz, 1.0, 50.0),
            camera_fov_deg=None if fov_deg is None else _number(options, "camera_fov_deg", 0.0, 1.0, 179.0),
            image_hosts=_texts(options, "image_hosts"),
            max_image_mib=_number(options, "max_image_mib", cls().max_image_mib, 0.01, 1024.0),
        )


def _number(options: Mapping[str, object], name: str, default: float, low: float, high: float) -> float:
    value = options.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ConfigurationError(
            f"option {name} of the mavlink driver must be a number of {low} to {high}, got {value!r}"
        )
    return float(value)


def _texts(options: Mapping[str, object], name: str) -> tuple[str, ...]:
    value = options.get(name, ())
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, str) for item in value):
        raise ConfigurationError(f"option {name} of the mavlink driver must be a list of host names, got {value!r}")
    return tuple(value)
