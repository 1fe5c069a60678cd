"""Frames of reference, poses and cameras. docs/conventions.md states every convention used here."""
