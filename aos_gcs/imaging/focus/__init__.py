"""Autofocus: height and tilt of the focal plane."""
