"""MAVLink driver: real and simulated PX4 and ArduPilot multicopters over UDP, TCP and serial lines.

``open_mavlink`` is the entry point. ``session`` holds the protocol and does no I/O, ``service`` joins it with the
links, the recorder and the cameras; ``signing`` and ``doctor`` are folders. See docs/drivers.md.
"""

from aos_drivers.mavlink.service import open_mavlink

__all__ = ["open_mavlink"]
