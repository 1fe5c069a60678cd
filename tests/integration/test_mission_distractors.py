"""A mission over the simulated forest with animals and stones in it: what it announces is the person, in virtual time.

The world is that of ``aos-gcs sim --vehicles 5 --seed 1 --animals 3 --stones 3``, the area the strip of it in which two
deer lie nearer to the launch site than the person.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.model.phase import Outcome
from aos_gcs.planning.settings import DetectionSettings
from aos_gcs.runtime.evaluation import HERE_M
from aos_sim.render import Renderer
from aos_sim.world.scene import SceneParameters, build_scene
from tests.fakes.air import Air
from tests.fakes.air_flight import flying_over

pytestmark = [pytest.mark.looptime, pytest.mark.timeout(600)]

STRIP_ENU_M = ((-20.0, 30.0), (20.0, 30.0), (20.0, 50.0), (-20.0, 50.0))


async def test_deer_on_the_way_are_no_persons_and_the_person_behind_them_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = build_scene(SceneParameters(seed=1, animals=3, stones=3))
    (person,) = scene.persons
    changes = {"area_enu_m": STRIP_ENU_M, "imaging": ImagingSettings(), "image_size_px": 192}
    detection = DetectionSettings(look_steps=6, stop_at_first=True)
    async with flying_over(monkeypatch, Air(), 5, scene=Renderer(scene), detection=detection, **changes) as flight:
        assert await flight.run is Outcome.FOUND
    findings = flight.mission.view.snapshot().findings
    (claim,) = (finding for finding in findings if finding.is_claimed)
    assert math.dist(claim.position_enu_m[:2], person.position_enu_m[:2]) < 1.0
    assert len([text for text in flight.texts() if text.startswith("Possible person")]) == 1
    others_enu_m = np.array([other.position_enu_m[:2] for other in scene.distractors])
    for finding in findings:
        offsets_m = np.linalg.norm(others_enu_m - np.array(finding.position_enu_m[:2]), axis=1)
        assert finding is claim or offsets_m.min() < HERE_M
        assert finding.stands is (finding is claim)
