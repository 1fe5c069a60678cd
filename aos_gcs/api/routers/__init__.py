"""Groups of routes."""
