"""Ground-control service for camera-drone swarms that see through forest canopy.

The packages, from the inside out:

- ``geometry``: geodesy, poses and cameras (pure functions).
- ``ports``: protocols and data of vehicles, cameras and clocks, implemented by drivers.
- ``imaging``: Airborne Optical Sectioning: anomaly masks, integral images, visibility.
- ``swarm``: strategies that choose the next positions, behind one ask/tell interface.
- ``airspace``: safety limits, and the vetting of every waypoint.
- ``planning``: settings and plans of missions, checked and estimated.
- ``mission``: the coordinator that joins them, as one explicit state machine.
- ``store``: the mission folder (SQLite, frames, MAVLink logs).
- ``api``: HTTP and WebSocket for the dashboard.
- ``runtime``: service, dashboard and simulated missions; ``cli``: the command line.

ARCHITECTURE.md has the whole table, and which package may import which.

Drivers (``aos_drivers``) and the simulator (``aos_sim``) are packages of their own; they depend on the ports,
never the other way round, and are found through entry points.
"""
