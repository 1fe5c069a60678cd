"""Checks of every vehicle before the launch, and the operator's overrides."""
