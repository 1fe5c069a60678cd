"""Results in the formats of other programs: maps for a GIS, findings for everyone."""
