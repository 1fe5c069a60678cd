"""Recorded steps to look at: one whose frames show a warm spot above the ground, sharp on one plane only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from aos_gcs.geometry.camera import CameraModel
from aos_gcs.geometry.geodesy import LocalFrame
from aos_gcs.geometry.poses import nadir_pose
from aos_gcs.imaging.model import Frame
from aos_gcs.mission.model.events import Event, EventKind
from aos_gcs.ports import Capture
from aos_gcs.store.recorder import MissionRecorder
from tests.fakes.mission import ORIGIN, ScriptedMission
from tests.fakes.recording import HandClock

CAMERA = CameraModel.from_fov(128, 128, math.radians(50.0))
CAMERAS_EAST_M = (-6.0, -2.0, 2.0, 6.0)
FLYING_HEIGHT_M = 35.0
SPOT_HEIGHT_M = 5.0
"""Height of a warm spot right above the origin of the frame, which is sharp on this plane only."""


async def record_viewed_step(root: Path) -> Path:
    """Record one step of four frames, the plane on the ground, and return the mission's folder."""
    return await record_step(
        root, [_frame(vehicle_id, east_m) for vehicle_id, east_m in enumerate(CAMERAS_EAST_M, start=1)]
    )


async def record_step(root: Path, frames: Sequence[Frame]) -> Path:
    """Record one step of these frames, the plane on the ground, and return the mission's folder."""
    mission = ScriptedMission(HandClock())
    mission.mission_id = "m"
    mission.make_step()
    async with MissionRecorder.create(
        root, mission.mission_id, {"configuration": {}}, notify=lambda _: None
    ) as recorder:
        await recorder.record_event(Event(1, 999.0, EventKind.SNAPSHOT, mission.snapshot()))
        for frame in frames:
            await recorder.record_frame(1, _capture(frame))
        await recorder.record_step(replace(mission.steps()[0], focal_height_m=0.0), {})
    return root / mission.mission_id


def _frame(vehicle_id: int, east_m: float) -> Frame:
    """Noise with a bright, warm spot above the origin."""
    rng = np.random.default_rng(vehicle_id)
    image = np.dstack([rng.normal(100.0, 5.0, (128, 128, 3)), rng.normal(11.0, 0.1, (128, 128))])
    column = round(CAMERA.cx_px - east_m * CAMERA.fx_px / (FLYING_HEIGHT_M - SPOT_HEIGHT_M))
    row = round(CAMERA.cy_px)
    image[row - 1 : row + 2, column - 1 : column + 2] = [250.0, 20.0, 20.0, 30.0]
    image[..., :3] = np.rint(np.clip(image[..., :3], 0, 255))
    pose = nadir_pose([east_m, 0.0, FLYING_HEIGHT_M])
    return Frame(vehicle_id, image.astype(np.float32), ("red", "green", "blue", "thermal"), pose, CAMERA)


def _capture(frame: Frame) -> Capture:
    return Capture(
        vehicle_id=frame.vehicle_id,
        image_index=1,
        utc_s=1000.0 + frame.vehicle_id,
        image=frame.image,
        bands=frame.bands,
        position=LocalFrame(ORIGIN).to_geodetic(frame.pose.position_enu_m),
        R_cam2enu=frame.pose.R_cam2enu,
        camera=frame.camera,
    )
