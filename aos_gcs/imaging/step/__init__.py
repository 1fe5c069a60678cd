"""One step of the mission: examine its frames, mark anomalies, and judge what is in view."""
