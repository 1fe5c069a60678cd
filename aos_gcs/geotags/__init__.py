"""Where and how a photograph was taken, from the EXIF and XMP that drones write into it.

Independent of where photographs come from: recorded flights and the drivers of real cameras read them alike.
"""
