"""Reference particle swarm optimisers of functions, behind one ask/tell interface."""
