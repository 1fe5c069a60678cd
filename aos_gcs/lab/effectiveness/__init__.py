"""The study of effectiveness: how often a report of a person is true."""
