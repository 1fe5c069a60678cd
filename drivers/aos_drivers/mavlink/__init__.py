"""MAVLink driver: real and simulated PX4 and ArduPilot multicopters over UDP, TCP and serial lines.

``open_mavlink`` is the entry point. The protocol lives in modules without I/O (``session`` and what it holds); sockets,
files and HTTP are in ``links``, ``recorder`` and ``imagery``; ``service`` joins them. See docs/drivers.md.
"""

from aos_drivers.mavlink.options import MavlinkOptions
from aos_drivers.mavlink.service import MavlinkFleet, open_mavlink
from aos_drivers.mavlink.vehicle import MavlinkVehicle

__all__ = ["MavlinkFleet", "MavlinkOptions", "MavlinkVehicle", "open_mavlink"]
