"""One simulated vehicle: dynamics, flight controller and an autopilot that speaks MAVLink without doing I/O."""
