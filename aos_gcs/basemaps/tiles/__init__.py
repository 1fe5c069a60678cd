"""Tiles of servers: their addresses, requests for them, the pictures that they are, and where they are kept."""
