"""Ground-control service for camera-drone swarms that see through forest canopy.

The packages, from the inside out:

- ``geometry``: geodesy, poses and cameras (pure functions).
- ``imaging``: Airborne Optical Sectioning: anomaly masks, integral images, visibility.
- ``swarm``: strategies that choose the next positions, behind one ask/tell interface.
- ``ports``: what the core expects of vehicles, cameras and clocks.
- ``mission``: the coordinator that joins them: one explicit state machine, safety before every goto.
- ``store``: the mission folder (SQLite, frames, MAVLink logs).
- ``api``: HTTP and WebSocket for the dashboard; ``cli``: the command line.

Drivers (``aos_drivers``) and the simulator (``aos_sim``) are packages of their own; they depend on the ports,
never the other way round, and are found through entry points.
"""
