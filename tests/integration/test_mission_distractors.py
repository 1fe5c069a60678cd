"""Missions over the simulated forest with animals and stones in it: what they announce are persons, in virtual time.

Vehicles and cameras err as in the field.

The forest is as dense as that of ``aos-gcs sim``, but a quarter as large, and the area is the part of it in which
everything lies. In the first one a deer and a boar are nearer to the launch site than the person.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.airspace.limits import UNLIMITED
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.runtime.simulated.evaluation import HERE_M
from aos_gcs.runtime.simulated.virtual_mission import FlownMission, fly, mission_settings
from aos_sim.errors.model import RTK
from aos_sim.flights.world import SimulatedFlight
from aos_sim.world.scene import Scene, SceneParameters, build_scene

pytestmark = pytest.mark.timeout(600)

IMAGE_SIZE_PX = 320
"""Coarser than a thermal camera, for the sake of time; coarse enough, and a person is as warm as a deer."""
AREA_ENU_M = ((-14.0, 18.0), (14.0, 18.0), (14.0, 40.0), (-14.0, 40.0))
SIDE_M = 50.0


def search(scene: Scene, vehicles: int, detection: DetectionSettings) -> FlownMission:
    flight = SimulatedFlight(scene, RTK, vehicles, IMAGE_SIZE_PX, seed=1)
    settings = mission_settings(flight, vehicles, strategy="aos-apso", seed=0)
    mission = fly(flight, replace(settings, area_enu_m=AREA_ENU_M, detection=detection))
    assert flight.landed == vehicles
    assert flight.min_separation_m is not None
    assert flight.min_separation_m >= UNLIMITED.separation_m
    return mission


def test_animals_on_the_way_are_no_persons_and_the_person_behind_them_is_found() -> None:
    scene = build_scene(SceneParameters(seed=57, animals=3, stones=3, side_m=SIDE_M))
    (person,) = scene.persons
    mission = search(scene, 10, DetectionSettings(look_steps=8, stop_at_first=True))
    findings = mission.snapshot.findings
    assert mission.snapshot.outcome is Outcome.FOUND
    assert len(findings) > 1
    (claim,) = (finding for finding in findings if finding.is_claimed)
    assert math.dist(claim.position_enu_m[:2], person.position_enu_m[:2]) < 1.0
    others_enu_m = np.array([other.position_enu_m[:2] for other in scene.distractors])
    for finding in findings:
        offsets_m = np.linalg.norm(others_enu_m - np.array(finding.position_enu_m[:2]), axis=1)
        # What is no warmer than its surroundings may be of the forest.
        assert finding is claim or finding.kind is FindingKind.OBJECT or offsets_m.min() < HERE_M
        assert finding.stands is (finding is claim)


def test_without_a_person_nothing_is_announced() -> None:
    scene = build_scene(SceneParameters(seed=16, persons=0, animals=3, stones=3, side_m=SIDE_M))
    mission = search(scene, 5, DetectionSettings(look_steps=8))
    assert mission.snapshot.outcome is Outcome.NOT_FOUND
    assert mission.snapshot.covered_fraction == 1.0
    assert mission.snapshot.findings
    assert not any(finding.stands for finding in mission.snapshot.findings)
