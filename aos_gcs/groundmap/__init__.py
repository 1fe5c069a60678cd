"""Searched ground: which places of the forest floor were looked at, from how many directions, and what that shows."""
