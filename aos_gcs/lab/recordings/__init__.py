"""The detection and the decision of missions on recorded flights whose persons are known."""
