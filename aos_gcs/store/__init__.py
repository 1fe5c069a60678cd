"""The mission folder: everything is recorded as it happens."""
