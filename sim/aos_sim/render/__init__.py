"""RGB and thermal images of a simulated world."""

from aos_sim.render.renderer import PersonMasks, RenderedFrame, Renderer

__all__ = ["PersonMasks", "RenderedFrame", "Renderer"]
