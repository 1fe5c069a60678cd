"""Processes beside the flight's: what follows a mission, and workers."""
