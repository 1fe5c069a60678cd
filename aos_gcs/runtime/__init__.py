"""Programs put together: the service with its dashboard, simulated missions, and views of recorded steps."""
