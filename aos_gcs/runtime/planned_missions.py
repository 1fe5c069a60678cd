"""Missions of the study that are planned for a wanted probability of detection, and what the plan promises."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aos_gcs.errors import ConfigurationError
from aos_gcs.groundmap.detection import DETECTABILITY, Posture, detection_by_views
from aos_gcs.lab.flights import Place
from aos_gcs.lab.search.model import forest_of
from aos_gcs.planning.estimate import planned_legs
from aos_gcs.planning.expected_views import expected_views, forest_directions, line_of
from aos_gcs.planning.plan import apply_plan, plan_of
from aos_gcs.planning.pod_proposal import propose_pattern
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


def predicted(settings: MissionSettings, places_enu_m: Sequence[Place], postures: Sequence[str]) -> tuple[float, ...]:
    """Return the probability of detection of persons by the views that the legs of a planned mission give them.

    Args:
        settings: settings that :func:`planned_for` has returned.
        places_enu_m: places of the persons.
        postures: their postures, in the simulator's words; one who walks is one who stands.
    """
    plan, height_m = plan_of(settings), settings.imaging.plane_height_m
    if plan.forest is None or not places_enu_m:
        return ()
    views = expected_views(
        np.array(places_enu_m, dtype=np.float64),
        planned_legs(plan, height_m),
        line_of(plan, height_m),
        forest_directions(plan.forest),
    )
    known = [DETECTABILITY[Posture(one) if one in set(Posture) else Posture.STANDING] for one in postures]
    return tuple(
        float(detection_by_views(plan.forest.occlusion, law)[count]) for count, law in zip(views, known, strict=True)
    )
