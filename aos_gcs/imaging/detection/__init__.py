"""Anomaly detectors for single frames."""
