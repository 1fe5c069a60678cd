"""Watches of the monitor: what each looks at in every vehicle in flight, and what it does about it."""
