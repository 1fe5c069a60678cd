"""Wind: it moves vehicles and, between exposures, the trees."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aos_sim.errors.sizes import check_sizes


@dataclass(frozen=True, slots=True)
class Wind:
    """Steady wind with gusts.

    Raises:
        ConfigurationError: a value is negative.
    """

    mean_mps: float = 0.0
    towards_rad: float = math.pi / 2
    """Direction in which the air moves, clockwise from north: eastwards."""
    gust_share: float = 0.2
    """Standard deviation per axis of the gusts as a share of the mean wind."""
    gust_s: float = 3.0
    """Correlation time of the gusts."""
    response: float = 0.1
    """Share of a gust's velocity that a position controller lets through."""
    crown_s: float = 0.01
    """Standard deviation per axis of a tree's sway, at the top of the canopy, in metres per m/s of mean wind."""
    leaf_s: float = 0.01
    """The same of twigs of half a metre."""

    def __post_init__(self) -> None:
        check_sizes(self, "wind", positive=("gust_s",))

    @property
    def mean_enu_mps(self) -> tuple[float, float, float]:
        """Velocity of the air."""
        return (self.mean_mps * math.sin(self.towards_rad), self.mean_mps * math.cos(self.towards_rad), 0.0)

    @property
    def gust_sigma_mps(self) -> float:
        """Standard deviation of one component of the gusts."""
        return self.gust_share * self.mean_mps

    @property
    def sway_m(self) -> tuple[float, float]:
        """Standard deviations of the sway of crowns and of twigs at the top of the canopy, per axis."""
        return self.crown_s * self.mean_mps, self.leaf_s * self.mean_mps
