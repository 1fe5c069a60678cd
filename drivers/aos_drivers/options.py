"""Options that both drivers have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from aos_drivers.frames.files.fetching import ImageLimits
from aos_drivers.frames.settings import CameraPlan, parse_cameras
from aos_drivers.option_table import OptionTable

_NAMES = (
    "position_hz",
    "image_hosts",
    "max_image_mib",
    "max_image_megapixels",
    "camera",
    "cameras",
)


@dataclass(frozen=True, slots=True)
class DriverOptions:
    """``DriverContext.options`` of either driver."""

    position_hz: float = 5.0
    """Rate of positions requested from each vehicle."""
    image_hosts: tuple[str, ...] = ()
    """Hosts besides the vehicle's own that images may be fetched from."""
    image_limits: ImageLimits = field(default_factory=ImageLimits)
    cameras: CameraPlan = field(default_factory=CameraPlan)

    @classmethod
    def parse(cls, options: Mapping[str, object]) -> DriverOptions:
        """Check and take over the options.

        Raises:
            ConfigurationError: an option is unknown or out of range.
        """
        table, limits = OptionTable(options, "link.options"), ImageLimits()
        table.refuse_unknown(_NAMES)
        return cls(
            position_hz=table.number("position_hz", cls().position_hz, 1.0, 50.0),
            image_hosts=table.texts("image_hosts", "host names"),
            image_limits=ImageLimits(
                max_bytes=int(table.number("max_image_mib", limits.max_bytes / 2**20, 0.01, 1024.0) * 2**20),
                max_pixels=int(table.number("max_image_megapixels", limits.max_pixels / 1e6, 0.01, 250.0) * 1e6),
            ),
            cameras=parse_cameras(table),
        )
