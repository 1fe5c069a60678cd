"""Live sharing with the systems of others: it sees a mission and commands nothing."""
