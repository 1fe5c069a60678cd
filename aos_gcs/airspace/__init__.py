"""Where vehicles may fly, and how far apart: polygons, separation, detours, and the check of every waypoint."""
