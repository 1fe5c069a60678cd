"""The scan: legs and progress on them, stretches that are blocked or flown again, and the line that flies along."""
