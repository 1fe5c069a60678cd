"""The dashboard: what serves it, and its process with the supervisor that replaces it."""
