"""Dialects of the autopilots: one class each for commands, one each for settings."""
