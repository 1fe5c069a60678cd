"""The wall of live pictures, and videos of it, each made in a process of its own."""
