"""A mission's ports between two processes: the flight's, which never waits, and the interface's, which mirrors it."""
