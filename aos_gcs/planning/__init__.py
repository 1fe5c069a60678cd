"""Plans before a mission: settings, altitude layers, scan legs, checks, estimates and advice."""
