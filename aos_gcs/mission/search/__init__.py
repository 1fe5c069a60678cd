"""The search: its phases, and the work on each step; folders hold the parts of that work."""
