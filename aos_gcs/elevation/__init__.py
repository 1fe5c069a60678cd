"""Elevation models of the ground, offline: heights above mean sea level at any place, from files."""
