"""Heights of altitude layers, which all are offset from one reference surface, and places of vehicles in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aos_gcs.airspace.reference_surface import LEVEL, ReferenceSurface
from aos_gcs.geometry.heights import AboveHomeM

FloatArray = NDArray[np.float64]


class Layered(Protocol):
    """A vehicle with an altitude layer."""

    @property
    def vehicle_id(self) -> int:
        """System id."""
        ...

    @property
    def layer_height_m(self) -> float | None:
        """Height of its layer above the reference surface."""
        ...


class Launched(Layered, Protocol):
    """A vehicle with an altitude layer and a launch point."""

    @property
    def home_enu_m(self) -> FloatArray | None:
        """Launch point, shape (3,)."""
        ...


class AltitudeLayers:
    """The heights of all layers, by the surface that they share."""

    def __init__(self) -> None:
        self.surface: ReferenceSurface | None = LEVEL
        """None while it is not known: then no layer has a height."""

    @property
    def follow_ground(self) -> bool:
        """Whether layers are known to be higher at one place than at another."""
        return self.surface is not None and not self.surface.is_level

    def known_surface(self) -> ReferenceSurface:
        """Return the surface.

        Raises:
            RuntimeError: it is not known; a defect of the caller.
        """
        if self.surface is None:
            raise RuntimeError("the surface that the altitude layers follow is not known")
        return self.surface

    def at(self, vehicle: Layered, place_enu_m: FloatArray | None) -> FloatArray | None:
        """Return the point of a vehicle's layer above or below a place, shape (3,); None while it is not known.

        Of the place the first two coordinates count.
        """
        if place_enu_m is None or vehicle.layer_height_m is None or self.surface is None:
            return None
        return np.array([*place_enu_m[:2], vehicle.layer_height_m + self.surface.at(place_enu_m)])

    def above_home_m(self, vehicle: Launched) -> AboveHomeM | None:
        """Return the height above its home of a vehicle's layer there; None while it is not known."""
        home_enu_m, above_enu_m = vehicle.home_enu_m, self.at(vehicle, vehicle.home_enu_m)
        if home_enu_m is None or above_enu_m is None:
            return None
        return AboveHomeM(float(above_enu_m[2] - home_enu_m[2]))

    def return_up_m(self, vehicle: Layered) -> float | None:
        """Return the height above the origin at which a vehicle's autopilot is to return; None while it is not known.

        That is its layer above the highest place of the surface: it clears the ground everywhere, and no two vehicles
        return at the same height.
        """
        if vehicle.layer_height_m is None or self.surface is None:
            return None
        return vehicle.layer_height_m + self.surface.highest_m

    def return_above_home_m(self, vehicle: Launched) -> AboveHomeM | None:
        """Return the height above its home at which a vehicle's autopilot is to return; None while it is not known."""
        return_up_m = self.return_up_m(vehicle)
        if vehicle.home_enu_m is None or return_up_m is None:
            return None
        return AboveHomeM(return_up_m - float(vehicle.home_enu_m[2]))

    def moved(self, point_enu_m: FloatArray, place_enu_m: FloatArray) -> FloatArray:
        """Return a point, shape (3,), moved to another place, shape (2,), as high above the surface as before."""
        rise_m = 0.0 if self.surface is None else self.surface.at(place_enu_m) - self.surface.at(point_enu_m)
        return np.array([*place_enu_m, point_enu_m[2] + rise_m])


def in_layers(members: Sequence[Layered], places_enu_m: FloatArray, surface: ReferenceSurface) -> dict[int, FloatArray]:
    """Return horizontal places, one per vehicle, shape (n, 2), in the vehicles' altitude layers, by id."""
    heights_m = surface.height_m(places_enu_m)
    layers_m = [np.nan if member.layer_height_m is None else member.layer_height_m for member in members]
    return {
        member.vehicle_id: np.array([*place_enu_m, layer_m + height_m])
        for member, place_enu_m, layer_m, height_m in zip(members, places_enu_m, layers_m, heights_m, strict=True)
    }
