"""Wire models, which clients see: one module for each kind of data."""
