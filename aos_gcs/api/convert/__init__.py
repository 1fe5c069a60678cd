"""Conversions from the mission's data to wire models."""
