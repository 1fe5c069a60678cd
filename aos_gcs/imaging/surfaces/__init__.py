"""Terrain and meshes as focal surfaces."""
