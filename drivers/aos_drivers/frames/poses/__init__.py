"""Pose of a camera at exposure: motion of the vehicle, mount, clocks, and plausibility."""
