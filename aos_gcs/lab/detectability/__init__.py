"""Calibration of the probability of detection: what single frames show of persons in simulated forests."""
