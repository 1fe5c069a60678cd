"""The decision of each step: phase and waypoints that follow, looks and splits, and the record that retraces it."""
