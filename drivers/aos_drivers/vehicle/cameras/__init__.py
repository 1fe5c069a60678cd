"""Captures of one vehicle: the runner, one source per kind of camera, and what the vehicle reports about exposures."""
