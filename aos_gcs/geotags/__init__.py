"""Geotags: position, attitude and camera of a photograph, from the EXIF and XMP that drones write into it.

Independent of where photographs come from: recorded flights and the drivers of real cameras read them alike.
"""
