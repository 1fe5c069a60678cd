"""Whether spacing, number and layers of the vehicles suit the forest: advice before the start, with its numbers."""

from __future__ import annotations

from dataclasses import dataclass

from aos_gcs.imaging.aperture import AperturePlan, plan_aperture, samples_for
from aos_gcs.planning.settings import ForestSettings, MissionSettings
from aos_gcs.swarm.registry import make_strategy

SATURATION = 0.95
"""Share of the visibility of infinitely many vehicles that counts as enough."""


@dataclass(frozen=True, slots=True)
class ApertureAdvice:
    """The mission's own aperture beside what the statistics of :mod:`aos_gcs.imaging.aperture` propose."""

    spacing_m: float
    """c4 of the strategy."""
    needed: int
    """Vehicles that see ``SATURATION`` of what infinitely many would."""
    plan: AperturePlan
    """Aperture for the mission's number of vehicles and layers."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Shortcomings, each with the remedy."""
        plan = self.plan
        found = []
        if self.spacing_m < plan.spacing_m:
            found.append(
                f"c4 of {self.spacing_m:g} m is below the smallest useful spacing of {plan.spacing_m:.1f} m: "
                "neighbours share occluders; raise c4 or fly lower"
            )
        if 1 < plan.drones < self.needed:
            found.append(
                f"{plan.drones} vehicles reach {plan.saturation:.0%} of the possible visibility of the integral: "
                f"{self.needed} reach {SATURATION:.0%}"
            )
        if plan.samples_in_view < plan.drones:
            found.append(
                f"gathered over a target, only {plan.samples_in_view} of {plan.drones} have it in view: fly higher or "
                "lower c4"
            )
        return tuple(found)

    @property
    def seen(self) -> str:
        """Share of the ground that is seen."""
        plan = self.plan
        if plan.drones == 1:
            return (
                f"c4 {self.spacing_m:g} m (useful from {plan.spacing_m:.1f} m), one vehicle, which makes its aperture "
                f"by moving: one image sees {plan.single_visibility:.0%} of the ground"
            )
        return (
            f"c4 {self.spacing_m:g} m (useful from {plan.spacing_m:.1f} m), {plan.drones} vehicles: at most "
            f"{plan.seen_at_least_once:.0%} of the ground seen, one image {plan.single_visibility:.0%}"
        )

    @property
    def text(self) -> str:
        """One line for the operator."""
        return "; ".join((self.seen, *self.warnings))


def advise(settings: MissionSettings, forest: ForestSettings) -> ApertureAdvice:
    """Compare a mission's aperture with the one that suits a forest.

    Raises:
        ConfigurationError: the vehicles would fly below the tree tops, or the forest is none; the text names the field.
    """
    flight = settings.flight
    plan = plan_aperture(
        altitude_m=flight.lowest_layer_m - settings.imaging.plane_height_m,
        fov_rad=settings.planning_fov_rad,
        canopy_height_m=forest.canopy_height_m,
        crown_base_m=forest.crown_base_m,
        occluder_size_m=forest.occluder_size_m,
        occlusion=forest.occlusion,
        saturation=SATURATION,
        layer_spacing_m=flight.layer_spacing_m,
        drones=settings.vehicles,
    )
    spacing_m = make_strategy(settings.strategy, settings.strategy_parameters).spacing_m
    return ApertureAdvice(spacing_m, max(2, samples_for(forest.occlusion, SATURATION)), plan)
