"""RGB and thermal images of a simulated world."""

from aos_sim.render.renderer import Renderer

__all__ = ["Renderer"]
