"""Parameters of an autopilot: how MAVLink carries them, and how a few are read and written by name."""
