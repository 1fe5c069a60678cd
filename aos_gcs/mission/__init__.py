"""The mission: coordinator, phases, safety, plan."""
