"""RGB and thermal images of a simulated world."""

from aos_sim.render.renderer import PersonMasks, Renderer

__all__ = ["PersonMasks", "Renderer"]
