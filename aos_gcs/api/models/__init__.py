"""What clients see: one module of wire models for each kind of data."""
