"""Vehicles behind the port of drivers, without autopilots and links: whole missions in one process, in virtual time."""
