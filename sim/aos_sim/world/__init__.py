"""The simulated world: forest, ground and persons, as triangle meshes and textures, deterministic by seed."""
