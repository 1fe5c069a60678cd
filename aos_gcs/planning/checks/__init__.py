"""Checks of plans: what cannot be flown, what may go wrong, and better values."""
