"""Video streams: receiving them, and the times of their frames."""
