"""Vehicles that take off while others fly: they join the swarm, or take the places of those whose batteries run low."""
