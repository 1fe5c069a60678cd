"""Cameras for vehicles that have none: beside an autopilot in software, seeing the simulated world from its pose."""
