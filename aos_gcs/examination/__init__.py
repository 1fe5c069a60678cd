"""Recorded flights examined as missions judge their frames, and shown as missions are."""
