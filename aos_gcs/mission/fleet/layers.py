"""Places of vehicles in their altitude layers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Layered(Protocol):
    """A vehicle with an altitude layer."""

    @property
    def vehicle_id(self) -> int:
        """System id."""
        ...

    @property
    def layer_height_m(self) -> float | None:
        """Height of its layer above the origin."""
        ...


def in_layers(members: Sequence[Layered], places_enu_m: NDArray[np.float64]) -> dict[int, NDArray[np.float64]]:
    """Return horizontal places, one per vehicle, shape (n, 2), in the vehicles' altitude layers, by id."""
    return {
        member.vehicle_id: np.array([*place_enu_m, member.layer_height_m])
        for member, place_enu_m in zip(members, places_enu_m, strict=True)
    }
