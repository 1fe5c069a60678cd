"""Geofences as MAVLink mission items, and their upload and download."""
