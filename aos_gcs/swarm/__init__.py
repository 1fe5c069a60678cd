"""Strategies that choose where the swarm samples next, behind one ask/tell interface."""
