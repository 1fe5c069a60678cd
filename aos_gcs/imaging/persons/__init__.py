"""Evidence that a warm body is a person."""
