"""Temperatures of radiometric photographs."""
