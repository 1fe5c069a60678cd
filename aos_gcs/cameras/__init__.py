"""Cameras as files tell them: intrinsics of other programs, and results of calibrations."""
