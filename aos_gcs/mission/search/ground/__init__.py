"""The ground that was seen: coverage by frames, and the feeding of the map of searched ground."""
