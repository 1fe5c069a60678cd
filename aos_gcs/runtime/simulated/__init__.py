"""Simulated missions: the demo with its score, and missions in virtual time for studies."""
