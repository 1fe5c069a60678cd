"""Distances at which simulated vehicles stand and fly, and what else follows from how well they know where they are.

Preflight refuses layers and launch points that vehicles could miss by their errors: a study chooses them as a team in
the field would.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from aos_gcs.errors import ConfigurationError
from aos_gcs.lab.worlds import ErrorGrade

MAX_LAUNCH_M = 20.0
"""Greatest distance of launch points."""
_ON_LEVEL_GROUND = {"home altitude": "the launch site is level"}


@dataclass(frozen=True, slots=True)
class Spacing:
    """Distances of vehicles.

    Raises:
        ConfigurationError: a value is out of its range; the text names its option.
    """

    layers_m: float = 2.5
    """Vertical distance of two altitude layers."""
    launch_m: float = 5.0
    """Distance of two launch points."""
    overrides: Mapping[str, str] = field(default_factory=dict)
    """Failed checks that the launch does without, each with the reason.

    Satellites alone tell heights of homes so badly that no layers would bear it: half of the missions would not start.
    What is known of the ground tells that it is level, and the altitudes are set by that."""
    accuracy_m: tuple[float, float] | None = None
    """Horizontal and vertical accuracy of positions that targets are located with, and poses are registered with from
    the frames; None: what missions take it for, without registration."""

    def __post_init__(self) -> None:
        for name, value, high in (("layer", self.layers_m, 100.0), ("launch", self.launch_m, MAX_LAUNCH_M)):
            if not (math.isfinite(value) and 1.0 <= value <= high):
                raise ConfigurationError(f"--{name}-spacing must lie within 1 and {high:g}, but is {value:g}.")


USUAL = Spacing()
"""Distances of vehicles with corrected positions."""
_SPACINGS: Mapping[str, Spacing] = {
    # Heights known to 1.8 m need layers of 7.2 m. Two launch points whose places are each known to 1 m are reported at
    # the 4.9 m that they have to be apart, with twice the deviation to spare, at 8 m.
    ErrorGrade.GNSS: Spacing(7.5, 10.0, _ON_LEVEL_GROUND, (1.0, 1.8)),
}


def spacing_for(errors: str, layers_m: float | None = None, launch_m: float | None = None) -> Spacing:
    """Return the distances for a grade of errors.

    Args:
        errors: grade of the errors of vehicles.
        layers_m: vertical distance of layers in place of the grade's; None: that of the grade.
        launch_m: the same for launch points.

    Raises:
        ConfigurationError: a value is out of its range.
    """
    usual = _SPACINGS.get(errors, USUAL)
    return replace(
        usual,
        layers_m=usual.layers_m if layers_m is None else layers_m,
        launch_m=usual.launch_m if launch_m is None else launch_m,
    )
