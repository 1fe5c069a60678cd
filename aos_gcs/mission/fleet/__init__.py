"""The mission's vehicles: their tasks, their commands, and the watch over them in flight."""
