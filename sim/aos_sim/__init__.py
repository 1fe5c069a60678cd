"""The simulated swarm: forest, cameras, vehicles and their autopilots, speaking MAVLink like real ones."""
