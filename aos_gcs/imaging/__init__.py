"""Airborne Optical Sectioning: from single frames to what is visible below the canopy."""
