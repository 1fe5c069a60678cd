"""The simulated camera: MAVLink component, image file and image server."""
