"""Limits of flight: polygons, separation, detours, and the check of every waypoint."""
