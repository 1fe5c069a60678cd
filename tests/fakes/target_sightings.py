"""Sightings of targets, step by step, and a tracker that is shown them."""

from __future__ import annotations

import math

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.geolocation import Uncertainty
from aos_gcs.imaging.model import Blob, BlobView, FocalGrid, Sighting, StepAnalysis
from aos_gcs.imaging.persons.decision import FindingKind, Verdict
from aos_gcs.imaging.step.settings import ImagingSettings
from aos_gcs.mission.search.targets.persons import Judgement
from aos_gcs.mission.search.targets.tracker import TargetTracker
from aos_gcs.planning.settings import DetectionSettings, MissionSettings

SETTINGS = MissionSettings(
    vehicles=2,
    area_enu_m=((0.0, 0.0), (9.0, 0.0), (9.0, 9.0)),
    imaging=ImagingSettings(),
    detection=DetectionSettings(threshold_m2=0.1, found_steps=3, found_radius_m=1.0, found_min_count=3),
    uncertainty=Uncertainty(target_height_m=0.0, target_extent_m=0.1),
)
CAMERA = CameraModel.from_fov(64, 64, math.radians(50.0))
STEP_S = 2.0


class Follower:
    """A tracker that is shown one step after the other; everything is taken for the same."""

    def __init__(self, kind: FindingKind = FindingKind.PERSON) -> None:
        self.tracker, self.now_s = TargetTracker(SETTINGS), 0.0
        probability = {FindingKind.PERSON: 0.9, FindingKind.ANOMALY: None}.get(kind, 0.1)
        self.verdict = Verdict(kind, probability, ("it waves",))

    def observe(self, *sightings: Sighting) -> bool:
        self.now_s += STEP_S
        in_view = self.tracker.observe(analysis(*sightings), self.now_s)
        self.tracker.judge(dict.fromkeys(self.tracker.places_enu_m(), Judgement(self.verdict)))
        return in_view

    def agrees(self) -> bool:
        estimate = self.tracker.estimate()
        return estimate is not None and self.tracker.agrees(estimate.track_id)


def seen(east_m: float, north_m: float, area_m2: float = 0.2, count: int = 3) -> Sighting:
    """A blob that one camera right above it marks."""
    view = BlobView(1, np.array([east_m, north_m]), CAMERA, nadir_pose([east_m, north_m, 35.0]))
    return Sighting(Blob(area_m2, (east_m, north_m, 0.0), count), (view,))


def analysis(*sightings: Sighting) -> StepAnalysis:
    return StepAnalysis(
        grid=FocalGrid(-50.0, 50.0, 1.0, 100, 100, 0.0),
        coverage=np.ones((100, 100), np.uint16),
        anomaly_count=np.zeros((100, 100), np.uint16),
        blob=sightings[0].blob if sightings else None,
        vehicle_ids=(1, 2),
        fitness=np.zeros(2),
        leader_id=1,
        sightings=sightings,
    )
