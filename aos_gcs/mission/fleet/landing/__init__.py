"""Ways home and down: return, landing, landing places, and what is below."""
