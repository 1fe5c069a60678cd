"""Recorded flights of any length: read lazily, integrated in tiles, on one machine or many."""
