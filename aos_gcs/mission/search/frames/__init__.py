"""Frames of a step: taken at rest, taken in as they come, and analysed on the focal plane in use."""
