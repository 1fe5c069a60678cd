"""Errors of simulated vehicles, for tests that are about something else than these."""

from aos_sim.errors.model import RTK, ErrorModel

POSITIONS_ERR = ErrorModel(position=RTK.position)
"""Positions err as with corrections, and nothing else does: still air, level vehicles, exact cameras."""
