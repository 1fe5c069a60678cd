"""Calibration of a camera and its mount by a recorded flight above textured ground."""
