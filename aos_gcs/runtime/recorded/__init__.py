"""Recorded missions: their steps computed again, their views, and what is made of them for others."""
