"""Worker processes: computations with a memory and a time limit, whose death costs one result."""
