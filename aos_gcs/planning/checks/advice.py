"""Advice on a plan: better values for single fields, each with its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from aos_gcs.imaging.aperture import AperturePlan, plan_aperture
from aos_gcs.planning.detection.aperture import SATURATION
from aos_gcs.planning.detection.pod_proposal import FASTEST_MPS, SearchPattern, propose_pattern
from aos_gcs.planning.estimate import estimate_flights, planned_leg_count, planned_legs
from aos_gcs.planning.legs import in_passes
from aos_gcs.planning.plan import MissionPlan
from aos_gcs.planning.search_settings import SearchMode
from aos_gcs.planning.terrain.viewed_ground import LEVEL_GROUND, ViewedGround
from aos_gcs.swarm.registry import make_strategy

MIN_LAYERS_WITHOUT_RTK_M: Final = 3.0
"""Barometers and GPS heights of two vehicles differ by more than a metre."""
_HEADINGS: Final = tuple(math.radians(heading_deg) for heading_deg in range(0, 180, 5))
_WORTH_TURNING: Final = 0.95
"""Share of the present duration of the flight below which another heading is proposed."""
_SPACING_TOLERANCE: Final = 0.05
_PATTERN_TOLERANCE: Final = 0.05
"""Difference from a proposed spacing or speed, in metres or m/s, that is rounding."""
_QUICK_RATE_HZ: Final = 3.0
"""Frame rate that is proposed; whole searches in the laboratory tell what it gains."""
_WORTH_FRAMES: Final = 0.95
"""Share of the present duration of the flight below which more frames per second are proposed."""


@dataclass(frozen=True, slots=True)
class ProposedValue:
    """Another value for one field."""

    field: str
    """Name of the field of ``MissionPlan``."""
    value: float
    """Proposed value in the field's own unit."""
    reason: str


def propose(plan: MissionPlan, plane_height_m: float, ground: ViewedGround = LEVEL_GROUND) -> tuple[ProposedValue, ...]:
    """Return better values for a plan without blocking problems; none where it is as proposed.

    Args:
        plan: as it is.
        plane_height_m: height of the focal plane above the ground.
        ground: ground of the area, below the layers.

    Raises:
        ConfigurationError: the plan cannot be flown.
    """
    pattern = propose_pattern(plan, plane_height_m, ground)
    found = [_heading(plan, plane_height_m), *_aperture(plan, plane_height_m), _layers(plan)]
    if pattern is None:
        found.append(_search_speed(plan))
    else:
        found += [*_pattern(plan, pattern), _rate(plan, plane_height_m, pattern)]
    return tuple(proposal for proposal in found if proposal is not None)


def forest_aperture(plan: MissionPlan, plane_height_m: float) -> AperturePlan | None:
    """Return the aperture that suits a plan's forest; None without a forest.

    Raises:
        ConfigurationError: the vehicles would fly below the tree tops, or the forest's values contradict one another.
    """
    forest = plan.forest
    if forest is None:
        return None
    return plan_aperture(
        altitude_m=plan.lowest_layer_m - plane_height_m,
        fov_rad=plan.camera_fov_rad,
        canopy_height_m=forest.canopy_height_m,
        crown_base_m=forest.crown_base_m,
        occluder_size_m=forest.occluder_size_m,
        occlusion=forest.occlusion,
        saturation=SATURATION,
        layer_spacing_m=plan.layer_spacing_m,
    )


def _heading(plan: MissionPlan, plane_height_m: float) -> ProposedValue | None:
    present = in_passes(planned_legs(plan, plane_height_m), plan.passes)
    # More legs are more turns: never better, and a long area may have very many.
    headings = [rad for rad in _HEADINGS if plan.passes * planned_leg_count(plan, plane_height_m, rad) <= len(present)]
    legs_of = {rad: in_passes(planned_legs(plan, plane_height_m, rad), plan.passes) for rad in headings}
    if not legs_of:
        return None
    present_s, *others_s = (one.duration_s for one in estimate_flights(plan, [present, *legs_of.values()]))
    best_s, best_rad = min(zip(others_s, legs_of, strict=True))
    if best_s > _WORTH_TURNING * present_s:
        return None
    better, worse = _figures(plan, len(legs_of[best_rad]), best_s), _figures(plan, len(present), present_s)
    return ProposedValue(
        "scan_heading_rad", best_rad, f"Heading {math.degrees(best_rad):.0f}°: {better}, against {worse}."
    )


def _figures(plan: MissionPlan, legs: int, flight_s: float) -> str:
    """Return the figures of a flight as the estimate of a plan shows them, so that both can be compared."""
    minutes, seconds = divmod(math.floor(flight_s), 60)
    hours, minutes = divmod(minutes, 60)
    time = f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes:02}:{seconds:02}"
    battery = 100.0 * flight_s / plan.endurance_s
    return f"{legs} {'leg' if legs == 1 else 'legs'}, {time}, {battery:.0f} % of the battery"


def _aperture(plan: MissionPlan, plane_height_m: float) -> list[ProposedValue]:
    """Propose number and spacing for the forest."""
    aperture = forest_aperture(plan, plane_height_m)
    if aperture is None:
        return []
    proposals = []
    spacing_reason, number_reason, *_ = aperture.reasons
    present_m = make_strategy(plan.strategy, plan.parameters).spacing_m
    if abs(present_m - aperture.spacing_m) > _SPACING_TOLERANCE * aperture.spacing_m:
        proposals.append(ProposedValue("spacing_m", aperture.spacing_m, spacing_reason))
    if plan.vehicles < aperture.drones:
        proposals.append(ProposedValue("vehicles", aperture.drones, number_reason))
    return proposals


def _search_speed(plan: MissionPlan) -> ProposedValue | None:
    """Propose a speed at which a camera's exposures lie as close along the leg as the vehicles do across it."""
    if plan.search_mode is not SearchMode.CONTINUOUS:
        return None
    apart_m, spacing_m = plan.leg_speed_mps / plan.rate_hz, make_strategy(plan.strategy, plan.parameters).spacing_m
    if apart_m <= (1.0 + _SPACING_TOLERANCE) * spacing_m:
        return None
    reason = (
        f"Search speed: at {plan.leg_speed_mps:g} m/s and {plan.rate_hz:g} frames per second a camera's frames are "
        f"{apart_m:.1f} m apart, more than the vehicles, {spacing_m:g} m: the ground is seen through fewer gaps."
    )
    return ProposedValue("search_speed_mps", spacing_m * plan.rate_hz, reason)


def _pattern(plan: MissionPlan, pattern: SearchPattern) -> list[ProposedValue | None]:
    """Propose the spacings and the speed of the fastest search that reaches the wanted probability of detection."""
    reason = (
        f"For a probability of detection of {plan.pod:.0%}: {{}}. {_figures(plan, pattern.legs, pattern.flight_s)}, "
        f"{pattern.detection:.0%} expected."
    )
    values = {
        "line_spacing_m": (pattern.line_spacing_m, "vehicles {:.1f} m apart along the legs"),
        "leg_spacing_m": (pattern.leg_spacing_m, "legs {:.1f} m apart"),
        "search_speed_mps": (pattern.search_speed_mps, "{:.1f} m/s along the legs"),
    }
    return [
        ProposedValue(field, value, reason.format(text.format(value)))
        for field, (value, text) in values.items()
        if abs((getattr(plan, field) or 0.0) - value) > _PATTERN_TOLERANCE
    ]


def _rate(plan: MissionPlan, plane_height_m: float, pattern: SearchPattern) -> ProposedValue | None:
    """Propose more frames per second: exposures in the same places, and as many views, at a greater speed."""
    if plan.rate_hz >= _QUICK_RATE_HZ:
        return None
    speed_mps = min(pattern.search_speed_mps * _QUICK_RATE_HZ / plan.rate_hz, FASTEST_MPS, plan.cruise_speed_mps)
    flown = replace(pattern.applied_to(plan), search_speed_mps=speed_mps, rate_hz=_QUICK_RATE_HZ)
    legs = in_passes(planned_legs(flown, plane_height_m), flown.passes)
    (flight,) = estimate_flights(flown, [legs])
    if flight.duration_s > _WORTH_FRAMES * pattern.flight_s:
        return None
    better, worse = (_figures(plan, len(legs), took_s) for took_s in (flight.duration_s, pattern.flight_s))
    reason = (
        f"Frame rate: at {_QUICK_RATE_HZ:g} frames per second the same places are seen at {speed_mps:.1f} m/s: "
        f"{better}, against {worse}. Slower cameras slow the search down."
    )
    return ProposedValue("rate_hz", _QUICK_RATE_HZ, reason)


def _layers(plan: MissionPlan) -> ProposedValue | None:
    if plan.layer_spacing_m >= MIN_LAYERS_WITHOUT_RTK_M:
        return None
    reason = "Layers: heights of vehicles without RTK differ by more than a metre."
    return ProposedValue("layer_spacing_m", MIN_LAYERS_WITHOUT_RTK_M, reason)
