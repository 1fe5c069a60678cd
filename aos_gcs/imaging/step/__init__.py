"""One step of the mission: integrate its frames, mark anomalies, and judge what is in view."""
