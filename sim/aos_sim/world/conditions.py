"""Conditions of a day or a night: light, and temperatures of everything in a scene.

The temperatures of bodies are drawn for a cool, hazy morning; conditions shift them. All values are guesses after the
usual ranges: sunlit stones 10 to 30 K above the air, clothes between air and skin, fur nearer to the air than skin, and
cloth and fur in the sun as much warmer as makes them lose what they take in (docs/simulator.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from aos_sim.world.ground import GROUND_TEMPERATURE_CELSIUS
from aos_sim.world.mesh import Material


class Conditions(StrEnum):
    """Weather and time of day."""

    COOL = "cool"
    """A cool, hazy morning: nothing is as warm as skin."""
    CLEAR = "clear"
    """A clear day: stones and stumps in the sun are as warm as skin, or warmer."""
    OVERCAST = "overcast"
    NIGHT = "night"
    WARM = "warm"
    """A warm, clear day: clothes are little warmer than the ground."""


@dataclass(frozen=True, slots=True)
class Climate:
    """Light and temperatures of some conditions."""

    sky: float
    """Light of the sky; with the sun's it makes the albedo of a surface its colour."""
    sun: float
    sun_warming_k: float
    """Warming of leaves, bark and ground in the sun."""
    ambient_k: float
    """Temperature of air, leaves and ground above that of the cool morning."""
    storage: float
    """Excess of stones and stumps over the ground, relative to the cool morning."""
    cloth_warming_k: float = 0.0
    """Warming of black cloth and fur in the sun; brighter ones warm by the share of light that they take in."""

    def temperatures(
        self,
        celsius: NDArray[np.floating],
        material: NDArray[np.uint8],
        albedo_rgb: NDArray[np.floating],
        sunlit: NDArray[np.bool_],
    ) -> NDArray[np.floating]:
        """Return the temperatures of triangles under these conditions.

        Args:
            celsius: those of the cool morning, shape (n,).
            material: values of :class:`Material`, shape (n,).
            albedo_rgb: colours, 0 to 255, shape (n, 3).
            sunlit: whether the sun reaches them, shape (n,).
        """
        stored_k = np.where(
            material == Material.STONE, (self.storage - 1.0) * (celsius - GROUND_TEMPERATURE_CELSIUS), 0
        )
        warming_k = np.where(material <= Material.BARK, self.sun_warming_k * sunlit, 0.0)
        absorbed = 1.0 - albedo_rgb.mean(axis=1) / 255.0
        warming_k += np.where(_IS_CLOTH[material], self.cloth_warming_k * absorbed * sunlit, 0.0)
        return np.asarray(celsius + self.ambient_k * _AMBIENT_SHARES[material] + stored_k + warming_k)


_AMBIENT_SHARES = np.ones(len(Material))
"""Part of the change of the air's temperature that reaches a material: bodies keep theirs, behind fur and clothes."""
_AMBIENT_SHARES[[Material.SKIN, Material.CLOTHING, Material.FUR]] = 0.2, 0.5, 0.6
_IS_CLOTH = np.isin(np.arange(len(Material)), [Material.CLOTHING, Material.FABRIC, Material.FUR])
"""Materials that keep the sun's warmth at their surface."""

CLIMATES: Mapping[Conditions, Climate] = {
    Conditions.COOL: Climate(sky=0.9, sun=0.75, sun_warming_k=0.6, ambient_k=0.0, storage=1.0),
    Conditions.CLEAR: Climate(sky=0.75, sun=0.95, sun_warming_k=3.0, ambient_k=4.0, storage=2.0, cloth_warming_k=18.0),
    Conditions.OVERCAST: Climate(sky=1.1, sun=0.0, sun_warming_k=0.0, ambient_k=1.0, storage=0.3),
    Conditions.NIGHT: Climate(sky=0.03, sun=0.0, sun_warming_k=0.0, ambient_k=-5.0, storage=0.4),
    Conditions.WARM: Climate(sky=0.8, sun=0.9, sun_warming_k=3.5, ambient_k=12.0, storage=1.6, cloth_warming_k=18.0),
}
