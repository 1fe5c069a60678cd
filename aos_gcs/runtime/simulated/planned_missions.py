"""Missions of the study that fly for a wanted probability of detection, and what their legs promise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.lab.flights import Place
from aos_gcs.lab.search.chosen_legs import choose_legs
from aos_gcs.lab.search.model import forest_of
from aos_gcs.planning.detection.expected_views import expected_views, forest_directions, line_of
from aos_gcs.planning.detection.pod_proposal import propose_pattern
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.legs import ScanLeg
from aos_gcs.planning.plan import apply_plan, plan_of
from aos_gcs.planning.proposal import FREE_GROUND_M
from aos_gcs.planning.settings import MissionSettings


def planned_for(settings: MissionSettings, trees_per_ha: float, pod: float) -> MissionSettings:
    """Return the settings of a mission with the spacings and the speed that the planner proposes.

    Args:
        settings: settings of the mission over level ground.
        trees_per_ha: density of the simulated forest, whose occlusion is known.
        pod: wanted probability of detection of a standing person.

    Raises:
        ConfigurationError: no pattern reaches it.
    """
    plan = replace(plan_of(settings), pod=pod, forest=forest_of(trees_per_ha))
    pattern = propose_pattern(plan, settings.imaging.plane_height_m)
    if pattern is None:
        raise ConfigurationError(
            f"--pod {pod:g} cannot be reached by {settings.vehicles} vehicles at {trees_per_ha:g} trees per hectare: "
            "use more vehicles, or a lower probability."
        )
    # Flown once: without a map of the searched ground, which the study lacks, no gap would be known anyway.
    return apply_plan(settings, replace(pattern.applied_to(plan), pod=None))


def with_chosen_legs(settings: MissionSettings, pod: float) -> tuple[MissionSettings, tuple[ScanLeg, ...]]:
    """Return the settings of a mission with the speed of chosen legs, and these legs.

    The line begins in the place of the area that is nearest to the launch site, the origin, and keeps to the ground
    that the proposed geofence leaves free.

    Args:
        settings: settings that :func:`planned_for` has returned; the line keeps their spacing. Their area is a square
            whose sides run north and east.
        pod: wanted probability of detection of a standing person.

    Raises:
        ConfigurationError: no legs reach it in hours.
    """
    plan, corners_m = plan_of(settings), np.array(settings.area_enu_m, dtype=np.float64)
    middle_m = (corners_m.min(axis=0) + corners_m.max(axis=0)) / 2.0
    half_m = float(np.ptp(corners_m[:, 0])) / 2.0
    launch_m = np.clip(-middle_m, -half_m, half_m)
    about_origin = replace(
        plan,
        area_enu_m=((-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)),
        launch_enu_m=(float(launch_m[0]), float(launch_m[1])),
        lowest_layer_m=plan.lowest_layer_m - settings.imaging.plane_height_m,
    )
    chosen = choose_legs(about_origin, pod, FREE_GROUND_M)
    if chosen is None:
        raise ConfigurationError(
            f"--pod {pod:g} cannot be reached along chosen legs: use more vehicles, a lower probability, or --legs "
            "planned."
        )
    shifted = (
        replace(leg, start_enu_m=(leg.start_enu_m[0] + float(middle_m[0]), leg.start_enu_m[1] + float(middle_m[1])))
        for leg in chosen.legs
    )
    return replace(settings, flight=replace(settings.flight, search_speed_mps=chosen.speed_mps)), tuple(shifted)


def predicted(
    settings: MissionSettings,
    places_enu_m: Sequence[Place],
    postures: Sequence[str],
    legs: Sequence[ScanLeg] = (),
) -> tuple[float, ...]:
    """Return the probability of detection of persons by the views that the legs of a mission give them.

    Args:
        settings: settings that :func:`planned_for` or :func:`with_chosen_legs` has returned.
        places_enu_m: places of the persons.
        postures: their postures, in the simulator's words; one who walks is one who stands.
        legs: legs that are flown; none: those that the mission plans.
    """
    plan, height_m = plan_of(settings), settings.imaging.plane_height_m
    if plan.forest is None or not places_enu_m:
        return ()
    views = expected_views(
        np.array(places_enu_m, dtype=np.float64),
        tuple(legs) or planned_legs(plan, height_m),
        line_of(plan, height_m),
        forest_directions(plan.forest),
    )
    known = [DETECTABILITY[Posture(one) if one in set(Posture) else Posture.STANDING] for one in postures]
    return tuple(
        float(detection_by_views(plan.forest.occlusion, law)[count]) for count, law in zip(views, known, strict=True)
    )
