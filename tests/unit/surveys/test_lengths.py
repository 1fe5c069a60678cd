"""What surveys say of warm things that are longer than a person."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aos_gcs.examination.search import ExaminationSettings, search_window
from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.geometry.projection import Plane, project_points
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import Frame
from aos_gcs.imaging.persons.decision import FindingKind
from aos_gcs.surveys.window_anomalies import Detection

SIZE = 200
CAMERA = CameraModel.from_fov(SIZE, SIZE, math.radians(50.0))
SETTINGS = ExaminationSettings(Detection(), Uncertainty())


def flight(length_m: float, width_m: float, *, degrees: bool = True) -> list[Frame]:
    """A drone that flies north 15 m above cool ground with something warm on it, hottest in the middle."""
    frames = []
    for index in range(14):
        pose = nadir_pose([0.0, 0.4 * index - 2.6, 15.0])
        celsius = np.random.default_rng(index).normal(10.0, 0.4, (SIZE, SIZE, 1))
        for share, kelvin in ((1.0, 14.0), (0.2, 6.0)):
            half = np.array([length_m, width_m * (0.5 if share < 1.0 else 1.0), 0.0]) / 2.0 * [share, 1.0, 1.0]
            (left, bottom), (right, top) = np.rint(project_points(np.array([-half, half]), CAMERA, pose)).astype(int)
            celsius[top : max(bottom, top + 1), max(left, 0) : right] += kelvin
        frames.append(Frame(index + 1, celsius.astype(np.float32), ("thermal",), pose, CAMERA))
    return frames if degrees else [grey(frame) for frame in frames]


def grey(frame: Frame) -> Frame:
    return replace(frame, image=np.clip(4.0 * frame.image, 0.0, 255.0).astype(np.uint8))


@pytest.mark.parametrize(("degrees", "probability"), [(True, 0.01), (False, None)])
def test_a_hot_conductor_is_no_person(degrees: bool, probability: float | None) -> None:
    (line,) = search_window(flight(9.0, 0.06, degrees=degrees), Plane(0.0), SETTINGS).candidates
    assert line.verdict.kind is FindingKind.WARM_OBJECT
    assert line.verdict.probability == probability
    assert line.verdict.reasons[0] == "9 m long: longer than a person"


@pytest.mark.parametrize(("degrees", "kind"), [(True, FindingKind.PERSON), (False, FindingKind.ANOMALY)])
def test_a_body_of_a_persons_length_is_judged_by_its_warmth(degrees: bool, kind: FindingKind) -> None:
    (body,) = search_window(flight(1.7, 0.4, degrees=degrees), Plane(0.0), SETTINGS).candidates
    assert body.verdict.kind is kind
    assert not any("longer than a person" in reason for reason in body.verdict.reasons)
