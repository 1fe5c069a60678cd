"""The laboratory: swarm strategies compared in simulated forests, repeatably."""
