"""Errors of the vehicles' poses, estimated from overlapping frames."""
