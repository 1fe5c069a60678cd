"""MAVSDK driver: the vehicle port over the library ``mavsdk`` (4.1 and newer), beside ``aos_drivers.mavlink``.

``open_mavsdk`` is the entry point. MAVSDK finds the vehicles, reads their telemetry and works their cameras; our own
sockets carry its bytes (``wire``), because its own send every packet to every vehicle and its heartbeat knows nothing
of the service's health. See docs/drivers.md.
"""

from aos_drivers.mavsdk.service import open_mavsdk

__all__ = ["open_mavsdk"]
