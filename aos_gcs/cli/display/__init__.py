"""Displays of missions on the terminal."""
